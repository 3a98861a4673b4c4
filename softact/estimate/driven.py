"""Which pressures an estimate goes up to."""

from __future__ import annotations

from softact.errors import SpecError
from softact.spec import Spec


def pressures(spec: Spec) -> dict[str, float]:
    """Cavity (or surface of a geometry without one) -> its last pressure in MPa that is not zero.

    Raises SpecError where no step has a pressure.
    """
    found: dict[str, float] = {}
    for step in spec.steps:
        given = {**(step.pressure or {}), **(step.surface_pressure or {})}
        found |= {name: value for name, value in given.items() if value != 0.0}
    if not found:
        raise SpecError(
            "steps: none has a pressure, and an estimate goes up to one; write for example "
            "pressure: 20 kPa"
        )
    return found


def title(spec: Spec, driven: dict[str, float]) -> tuple[str, float]:
    """Column of curve.csv with the largest of the pressures, and that pressure in MPa."""
    name = max(driven, key=lambda cavity: abs(driven[cavity]))
    several = len(spec.geometry.layout().cavities) > 1
    return (f"pressure_{name}_kPa" if several else "pressure_kPa"), driven[name]

"""Which pressures an estimate goes up to, and what of a spec's loads it leaves out."""

from __future__ import annotations

from softact.errors import SpecError
from softact.loads.several import entries
from softact.spec import Spec

#: The surface that stands for a cavity where the geometry, a tube, has none that is closed.
BORE = "bore"


def pressures(spec: Spec) -> dict[str, float]:
    """Cavity (or bore of a tube) -> its last pressure in MPa that is not zero.

    Raises SpecError where no step has a pressure.
    """
    found: dict[str, float] = {}
    for step in spec.steps:
        given = dict(step.pressure or {})
        if not spec.geometry.layout().cavities:
            given |= {n: p for n, p in (step.surface_pressure or {}).items() if n == BORE}
        found |= {name: value for name, value in given.items() if value != 0.0}
    if not found:
        raise SpecError(
            "steps: none has a pressure in a cavity, and an estimate goes up to one; write for "
            "example pressure: 20 kPa"
        )
    return found


def inside(spec: Spec) -> float:
    """MPa in a sphere or tube. Raises SpecError where it is not pressed from within."""
    (pressure,) = pressures(spec).values()
    if pressure < 0:
        raise SpecError(
            f"steps: {1e3 * pressure:g} kPa: the estimate of {spec.geometry.type} is that of a "
            "pressure inside; under vacuum it may buckle, which only a run tells"
        )
    return pressure


def left_out(spec: Spec, taken: tuple[str, ...]) -> list[str]:
    """What loads or holds the actuator and is no part of the estimate, in a line.

    taken: the loads that are.
    """
    layout, found = spec.geometry.layout(), []
    for step in spec.steps:
        for key, value in step.loads.items():
            if key == "surface_pressure":
                found += [f"pressure on {n}" for n in value if n != BORE or layout.cavities]
            elif key == "payload":
                on = [load.surface or layout.tip for load in entries(value)]
                found += [f"payload on {surface}" for surface in on if surface != layout.tip]
                found += [key] if layout.tip in on and key not in taken else []
            elif key not in taken:
                found.append(key)
    at = [carried.surface or layout.tip for carried in spec.masses or ()]
    found += [f"mass on {name}" for name in at if name != layout.tip or "gravity" not in taken]
    held = [*(spec.supports or ()), *(s for step in spec.steps for s in step.supports or ())]
    ends = (layout.clamp,) if layout.cavities else (layout.clamp, layout.tip)
    planes = layout.symmetry
    found += [f"support of {s.surface}" for s in held if s.surface not in (*ends, *planes)]
    found += [f"obstacle {name}" for name in spec.obstacles]
    return [f"left out: {', '.join(dict.fromkeys(found))}"] if found else []


def title(spec: Spec, driven: dict[str, float]) -> tuple[str, float]:
    """Column of curve.csv with the largest of the pressures, and that pressure in MPa."""
    name = max(driven, key=lambda cavity: abs(driven[cavity]))
    several = len(spec.geometry.layout().cavities) > 1
    return (f"pressure_{name}_kPa" if several else "pressure_kPa"), driven[name]

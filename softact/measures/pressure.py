"""Pressure in each cavity."""

from __future__ import annotations

from typing import TYPE_CHECKING

from softact.measures.base import Measure, per_cavity

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    pressures = snapshot.state["pressure"]
    names = snapshot.layout.cavities
    if not names:
        return {}
    return per_cavity("pressure_<cavity>_kPa", {n: 1e3 * float(pressures.get(n, 0)) for n in names})


PRESSURE = Measure(
    "pressure",
    "pressure above ambient",
    {"pressure_<cavity>_kPa": "pressure in the cavity, above ambient"},
    _evaluate,
)

"""Places of chosen points of the actuator."""

from __future__ import annotations

from typing import TYPE_CHECKING

from softact.measures.base import Measure, vector_columns
from softact.measures.further_fields import COMPONENTS

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    columns: dict[str, float] = {}
    for name, probe in snapshot.probes.items():
        columns |= vector_columns(f"probe_{name}_<xyz>_mm", probe.place(snapshot))
    return columns


def _stresses(snapshot: Snapshot) -> dict[str, float]:
    columns: dict[str, float] = {}
    for name, probe in snapshot.probes.items():
        stress = probe.stress(snapshot)
        columns |= {
            f"probe_{name}_stress_{c}_MPa": float(s)
            for c, s in zip(COMPONENTS, stress, strict=True)
        }
    return columns


PROBES = Measure(
    "probes",
    "places of the points that the spec names under probes",
    {f"probe_<probe>_{c}_mm": f"coordinate {c} of the point" for c in "xyz"},
    _evaluate,
)

PROBE_STRESS = Measure(
    "probe_stress",
    "Cauchy stress at the points that the spec names under probes, from the nodal means",
    {f"probe_<probe>_stress_{c}_MPa": f"component {c} of the stress" for c in COMPONENTS},
    _stresses,
)

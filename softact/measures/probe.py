"""Places of chosen points of the actuator."""

from __future__ import annotations

from typing import TYPE_CHECKING

from softact.measures.base import Measure, vector_columns

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    columns: dict[str, float] = {}
    for name, probe in snapshot.probes.items():
        columns |= vector_columns(f"probe_{name}_<xyz>_mm", probe.place(snapshot))
    return columns


PROBES = Measure(
    "probes",
    "places of the points that the spec names under probes",
    {f"probe_<probe>_{c}_mm": f"coordinate {c} of the point" for c in "xyz"},
    _evaluate,
)

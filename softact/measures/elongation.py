"""How far the tip moves along the axis."""

from __future__ import annotations

from typing import TYPE_CHECKING

from softact.measures.base import Measure

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    if not snapshot.layout.tip:
        return {}
    moved = snapshot.tip.centre_after - snapshot.tip.centre_before
    return {"elongation_mm": float(moved @ snapshot.layout.axis)}


ELONGATION = Measure(
    "elongation",
    "displacement of the tip along the undeformed axis",
    {"elongation_mm": "displacement of the tip's centre along the undeformed axis"},
    _evaluate,
)

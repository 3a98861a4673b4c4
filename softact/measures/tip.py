"""Where the tip is."""

from __future__ import annotations

from typing import TYPE_CHECKING

from softact.measures.base import Measure, vector_columns

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    if not snapshot.layout.tip:
        return {}
    return vector_columns("tip_<xyz>_mm", snapshot.tip.centre_after)


TIP = Measure(
    "tip",
    "position of the centre of the tip's end face",
    {f"tip_{c}_mm": f"{c} coordinate of the centre of the tip's end face" for c in "xyz"},
    _evaluate,
)

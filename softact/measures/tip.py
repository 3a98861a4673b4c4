"""Where the tip is."""

from softact.measures.base import Measure, vector_columns


def _evaluate(snapshot):
    if not snapshot.layout.tip:
        return {}
    return vector_columns("tip_<xyz>_mm", snapshot.tip.centre_after)


TIP = Measure(
    "tip",
    "position of the centre of the tip's end face",
    {f"tip_{c}_mm": f"{c} coordinate of the centre of the tip's end face" for c in "xyz"},
    _evaluate,
)

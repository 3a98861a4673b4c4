"""The place on a page of many runs where one of them is shown: its shape and its values."""

from importlib.resources import files

PLACE = (
    "<div id='onepoint' aria-live='polite'><p class='note'>Click on a point: its values and its "
    "shape are shown here.</p></div>"
)


def style() -> str:
    """CSS of the place, and of a plot beside it (``.pair``)."""
    return (files("softact.sweep") / "point.css").read_text(encoding="utf-8")


def script() -> str:
    """JavaScript with ``showRun``, which fills the place."""
    return (files("softact.sweep") / "point.js").read_text(encoding="utf-8")

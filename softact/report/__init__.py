"""report.html and the pictures of a result folder, from the files in the folder alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import nullcontext, suppress
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from softact.errors import SpecError, reason
from softact.files.text import write_atomic
from softact.results.folder import Results, read
from softact.verdict.reached import reached

if TYPE_CHECKING:
    from softact.report.base import Section
    from softact.report.hot_spots import HotSpot
    from softact.report.pictures import Drawn
    from softact.report.surface import Skin
    from softact.verdict.judge import Verdict

__all__ = ["Extra", "write_report"]


#: Makes a further section of the report from the results.
Extra = Callable[[Results], "Section"]


#: What ``write_report`` takes most of its time to import.
_LOADED = (
    "PIL.Image",
    "matplotlib.backends.backend_agg",
    "matplotlib.figure",
    "softact.report.curvature",
    "softact.report.curves",
    "softact.report.hot_spots",
    "softact.report.material_panel",
    "softact.report.overlay",
    "softact.report.pictures",
    "softact.report.report_page",
    "softact.report.surface",
    "softact.verdict.judge",
)


def load() -> None:
    """Import what ``write_report`` needs, while there is nothing else to do."""
    with suppress(Exception):  # what is missing is told of when the report is made
        for module in _LOADED:
            import_module(module)


def write_report(
    directory: str | Path,
    extra: Sequence[Extra] = (),
    warn: Callable[[str], None] = lambda line: None,
    verdict: Verdict | None = None,
) -> Path:
    """(Re)build report.html, curve.png, states.png and shape.png; returns the report's path.

    extra: further sections; where one raises SpecError, the report says so in its place. Measured
    curves that stand in the folder (``remembered``) have one of their own. warn: called with each
    line that the report has on what is missing or damaged. verdict: on the run, where it has just
    been judged; one without the places that it speaks of is made anew.

    A picture or 3-D view that cannot be made does not stop the rest: the report says which is
    missing and why. Raises SpecError where the folder is not a result folder, DamagedResultError
    where its figures cannot be read.
    """
    # Imported here: a sweep takes a label or a plot from this package, and makes no report.
    from softact.report import (
        curvature,
        curves,
        hot_spots,
        material_panel,
        overlay,
        pictures,
        report_page,
        surface,
    )
    from softact.report.base import plotly
    from softact.report.remembered import remembered
    from softact.verdict.judge import judge

    directory = Path(directory)
    results = read(directory)
    faults = [*results.faults, *results.spec_faults]
    for name in ("curve.png", "states.png", "shape.png"):
        (directory / name).unlink(missing_ok=True)
    view, make_skin = None, cache(lambda: surface.skin(results))
    there = bool(results.increments)
    spots = _spots(results, faults) if there else []
    drawing = pictures.drawing(results, make_skin, spots) if there else nullcontext(_undrawn)
    with drawing as finish:
        try:
            if curves.charts(results):
                write_atomic(directory / "curve.png", curves.picture(results))
        except Exception as error:  # a report without a picture beats no report
            faults.append(f"curve.png is missing: {reason(error)}")
        if there:
            view = _view(results, make_skin, faults)
        along = curvature.write(results, pictures.MOST_STATES)
        plotly()
        if verdict is None or not verdict.has_places:
            verdict = judge(results)
        drawn = finish(_marks(results, verdict))
    faults += [along.fault] if along.fault else []
    if drawn.fault:
        faults.append(f"The pictures of the actuator are missing: {drawn.fault}")
    more, measured = hot_spots.section(results, spots, drawn.spots), []
    try:
        measured = remembered(directory)
    except SpecError as error:
        faults += error.lines
    against: list[Extra] = [partial(overlay.section, several=measured)] if measured else []
    try:
        more += material_panel.sections(results)
    except SpecError as error:
        faults += error.lines
    for make in [*against, *extra]:
        try:
            more.append(make(results))
        except SpecError as error:
            faults += error.lines
    faults = list(dict.fromkeys(faults))
    path = directory / "report.html"
    write_atomic(
        path, report_page.html(results, verdict, view, faults, more, along.plots, drawn.both)
    )
    for line in faults:
        warn(line)
    return path


def _undrawn(marks: Sequence[np.ndarray]) -> Drawn:
    """Of a run without states there is nothing to draw."""
    from softact.report.pictures import Drawn

    return Drawn()


def _spots(results: Results, faults: list[str]) -> list[HotSpot]:
    from softact.report import hot_spots

    try:
        return hot_spots.spots(results)
    except Exception as error:  # as with a picture
        faults.append(f"The hot spots are missing: {reason(error)}")
        return []


def _marks(results: Results, verdict: Verdict) -> list[np.ndarray]:
    """Places to mark in the picture of the state that stands for the run."""
    main = reached(results).main
    return [np.array(r.place) for r in verdict.reasons if r.place is not None and r.row == main]


def _view(results: Results, make_skin: Callable[[], Skin], faults: list[str]) -> dict | None:
    from softact.report import viewer

    try:
        return viewer.pack(results, make_skin())
    except Exception as error:  # as above
        faults.append(f"The 3-D view is missing: {reason(error)}")
        return None

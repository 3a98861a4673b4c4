"""How a report is made, in parts: what its states alone decide can be made while they are judged,
and libraries loaded while they are sought."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, nullcontext, suppress
from dataclasses import dataclass, replace
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np

from softact.errors import SpecError, reason
from softact.files.text import write_atomic
from softact.report import (
    curvature,
    curves,
    frames,
    hot_spots,
    material_panel,
    overlay,
    pictures,
    report_page,
    surface,
    viewer,
)
from softact.report.base import parts, plotly
from softact.report.pictures import Drawn
from softact.report.remembered import remembered
from softact.results.folder import Results, read
from softact.verdict import judge as judging
from softact.verdict.reached import reached

if TYPE_CHECKING:
    from softact.report import Extra
    from softact.report.base import Section
    from softact.report.hot_spots import HotSpot
    from softact.report.surface import Skin
    from softact.verdict.judge import Verdict


#: What pictures take time to import.
_LIBRARIES = "PIL.Image", "matplotlib.backends.backend_agg", "matplotlib.figure"


@dataclass(frozen=True)
class _OfStates:
    """What the states of a run decide. finish: waits for the pictures, see ``pictures.drawing``;
    faults: what is missing and why, and of the materials by themselves."""

    spots: Sequence[HotSpot]
    finish: Callable[..., Drawn]
    view: dict | None
    along: curvature.Drawn
    materials: Sequence[Section]
    faults: Sequence[str]
    material_faults: Sequence[str]


class Report:
    """The report of a result folder. ``prepare`` and ``begin`` may be left out, and may be called
    in another thread, one after the other and before ``write``."""

    def __init__(self, directory: Path):
        self.directory = directory
        self._open = ExitStack()
        self._renderer: frames.Renderer | None = None
        self._begun: _OfStates | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *problem: object) -> None:
        self._open.close()

    def prepare(self) -> None:
        """Load what every report needs, here and in the process that draws."""
        with suppress(Exception):  # what is missing is told of when the report is written
            self._renderer = self._open.enter_context(frames.renderer())
            plotly()
            parts()
            report_page.prepare()
            for name in _LIBRARIES:
                import_module(name)

    def begin(self, status: str) -> None:
        """Make what the states in the folder decide. status: how the run ends, which its run.json
        does not say yet. What is amiss is told when the report is written."""
        try:
            results = read(self.directory)
            self._begun = self._of_states(replace(results, run={**results.run, "status": status}))
        except Exception:  # it is made anew, by a process that has drawn nothing yet
            self._renderer = None

    def _of_states(self, results: Results) -> _OfStates:
        for name in ("curve.png", "states.png", "shape.png"):
            (self.directory / name).unlink(missing_ok=True)
        faults: list[str] = []
        make_skin, there = cache(lambda: surface.skin(results)), bool(results.increments)
        spots = _spots(results, faults) if there else []
        renderer = self._renderer
        if renderer is not None and renderer.process.poll() is not None:
            renderer = None
        drawing = pictures.drawing(results, make_skin, spots, renderer) if there else None
        finish = self._open.enter_context(drawing or nullcontext(_undrawn))
        with ThreadPoolExecutor(1) as beside:
            # Half of it is packing, which lets this thread work.
            packed = beside.submit(_view, results, make_skin) if there else None
            try:
                if curves.charts(results):
                    write_atomic(self.directory / "curve.png", curves.picture(results))
            except Exception as error:  # a report without a picture beats no report
                faults.append(f"curve.png is missing: {reason(error)}")
            along = curvature.write(results, pictures.MOST_STATES)
            materials, wrong = _materials(results)
            view, fault = packed.result() if packed else (None, "")
        faults += [fault] if fault else []
        return _OfStates(spots, finish, view, along, materials, faults, wrong)

    def write(
        self, extra: Sequence[Extra], warn: Callable[[str], None], verdict: Verdict | None
    ) -> Path:
        """Write report.html and what else is missing, see ``softact.report.write_report``."""
        results = read(self.directory)
        made = self._begun or self._of_states(results)
        faults = [*results.faults, *results.spec_faults, *made.faults]
        if verdict is None or not verdict.has_places:
            verdict = judging.judge(results)
        drawn = made.finish(_marks(results, verdict))
        faults += [made.along.fault] if made.along.fault else []
        if drawn.fault:
            faults.append(f"The pictures of the actuator are missing: {drawn.fault}")
        more, measured = hot_spots.section(results, made.spots, drawn.spots), []
        try:
            measured = remembered(self.directory)
        except SpecError as error:
            faults += error.lines
        against: list[Extra] = [partial(overlay.section, several=measured)] if measured else []
        more += made.materials
        faults += made.material_faults
        for make in [*against, *extra]:
            try:
                more.append(make(results))
            except SpecError as error:
                faults += error.lines
        faults = list(dict.fromkeys(faults))
        path = self.directory / "report.html"
        page = (results, verdict, made.view, faults, more, made.along.plots, drawn.both)
        write_atomic(path, report_page.html(*page))
        for line in faults:
            warn(line)
        return path


def _undrawn(marks: Sequence[np.ndarray]) -> Drawn:
    """Of a run without states there is nothing to draw."""
    return Drawn()


def _spots(results: Results, faults: list[str]) -> list[HotSpot]:
    try:
        return hot_spots.spots(results)
    except Exception as error:  # as with a picture
        faults.append(f"The hot spots are missing: {reason(error)}")
        return []


def _marks(results: Results, verdict: Verdict) -> list[np.ndarray]:
    """Places to mark in the picture of the state that stands for the run."""
    main = reached(results).main
    return [np.array(r.place) for r in verdict.reasons if r.place is not None and r.row == main]


def _view(results: Results, make_skin: Callable[[], Skin]) -> tuple[dict | None, str]:
    """The 3-D view, or what is to be said where there is none."""
    try:
        return viewer.pack(results, make_skin()), ""
    except Exception as error:  # as above
        return None, f"The 3-D view is missing: {reason(error)}"


def _materials(results: Results) -> tuple[list[Section], list[str]]:
    """The section on the materials, and what is wrong with them."""
    try:
        return material_panel.sections(results), []
    except SpecError as error:
        return [], list(error.lines)

"""Derivatives of a calibration's predictions by its knobs, from one run that carries them along."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from softact.errors import SoftactError
from softact.fit.knobs import Knob
from softact.measured.curve import Measured, predicted
from softact.sensitivities import stored
from softact.units import conversion

if TYPE_CHECKING:
    from softact.spec import Spec

#: Of a knob's size: a step so small that the interpolation between increments is linear in it.
SMALL = 1e-7


def refusal(spec: Spec, knobs: Sequence[Knob]) -> str:
    """Why a run of this spec carries no derivatives by these knobs; "" where it does."""
    from softact.sensitivities.choosing import Chosen

    try:
        chosen = Chosen(spec, [knob.path for knob in knobs])
        if any(parameter.of_geometry for parameter in chosen.parameters):
            with tempfile.TemporaryDirectory() as folder:
                chosen.job(Path(folder))
    except SoftactError as error:
        return error.lines[0].removeprefix("-p ")
    return ""


def sensitivities(
    folder: Path, curve: Mapping[str, np.ndarray], measured: Measured, knobs: Sequence[Knob]
) -> dict[str, np.ndarray] | None:
    """Column -> (points, knobs) derivatives of what ``predicted`` gives, by the knobs counted in
    their sizes; None where the run has not all of them.

    folder, curve: of the run. The curve is moved by a little of its derivatives and read off anew,
    so the abscissa may move, too.
    """
    here = predicted(curve, measured)
    slopes = _slopes(folder, curve, measured, knobs)
    if here is None or slopes is None:
        return None
    found: dict[str, list[np.ndarray]] = {name: [] for name in measured.names}
    for knob in knobs:
        moved = {name: curve[name] + SMALL * slopes[knob.path, name] for name in measured.values}
        there = predicted({**curve, **moved}, measured)
        if there is None:  # the last point, with the abscissa moved below it
            moved = {n: curve[n] - SMALL * slopes[knob.path, n] for n in measured.values}
            there = predicted({**curve, **moved}, measured)
            if there is None:
                return None
            there = {name: 2 * here[name] - there[name] for name in there}
        for name in measured.names:
            found[name].append((there[name] - here[name]) / SMALL)
    return {name: np.stack(columns, axis=1) for name, columns in found.items()}


def _slopes(
    folder: Path, curve: Mapping[str, np.ndarray], measured: Measured, knobs: Sequence[Knob]
) -> dict[tuple[str, str], np.ndarray] | None:
    """(knob's path, column) -> (rows,) derivative by the knob in its size; None where one is
    missing."""
    sizes = {knob.path: knob for knob in knobs}
    rows = len(curve[measured.x])
    found = {(path, name): np.full(rows, np.nan) for path in sizes for name in measured.values}
    for slope in stored.read(folder):
        knob = sizes.get(slope.parameter)
        if knob is not None and slope.measure in measured.values and slope.row < rows:
            unit = slope.at.partition(" ")[2]
            factor = conversion(knob.unit, unit) if unit else 1.0
            found[knob.path, slope.measure][slope.row] = slope.derivative * factor * knob.size
    for (_, name), values in found.items():
        if name == "step_fraction":  # nothing moves it
            values[:] = 0.0
    whole = all(np.isfinite(values).all() for values in found.values())
    return found if whole else None

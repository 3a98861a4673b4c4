"""What is cut from a test before it is fitted: cycles, toe, ranges, points. Nothing is silent."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import savgol_filter

from softact.errors import SpecError
from softact.fit.rupture import break_at, hold_from
from softact.fit.sheet import TestSheet

if TYPE_CHECKING:
    from softact.fit.data import Test

MIN_POINTS = 5
NOISE = 0.01  # of the range: smaller steps back are the extensometer's, not unloading


class CyclesError(Exception):
    """The stretch turns back; the message says where, without the name of the file."""


def without_break(sheet: TestSheet, x: np.ndarray, y: np.ndarray, messages: list[str]) -> slice:
    """Rows up to the break of the specimen; all where it holds or the user wants the whole."""
    last = None if sheet.whole else break_at(x, y)
    if last is None:
        return slice(None)
    messages.append(
        f"the specimen breaks at a stretch of {x[last]:.4g}: the last {len(x) - 1 - last} of "
        f"{len(x)} points, where the stress falls from {y[last] * 1e3:.4g} to {y[-1] * 1e3:.4g} "
        "kPa, are left out (--whole keeps them)"
    )
    return slice(0, last + 1)


def without_hold(sheet: TestSheet, x: np.ndarray, y: np.ndarray, messages: list[str]) -> slice:
    """Rows up to where the machine stands still at the end, and the material relaxes."""
    first = None if sheet.whole else hold_from(x)
    if first is None:
        return slice(None)
    messages.append(
        f"the stretch stands still at {x[-1]:.4g} over the last {len(x) - first} of {len(x)} "
        f"points, while the stress goes from {y[first] * 1e3:.4g} to {y[-1] * 1e3:.4g} kPa: the "
        "hold is left out (--whole keeps it)"
    )
    return slice(0, first + 1)


def branch(sheet: TestSheet, x: np.ndarray, messages: list[str]) -> slice:
    """Rows to keep: all of a monotonic test, or the loading that the user chose.

    Raises SpecError where the user chose a cycle that is not there, and ``CyclesError`` where the
    stretch turns back and nothing was chosen.
    """
    turns = turning_points(x)
    if sheet.loading or sheet.cycle is not None:
        loadings = [
            slice(a, b + 1) for a, b in pairwise(turns) if abs(x[b] - 1.0) > abs(x[a] - 1.0)
        ]
        which = len(loadings) if isinstance(sheet.cycle, str) else sheet.cycle or 1  # "last"
        if not 1 <= which <= len(loadings):
            raise SpecError(f"{sheet.file}: there is no cycle {which}; {len(loadings)} were found")
        kept = loadings[which - 1]
        messages.append(
            f"loading {which} of {len(loadings)} kept: {kept.stop - kept.start} of {len(x)} points"
        )
        return kept
    if len(turns) > 2:
        turn, after = turns[1], turns[2]
        raise CyclesError(
            f"the stretch turns back at point {turn + 1}, from {x[turn]:.4g} to {x[after]:.4g}: "
            "this looks like unloading or cycles. Give --loading for the first loading or "
            "--cycle last"
        )
    return slice(None)


def turning_points(x: np.ndarray) -> list[int]:
    """Indices of the first point, of every reversal by more than the noise, and of the last."""
    if len(x) < 2:
        return [0]
    limit = NOISE * (np.max(x) - np.min(x))
    turns, extreme, sense = [0], 0, 0
    for i in range(1, len(x)):
        step = x[i] - x[extreme]
        if sense == 0:
            if abs(step) > limit:
                sense, extreme = (1 if step > 0 else -1), i
        elif step * sense >= 0:
            extreme = i
        elif abs(step) > limit:
            turns.append(extreme)
            sense, extreme = -sense, i
    last = extreme if sense and (len(x) - 1 - extreme) else len(x) - 1
    return [*turns, last] if last > turns[-1] else turns


def prepare(sheet: TestSheet, test: Test) -> Test:
    """Return the test with what the sheet asks for: zero, smoothing, toe, range, thinning.

    Each is told in ``messages``. Raises SpecError where it cannot be done.
    """
    x, y, other, messages = test.stretch, test.stress, test.other, list(test.messages)
    if sheet.zero and len(y):
        messages.append(f"stress of the first point, {y[0] * 1e3:.4g} kPa, subtracted")
        y = y - y[0]
    if sheet.smooth:
        if len(y) < sheet.smooth:
            raise SpecError(f"{sheet.file}: fewer points than the smoothing window")
        y = savgol_filter(y, sheet.smooth, 2)
        messages.append(f"stress smoothed (Savitzky-Golay, {sheet.smooth} points, order 2)")
    if sheet.toe and len(y):
        x, y, other = _cut_toe(sheet, sheet.toe, x, y, other, messages)
    window = np.ones(len(x), dtype=bool)
    if sheet.stretch_from is not None:
        window &= x >= sheet.stretch_from
    if sheet.stretch_to is not None:
        window &= x <= sheet.stretch_to
    if not np.all(window):
        messages.append(f"{np.sum(~window)} of {len(x)} points outside the chosen range dropped")
        x, y, other = x[window], y[window], None if other is None else other[window]
    if sheet.points and len(x) > sheet.points:
        chosen = _spread(x, sheet.points)
        messages.append(f"thinned from {len(x)} to {len(chosen)} points")
        x, y, other = x[chosen], y[chosen], None if other is None else other[chosen]
    return replace(test, stretch=x, stress=y, other=other, messages=tuple(messages))


def _cut_toe(
    sheet: TestSheet,
    toe: float,
    x: np.ndarray,
    y: np.ndarray,
    other: np.ndarray | None,
    messages: list[str],
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Drop the toe and move the zero of strain to where the curve above it points.

    toe: stress in MPa at which it ends.
    """
    start = int(np.argmax(np.abs(y) >= toe))
    if abs(y[start]) < toe:
        raise SpecError(f"{sheet.file}: no point reaches the toe stress")
    end = max(start + MIN_POINTS, int(np.searchsorted(np.abs(y), 2 * toe)))
    slope, offset = np.polyfit(x[start:end], y[start:end], 1)
    shift = -offset / slope - 1.0
    messages.append(f"toe: {start} points dropped, zero of strain moved by {shift:.4f}")
    return x[start:] / (1.0 + shift), y[start:], None if other is None else other[start:]


def _spread(x: np.ndarray, count: int) -> np.ndarray:
    """Indices of about ``count`` points evenly spaced in stretch."""
    wanted = np.linspace(np.min(x), np.max(x), count)
    order = np.argsort(x, kind="stable")
    near = np.clip(np.searchsorted(x[order], wanted), 0, len(x) - 1)
    return np.unique(order[near])

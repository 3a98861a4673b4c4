"""How an actuator with inertia answers to loads that are held from the start of a step: how fast it
rises, how far it overshoots, when it has settled. All from curve.csv."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from softact.results.folder import Results

TIME, KINETIC = "time_s", "kinetic_energy_mJ"
# Figures that are followed, the first one that moves by more than this.
FOLLOWED = {"bending_angle_deg": 0.01, "elongation_mm": 1e-4, "tip_z_mm": 1e-4, "tip_x_mm": 1e-4}
# Part of the end of a step over which the mean counts as the final value; band around it.
TAIL, BAND = 0.2, 0.05
# Parts of the way between which the rise is counted.
LOW, HIGH = 0.1, 0.9


@dataclass(frozen=True)
class Response:
    """A figure in one step. begin, end: its value at the start and its time mean over the last
    fifth. rise: s from 10 to 90 % of the way. overshoot: part of the way beyond the end. settling:
    s until it stays within 5 % of the way; None where it does not before the last fifth."""

    step: str
    column: str
    begin: float
    end: float
    rise: float
    overshoot: float
    settling: float | None


def responses(results: Results) -> list[Response]:
    """One for each step with inertia at whose end something has moved."""
    curve = results.curve
    if TIME not in curve or KINETIC not in curve:
        return []
    found = []
    for step, rows in _steps(results):
        times = curve[TIME][rows] - curve[TIME][rows[0]]
        if times[-1] <= 0 or not curve[KINETIC][rows[1:]].any():
            continue
        for column, least in FOLLOWED.items():
            values = curve[column][rows] if column in curve else np.zeros(len(rows))
            end = _tail_mean(times, values)
            if abs(end - values[0]) > least:
                found.append(_response(step, column, times, values, end))
                break
    return found


def lines(results: Results) -> Iterator[str]:
    """What to say of them."""
    for r in responses(results):
        name, _, unit = r.column.rpartition("_")
        rest = f"within 5 % after {r.settling:.3g} s" if r.settling is not None else "not settled"
        yield (
            f"step '{r.step}': {name.replace('_', ' ')} goes from {r.begin:.4g} to {r.end:.4g} "
            f"{unit} (mean of the last fifth), rise time {r.rise:.3g} s, overshoot "
            f"{r.overshoot:.1%}, {rest}"
        )


def _response(
    step: str, column: str, times: np.ndarray, values: np.ndarray, end: float
) -> Response:
    way = (values - values[0]) / (end - values[0])
    rise = _first(times, way, HIGH) - _first(times, way, LOW)
    outside = np.flatnonzero(np.abs(way - 1) > BAND)
    last = times[min(outside[-1] + 1, len(times) - 1)] if len(outside) else 0.0
    settling = float(last) if last <= (1 - TAIL) * times[-1] else None
    over = max(float(way.max()) - 1, 0.0)
    return Response(step, column, float(values[0]), end, rise, over, settling)


def _tail_mean(times: np.ndarray, values: np.ndarray) -> float:
    """Time mean over the last part of a step."""
    begin = (1 - TAIL) * times[-1]
    at = np.append(begin, times[times > begin])
    there = np.interp(at, times, values)
    return float((there[1:] + there[:-1]) @ np.diff(at) / 2 / (times[-1] - begin))


def _first(times: np.ndarray, way: np.ndarray, share: float) -> float:
    """When ``way`` first reaches ``share``, linear in between."""
    row = int(np.argmax(way >= share))
    if row == 0:
        return 0.0
    part = (share - way[row - 1]) / (way[row] - way[row - 1])
    return float(times[row - 1] + part * (times[row] - times[row - 1]))


def _steps(results: Results) -> Iterator[tuple[str, np.ndarray]]:
    """Name and rows of each step; it begins with the last row of the one before."""
    names = [str(name) for name in results.curve["step"]]
    begin = 0
    for row, name in enumerate(names):
        if row + 1 == len(names) or names[row + 1] != name:
            yield name, np.arange(begin, row + 1)
            begin = row

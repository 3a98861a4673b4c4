"""How an actuator with inertia answers to loads that are held from the start of a step: how fast it
rises, how far it overshoots, when it has settled. All from curve.csv."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from softact.results.folder import Results
from softact.verdict.in_time import FOLLOWED, TIME, first_time, steps_of

KINETIC = "kinetic_energy_mJ"
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
    for step, begin, end in steps_of(results):
        rows = np.arange(begin, end + 1)
        times = curve[TIME][rows] - curve[TIME][rows[0]]
        if times[-1] <= 0 or not curve[KINETIC][rows[1:]].any():
            continue
        for column, least in FOLLOWED.items():
            values = curve[column][rows] if column in curve else np.zeros(len(rows))
            final = _tail_mean(times, values)
            if abs(final - values[0]) > least:
                found.append(_response(step, column, times, values, final))
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
    rise = first_time(times, way, HIGH) - first_time(times, way, LOW)
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

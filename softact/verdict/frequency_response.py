"""How far an actuator follows a load that swings: gain and phase at each frequency of sine steps.

Of the last whole cycle of a step the first harmonic is taken, a describing function: an actuator is
not linear, and its gain holds for the mean and the swing at which it was found. All from curve.csv.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from softact.results.folder import Results, is_pressure
from softact.units import FREQUENCY
from softact.verdict.in_time import FOLLOWED, TIME, steps_of

# Where the gain has fallen to this part of that at the lowest frequency, the band ends (-3 dB).
BAND = 1 / np.sqrt(2)
# Pressures that swing by less than this, kPa, drive nothing.
_STILL = 1e-6
_SAMPLES = 720  # of a cycle, on straight lines between the increments


@dataclass(frozen=True)
class Harmonic:
    """The answer to a swing. frequency: Hz. column: of curve.csv; drive: the column of the pressure
    that swings, or "" where other loads do. mean, amplitude: of the answer. gain: amplitude by that
    of the pressure in kPa, or by half of the way of the loads. lag: degrees that it comes later,
    from -90 to 270: 180 is where it falls while the load rises. rows: of curve.csv, the first and
    the last of the cycle that was looked at."""

    step: str
    frequency: float
    column: str
    drive: str
    mean: float
    amplitude: float
    gain: float
    lag: float
    rows: tuple[int, int]


def harmonics(results: Results) -> list[Harmonic]:
    """One for each step with a sine of at least one cycle, by rising frequency."""
    if TIME not in results.curve:
        return []
    sines = {
        step.get("name"): shape["sine"]
        for step in results.spec.get("steps", ())
        if isinstance(shape := step.get("amplitude"), dict) and "sine" in shape
    }
    found = []
    for step, begin, end in steps_of(results):
        if step in sines:
            one = _harmonic(results, step, FREQUENCY.parse(sines[step]["frequency"]), begin, end)
            found += [one] if one else []
    return sorted(found, key=lambda one: one.frequency)


def band(found: list[Harmonic]) -> tuple[float, bool] | None:
    """Hz up to which the gain stays above 71 % of that at the lowest frequency; whether it falls
    below at all; None where fewer than two frequencies of one figure and one drive were tried.

    Between two frequencies the gain is taken for that of a first-order lag, 1/√(a + b f²).
    """
    alike = [one for one in found if (one.column, one.drive) == (found[0].column, found[0].drive)]
    if len({one.frequency for one in alike}) < 2 or alike[0].gain <= 0:
        return None
    shares = [(one.frequency, one.gain / alike[0].gain) for one in alike]
    for (low, above), (high, below) in pairwise(shares):
        if below < BAND <= above:
            part = (BAND**-2 - above**-2) / (below**-2 - above**-2)
            return float(np.sqrt(low**2 + part * (high**2 - low**2))), True
    return shares[-1][0], False


def lines(results: Results) -> Iterator[str]:
    """What to say of them."""
    found = harmonics(results)
    for one in found:
        name, _, unit = one.column.rpartition("_")
        by = "/kPa" if one.drive else " for half of the loads' way"
        behind = "the pressure" if one.drive else "the loads"
        yield (
            f"step '{one.step}': at {one.frequency:.4g} Hz {name.replace('_', ' ')} swings by "
            f"{one.amplitude:.4g} {unit} about {one.mean:.4g} {unit}, gain {one.gain:.4g} "
            f"{unit}{by}, {one.lag:.1f} deg behind {behind}"
        )
    if found and (reach := band(found)):
        frequency, falls = reach
        lowest = f"71 % of that at {found[0].frequency:.4g} Hz"
        if falls:
            yield f"the gain falls to {lowest} at {frequency:.3g} Hz (between two steps)"
        else:
            yield f"the gain stays above {lowest} up to {frequency:.4g} Hz, the fastest step"


def _harmonic(
    results: Results, step: str, frequency: float, begin: int, end: int
) -> Harmonic | None:
    curve, rows = results.curve, slice(begin, end + 1)
    times = curve[TIME][rows] - curve[TIME][begin]
    cycles = np.floor(times[-1] * frequency * (1 + 1e-9))
    if cycles < 1:
        return None
    at = (cycles - 1 + (np.arange(_SAMPLES) + 0.5) / _SAMPLES) / frequency
    turning = np.exp(-2j * np.pi * frequency * at)

    def first(values: np.ndarray) -> complex:
        return complex(2 * np.mean(np.interp(at, times, values[rows]) * turning))

    # Loads go as (1 - cos)/2, of which half of the way is the amplitude.
    drive, driven = "", complex(2 * np.mean(-np.cos(2 * np.pi * frequency * at) * turning))
    for name, values in curve.items():
        if is_pressure(name):
            swing = first(values)
            if abs(swing) > max(_STILL, abs(driven) if drive else 0.0):
                drive, driven = name, swing
    for column, least in FOLLOWED.items():
        if column in curve and abs(answer := first(curve[column])) > least:
            mean = float(np.mean(np.interp(at, times, curve[column][rows])))
            lag = (90.0 - np.degrees(np.angle(answer / driven))) % 360.0 - 90.0
            ends = np.searchsorted(times, ((cycles - 1 - 1e-9) / frequency, cycles / frequency))
            cycle = (begin + int(ends[0]), begin + min(int(ends[1]), len(times) - 1))
            size, gain = abs(answer), abs(answer / driven)
            return Harmonic(step, frequency, column, drive, mean, size, gain, float(lag), cycle)
    return None

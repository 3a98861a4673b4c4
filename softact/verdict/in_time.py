"""What a run with a clock says of time: energy lost in each cycle, and creep under a held load.

All from curve.csv: the work of pressures is ∫ p dV by the trapezoidal rule over the increments.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from softact.loads.gas_flow import AMBIENT, NORMAL_LITRE
from softact.results.folder import Results

TIME = "time_s"
# Figures that are followed under a held load, the first one that moves by more than this.
FOLLOWED = {"bending_angle_deg": 0.01, "elongation_mm": 1e-4, "tip_z_mm": 1e-4, "tip_x_mm": 1e-4}
# A load is held where pressures stay within this part of their largest.
HELD = 1e-9
# A cycle takes back more than this part of its pressure; less is a swing about a held pressure.
RETURNED = 0.5
# To and fro by less than this part of the whole run's range of pressure is no cycle of it.
SWING = 0.05


@dataclass(frozen=True)
class Cycle:
    """A loading and the unloading after it. begin, end: s. work: of the pressures while they put
    work in, mJ; lost: what they did not get back. used: air that goes in, normal litres; exergy: of
    it at the largest pressure, mJ; lifted: work on the payload meanwhile, NaN where there is none.
    """

    step: str
    begin: float
    end: float
    work: float
    lost: float
    used: float
    exergy: float
    lifted: float

    @property
    def hysteresis(self) -> float:
        """Lost part of the loading work."""
        return self.lost / self.work


@dataclass(frozen=True)
class Supplied:
    """Air of a step with a supply. used: normal litres; exergy: of it, mJ; flow: the largest,
    normal litres a minute; work: of the air on the actuator, lifted: on the payload, mJ, NaN
    where there is none. pressure: kPa at the end; to_63, to_95: s until it has
    come that far of its way."""

    step: str
    used: float
    exergy: float
    flow: float
    work: float
    lifted: float
    pressure: float
    to_63: float
    to_95: float


@dataclass(frozen=True)
class Creep:
    """A figure under a held load: at its begin and end, and s until it has come 63 % and 95 % of
    that way."""

    step: str
    column: str
    begin: float
    end: float
    duration: float
    to_63: float
    to_95: float


def cycles(results: Results) -> list[Cycle]:
    """Cycles of pressure in the steps with a clock: from a smallest pressure over a largest one to
    the next smallest."""
    pressures, volumes = pressures_of(results), volumes_of(results)
    found: list[Cycle] = []
    if TIME not in results.curve or not len(pressures) or len(pressures) != len(volumes):
        return found
    means = (pressures[:, 1:] + pressures[:, :-1]) / 2e3  # kPa mm³ is 1e-3 mJ
    done = np.concatenate([[0.0], np.cumsum((means * np.diff(volumes)).sum(axis=0))])
    total = pressures.sum(axis=0)
    for step, begin, end in steps_of(results):
        turns = _turns(total, begin, end, SWING * float(np.ptp(total)))
        for low, high, back in zip(turns, turns[1:], turns[2:], strict=False):
            work, given_back = done[high] - done[low], done[high] - done[back]
            rise, fall = total[high] - total[low], total[high] - total[back]
            if work > 0 and fall > RETURNED * rise > 0:
                times = results.curve[TIME][[low, back]]
                air = taken(pressures, volumes, low, high)
                numbers = *times, work, work - given_back, *air, _lifted(results, low, high)
                found.append(Cycle(step, *map(float, numbers)))
    return found


def taken(pressures: np.ndarray, volumes: np.ndarray, low: int, high: int) -> tuple[float, float]:
    """Normal litres of air that go in from one row to another, at ambient temperature, and the
    exergy (mJ) that it has at the pressures of the latter."""
    absolute = pressures / 1e3 + AMBIENT
    amounts = absolute * volumes
    new = np.maximum(amounts[:, high] - amounts[:, low], 0.0)
    return new.sum() / NORMAL_LITRE, float(new @ np.log(absolute[:, high] / AMBIENT))


def _lifted(results: Results, begin: int, end: int) -> float:
    """What the payload's potential energy gains, mJ; NaN where there is none."""
    energy = results.curve.get("payload_energy_mJ")
    return np.nan if energy is None else float(energy[end] - energy[begin])


def supplied(results: Results) -> list[Supplied]:
    """Steps in which air is taken from a supply."""
    pressures = pressures_of(results)
    used, exergy = (_columns(results, f"air_{what}", "") for what in ("used", "exergy"))
    flows = np.abs(_columns(results, "air_flow", ""))
    if TIME not in results.curve or not len(used) or not len(pressures):
        return []
    found = []
    for step, begin, end in steps_of(results):
        litres = used[:, end] - used[:, begin]
        if litres.max() <= 0:
            continue
        most = int(np.argmax(litres)) if len(pressures) == len(litres) else 0
        times, values = (v[begin : end + 1] for v in (results.curve[TIME], pressures[most]))
        gone = values[-1] - values[0]
        way = (values - values[0]) / gone if gone else np.ones(len(values))
        work = results.curve.get("pressure_work_mJ", np.full(len(used[0]), np.nan))
        numbers = (
            litres.sum(),
            (exergy[:, end] - exergy[:, begin]).sum(),
            flows[:, begin + 1 : end + 1].sum(axis=0).max(),
            work[end] - work[begin],
            _lifted(results, begin, end),
            values[-1],
            *(first_time(times, way, share) for share in (0.63, 0.95)),
        )
        found.append(Supplied(step, *map(float, numbers)))
    return found


def creeps(results: Results) -> list[Creep]:
    """Steps with a clock through which pressures are held, and what moves in them."""
    found = []
    pressures = pressures_of(results)
    if TIME not in results.curve or not len(pressures):
        return []
    for step, begin, end in steps_of(results):
        part = pressures[:, begin : end + 1]
        times = results.curve[TIME][begin : end + 1]
        if np.ptp(part, axis=1).max() > HELD * np.abs(part).max() or times[-1] <= times[0]:
            continue
        for column, least in FOLLOWED.items():
            values = results.curve.get(column, np.zeros(0))[begin : end + 1]
            if len(values) and abs(values[-1] - values[0]) > least:
                way = (values - values[0]) / (values[-1] - values[0])
                reached = [first_time(times, way, share) for share in (0.63, 0.95)]
                ends = values[0], values[-1], times[-1] - times[0]
                found.append(Creep(step, column, *map(float, (*ends, *reached))))
                break
    return found


def lines(results: Results) -> Iterator[str]:
    """What to say of them."""
    numbers: dict[str, int] = {}
    for cycle in cycles(results):
        numbers[cycle.step] = number = numbers.get(cycle.step, 0) + 1
        yield (
            f"step '{cycle.step}', cycle {number}: {cycle.lost:.4g} of {cycle.work:.4g} mJ of the "
            f"loading work is lost ({cycle.hysteresis:.2%}); {_of_air(cycle)}"
        )
    for one in supplied(results):
        yield (
            f"step '{one.step}': {_of_air(one)}, at most {one.flow:.4g} nl/min; the pressure comes "
            f"to {one.pressure:.4g} kPa, 63 % of its way in {one.to_63:.3g} s, 95 % in "
            f"{one.to_95:.3g} s"
        )
    for creep in creeps(results):
        name, _, unit = creep.column.rpartition("_")
        way = creep.end - creep.begin
        yield (
            f"step '{creep.step}': {name.replace('_', ' ')} creeps from {creep.begin:.4g} to "
            f"{creep.end:.4g} {unit} in {creep.duration:.4g} s ({way:+.4g} {unit}), 63 % of it in "
            f"{creep.to_63:.3g} s, 95 % in {creep.to_95:.3g} s"
        )


def _of_air(part: Cycle | Supplied) -> str:
    """Air, what it could do, and what became of that."""
    said = f"{part.used:.4g} nl of air of {part.exergy:.4g} mJ exergy, {part.work:.4g} mJ of work"
    if np.isnan(part.lifted) or part.exergy <= 0:
        return said
    if part.lifted < 0:
        return f"{said}, the payload sinks by {-part.lifted:.4g} mJ"
    share = part.lifted / part.exergy
    return f"{said}, {part.lifted:.4g} mJ on the payload (efficiency {share:.3%})"


def _columns(results: Results, beginning: str, end: str) -> np.ndarray:
    names = [n for n in results.curve if n.startswith(beginning) and n.endswith(end)]
    return np.array([results.curve[name] for name in names])


def pressures_of(results: Results) -> np.ndarray:
    return _columns(results, "pressure_", "kPa")


def volumes_of(results: Results) -> np.ndarray:
    return _columns(results, "cavity_volume", "mm3")


def steps_of(results: Results) -> Iterator[tuple[str, int, int]]:
    """Name, first and last row of each step; it begins with the last row of the one before."""
    names = [str(name) for name in results.curve["step"]]
    begin = 0
    for row, name in enumerate(names):
        if row + 1 == len(names) or names[row + 1] != name:
            yield name, begin, row
            begin = row


def _turns(values: np.ndarray, begin: int, end: int, least: float) -> list[int]:
    """First row, rows at which values turn by more than ``least``, and the last one."""
    turns, extreme, sense = [begin], begin, 0.0
    for row in range(begin + 1, end + 1):
        way = values[row] - values[extreme]
        if abs(way) > least and way * sense <= 0:
            turns += [extreme] if sense else []
            extreme, sense = row, np.sign(way)
        elif way * sense > 0:
            extreme = row
    return [*turns, *([extreme] if extreme > begin else [])]


def first_time(times: np.ndarray, way: np.ndarray, share: float) -> float:
    """When ``way`` first reaches ``share``, since the first time, linear in between."""
    row = int(np.argmax(way >= share))
    if row == 0:
        return 0.0
    part = (share - way[row - 1]) / (way[row] - way[row - 1])
    return float(times[row - 1] + part * (times[row] - times[row - 1]) - times[0])

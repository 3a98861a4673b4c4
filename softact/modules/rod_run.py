"""An actuator as a rod whose cross-section is its module: from the spec to states."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from softact.errors import SpecError
from softact.fields import Fault
from softact.loads.several import entries
from softact.loads.timing import Timing
from softact.modules.chain import Acting, Chain, Row, Standing
from softact.modules.driven import driven
from softact.modules.grip import Grip
from softact.modules.rod import Frames, Loads
from softact.modules.rod_motion import Motion, RodMotion, error_in_time
from softact.modules.table import axis_of
from softact.spec import Spec

Array = NDArray[np.float64]
LOADED = {"gravity", "pressure", "payload"}
FIRST = 1e-3  # of a step's duration: the first increment with inertia
SHORTEST = 1e-7  # of it: below that a rod does not go on
TINY = 1e-12
TOO_STEEP = 50.0  # % of the largest curvature, from one module to the next ...
BY_TABLE = 0.2  # ... and part of the largest of the table: no chain of equal modules
LONGER, SHORTER, SAFE = 2.0, 0.3, 0.9  # an increment beside the last one, and its safety


@dataclass(frozen=True)
class RodRun:
    """rows: as curve.csv. lines: places (pieces + 3, 3) from the clamp to the tip at each;
    strains (pieces, 6), 1/mm and 1. stopped: why it did not arrive, or empty."""

    rows: list[Row]
    lines: list[Array]
    strains: list[Array]
    stopped: str


def faults(spec: Spec) -> Iterator[Fault]:
    """What of a spec a rod cannot be asked."""
    yield from (((key,), why) for key, why in _refused(spec) if why)
    for name, obstacle in spec.obstacles.items():
        if not obstacle.active:
            yield ("obstacles", name, "active"), "what a rod may touch stands there from the start"
        if obstacle.mass is not None:
            yield ("obstacles", name, "mass"), "what a rod may touch stays in place; leave it out"
    moves = any(step.timing(spec.layout()) for step in spec.steps)
    for name, material in spec.materials.items() if moves else ():
        if material.remembers:
            yield ("materials", name), "a rod in motion has no memory of its material; leave it out"
    for index, step in enumerate(spec.steps):
        for key in sorted(set(step.loads) - LOADED):
            yield ("steps", index, key), f"a rod takes {', '.join(sorted(LOADED))} alone"
        if step.supports is not None:
            yield ("steps", index, "supports"), "a rod stays clamped"
        timing = step.timing(spec.layout())
        if timing is not None and timing.dynamics is None:
            yield ("steps", index, "duration"), "a rod has a clock with dynamics: true alone"
        for load in entries(step.payload):
            if load.surface not in (None, spec.layout().tip):
                yield ("steps", index, "payload"), "a rod is loaded at its tip"


def check(spec: Spec) -> None:
    """Raise SpecError with one line for each thing that a rod cannot be asked."""
    spec.geometry.module()  # or it says that there is none
    if found := list(faults(spec)):
        raise SpecError(*(f"{'.'.join(map(str, place))}: {text}" for place, text in found))
    driven(spec)
    axis_of(spec.layout())


def _refused(spec: Spec) -> Iterator[tuple[str, str]]:
    clamp = spec.layout().clamp
    loose = [s for s in spec.supports or () if s.surface != clamp or s.spring or s.turn]
    yield "supports", "a rod is clamped at its base, and nowhere else" if loose else ""
    yield "module", "a rod is of a whole actuator" if spec.layout().repeats else ""
    yield "sheets", "a rod is of a solid actuator, not of sheets" if spec.sheets else ""
    yield "masses", "a rod takes the weight of a mass as a payload" if spec.masses else ""
    rubs = any(contact.friction for contact in spec.contact or ())
    yield "contact", "modules touch each other without friction; leave it out" if rubs else ""


class Carried:
    """A rod on its way through the steps of its spec."""

    def __init__(self, chain: Chain, increments: int):
        self.chain, self.increments = chain, increments
        self.grips: list[Grip] = []
        self.motion: Motion | None = None
        self.time = 0.0
        self._way: list[Array] = []  # strains of the step's states so far
        self.before = chain.at_rest()
        standing = Standing(chain, self.before)
        self.frames: Frames = standing.rod.straight()
        self.grips = standing.first_grips(self.frames)

    def through(self, number: int, first: bool) -> Iterator[tuple[float, Standing, Loads]]:
        """States of a step: part of it, how the chain stands, and its loads there. first: also the
        one at its start. Raises ArithmeticError."""
        step = self.chain.spec.steps[number]
        after = self.chain.acting(number, self.before)
        timing = step.timing(self.chain.layout)
        if timing is None:
            self.motion, self._way = None, []
            for increment in range(0 if first else 1, self.increments + 1):
                part = increment / self.increments
                yield part, *self._settle(self.before.towards(after, part))
        else:
            if first:
                yield 0.0, *self._settle(self.before)
            yield from self._swing(after, timing)
            after = self._at(after, timing, 1.0)
        self.before = after

    def _settle(self, acting: Acting) -> tuple[Standing, Loads]:
        standing = Standing(self.chain, acting, self.grips)
        guess = self.frames
        if len(self._way) > 1 and not self.chain.spec.obstacles:
            last, before = self._way[-1], self._way[-2]
            guess = standing.rod.chained(2 * last - before)
        self.frames, loads = standing.settled(guess)
        self._way.append(standing.rod.strains(self.frames))
        self.grips = standing.rod.followed(self.frames, loads) if self.grips else []
        return standing, loads

    def _at(self, after: Acting, timing: Timing, part: float) -> Acting:
        acting = self.before.towards(after, timing.amplitude.at(part))
        given = timing.amplitude.pressures(part)
        return replace(acting, pressures=self.chain.of_groups(given)) if given else acting

    def _swing(self, after: Acting, timing: Timing) -> Iterator[tuple[float, Standing, Loads]]:
        """Increments in time, as long as their error allows and their number asks for at least."""
        assert timing.dynamics is not None
        most = timing.duration / self.increments
        allowed = self.chain.spec.solver.settings.time_tolerance * self.chain.layout.length
        done, size = 0.0, FIRST * timing.duration
        if self.motion is None:
            self.motion = Motion.at_rest(self.frames)
        standing, now = self._moving(self._at(after, timing, 0.0), timing)
        motion = now.start(self.motion, standing.loads)
        turns = (*timing.amplitude.turns, 1.0)
        while done < timing.duration * (1 - SHORTEST):
            end = next(t for t in turns if t * timing.duration > done * (1 + SHORTEST))
            size = min(size, most, end * timing.duration - done)
            part = (done + size) / timing.duration
            standing, now = self._moving(self._at(after, timing, part), timing)
            try:
                later = now.after(motion, standing.loads, size)
                ratio = error_in_time(motion, later, timing.dynamics, size) / allowed
            except ArithmeticError:
                ratio = np.inf
            if ratio > 1.0 / SAFE**3:
                size *= max(SHORTER, SAFE * ratio ** (-1 / 3))
                if size < SHORTEST * timing.duration:
                    raise ArithmeticError("the rod finds no motion, however short the time")
                continue
            done, self.time, motion = done + size, self.time + size, later
            self.motion, self.frames = motion, motion.frames
            loads = standing.loads
            if self.grips:
                loads = standing.rod.held(self.frames, loads)
                self.grips = standing.rod.followed(self.frames, loads)
            yield part, standing, loads
            size *= min(LONGER, SAFE * max(ratio, TINY) ** (-1 / 3))

    def _moving(self, acting: Acting, timing: Timing) -> tuple[Standing, RodMotion]:
        assert timing.dynamics is not None
        standing = Standing(self.chain, acting, self.grips)
        if self.grips:
            standing.loads = standing.rod.held(self.frames, standing.loads)
        return standing, RodMotion(standing.rod, self.chain.inertia, timing.dynamics)


def _refuse_steep(chain: Chain, strains: Array, percent: float) -> None:
    """Raise ValueError where neighbours bend so differently that no module stands for them.
    percent: the change from module to module, of the largest curvature."""
    table, part = chain.table, percent / 100
    bends = np.flatnonzero(table.turns)
    largest = np.abs([table.energy.low[bends], table.energy.high[bends]]).max(initial=0.0)
    bent = np.linalg.norm(strains[:, :3], axis=1).max()
    if percent > TOO_STEEP and part * bent > BY_TABLE * largest:
        raise ValueError(
            f"the curvature changes by {percent:.0f} % of its largest from one module to the next; "
            f"a module is one among equals, and its rod is told up to {TOO_STEEP:g} %"
        )


def run(chain: Chain, increments: int) -> RodRun:
    """Carry a rod through the steps of its spec, each in so many increments, or with inertia at
    least so many."""
    found, carried = RodRun([], [], [], ""), Carried(chain, increments)
    timed = any(step.timing(chain.layout) for step in chain.spec.steps)
    row: Row = {}
    for number, step in enumerate(chain.spec.steps):
        count, part = 0, 0.0
        try:
            for part, standing, loads in carried.through(number, not found.rows):
                frames = carried.frames
                strains = standing.rod.strains(frames)
                chain.table.check(standing.law.states(strains), standing.law.pressures)
                count = 0 if part == 0.0 else count + 1
                place: Row = {"step": step.name, "increment": float(count), "step_fraction": part}
                row = standing.row(frames, loads, row)
                place |= {"time_s": carried.time} if timed else {}
                _refuse_steep(chain, strains, float(row["curvature_change_percent"]))
                found.rows.append(place | row)
                found.lines.append(standing.line(frames))
                found.strains.append(strains)
        except (ArithmeticError, ValueError) as error:
            return replace(found, stopped=f"step '{step.name}' stops at {part:.0%}: {error}")
    return found

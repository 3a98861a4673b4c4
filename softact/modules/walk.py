"""Where a module is walked: which strains and pressures a table of it is made from."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from softact.errors import NoEquilibriumError
from softact.modules.dead import Dead
from softact.modules.driven import Driven
from softact.modules.energy import Samples
from softact.modules.walker import Held, Walker

Array = NDArray[np.float64]
SAGS = 1.2  # times how far the dead loads bend a linear rod
BEYOND = 0.3  # of the largest free curvature: how far the table goes past straight and past free
FAR = 1.5  # times that: from here on a way has several states
PULLED = 0.25  # of the force that keeps the length of a straight module
SHEARED = 0.25  # of that force: across the axis
HARDLY = 0.02  # rad of a module, or of its length: strains below it are secondary


@dataclass(frozen=True)
class Grid:
    """pressures: how many above zero, where one group of cavities is driven. bends: states each
    way from one that nothing holds, where that is far."""

    pressures: int = 2
    bends: int = 1


@dataclass(frozen=True)
class Walked:
    """What was found on the way.

    samples: over curvatures, forces and pressures; the first is at rest. centres (c, k + m):
    strains and pressures of the module that nothing holds, the first at rest. lost: how many states
    had no stable equilibrium. iterations: with new factors, in all.
    """

    samples: Samples
    centres: Array
    lost: int
    iterations: int


class Walk:
    """The states that a table asks for, one after the other, each from a neighbour. axis: number of
    the coordinate along which the module lies. tell: hears of the progress."""

    def __init__(
        self,
        walker: Walker,
        loads: Driven,
        dead: Dead,
        grid: Grid,
        axis: int,
        tell: Callable[[str], None],
    ):
        self.walker, self.loads, self.dead, self.grid, self.tell = walker, loads, dead, grid, tell
        free = walker.free.tolist()
        self.bends = [free.index(i) for i in range(3) if i != axis and i in free]
        self.along = free.index(3 + axis)
        self._others = [i for i in range(len(free)) if i not in (*self.bends, self.along)]
        self.rest = walker.begin()
        self.centres, self.samples, self.lost = [self.rest], [self.rest], 0
        self._visit(self._pressures(), grid.bends)

    def refine(self) -> None:
        """As many states again, at pressures between, and more of them bent."""
        low, high = self.loads.low, self.loads.high
        if len(low) == 1:
            levels = np.sort(np.array([c.pressures for c in self.centres]), axis=0)
            self._visit((levels[1:] + levels[:-1]) / 2, self.grid.bends + 1)
        else:
            quarters = [(low + (high - low) * part)[:, None] for part in (0.25, 0.75)]
            inner = product(*np.hstack(quarters))
            self._visit(np.array(list(inner)), self.grid.bends + 1)

    @property
    def walked(self) -> Walked:
        """What was found so far."""
        turns, rest = self.walker.turns, self.walker.rest
        mixed = [state.mixed(turns, rest) for state in self.samples]
        samples = Samples(*(np.array(column) for column in zip(*mixed, strict=True)))
        centres = np.array([c.place for c in self.centres])
        return Walked(samples, centres, self.lost, self.walker.iterations)

    @property
    def secondary(self) -> list[bool]:
        """Which variables hardly change where nothing holds the module: none of the pressures."""
        walker, k = self.walker, len(self.walker.free)
        size = np.where(walker.free < 3, walker.repeat.length, 1.0)
        moved = np.abs(np.array([c.strain for c in self.centres]) - walker.rest).max(axis=0) * size
        hardly = [i in self._others and bool(moved[i] < HARDLY) for i in range(k)]
        return [*hardly, *[False] * len(self.loads.groups)]

    def _visit(self, pressures: Array, bends: int) -> None:
        """States about the module let go at pressures (p, m). Raises NoEquilibriumError where it
        does not reach them."""
        try:
            centres = self._let_go(pressures)
        except NoEquilibriumError as error:
            goal = ", ".join(f"{1e3 * p:.4g}" for p in self.loads.high)
            raise NoEquilibriumError(
                f"the module that nothing holds does not reach {goal} kPa: {error}; lower the "
                "pressure of the steps, or solve the whole actuator"
            ) from None
        k, rest = len(self.walker.free), self.rest
        bent = max(float(np.linalg.norm(c.strain[self.bends])) for c in self.centres)
        beyond = BEYOND * max(bent, HARDLY / self.walker.repeat.length)
        blocked = [c.second[:k, :k] @ (rest.strain - c.strain) for c in self.centres]
        pull = PULLED * max(abs(load[self.along]) for load in blocked)
        pull = max(pull, SAGS * self.dead.pull)
        near = self.dead.near(np.array([c.pressures for c in self.centres]))
        stiffness = np.zeros((6, 6))
        stiffness[np.ix_(self.walker.free, self.walker.free)] = rest.second[:k, :k]
        furthest = max(centres, key=lambda c: float(np.linalg.norm(c.pressures)))
        for number, centre in enumerate(centres, 1):
            (at,) = (i for i, c in enumerate(self.centres) if c is centre)
            sags = [SAGS * s[self.walker.free] for s in self.dead.sags(stiffness, near[at])]
            ends = centre is rest or centre is furthest
            around = self._around(centre, (sags[0], sags[1]), (beyond, pull), bends, ends)
            self.samples += [state for state in around if state is not rest]
            self.tell(
                f"table: {number} of {len(centres)} pressures, {len(self.samples)} states, "
                f"{self.lost} lost"
            )

    def _pressures(self) -> Array:
        """Where the module is let go (p, m), MPa: a row of them for one group of cavities, for
        more the corners of what they reach, the middles of its axes, and its middle."""
        low, high = self.loads.low, self.loads.high
        if len(low) == 1:
            return np.unique(
                np.vstack([np.linspace(low, high, self.grid.pressures + 1), [[0.0]]]), axis=0
            )
        corners = np.array(list(product(*zip(low, high, strict=True))))
        halves = np.diag((low + high) / 2)
        return np.unique(np.vstack([corners, halves, (low + high) / 2]), axis=0)

    def _let_go(self, pressures: Array) -> list[Held]:
        """The module let go at pressures (p, m); where it was before, that state."""
        left, visited = list(pressures), []
        scale = self.loads.high - self.loads.low
        while left:
            gaps = np.array(
                [[np.linalg.norm((p - h.pressures) / scale) for h in self.centres] for p in left]
            )
            row, column = np.unravel_index(gaps.argmin(), gaps.shape)
            goal, nearest = left.pop(int(row)), self.centres[int(column)]
            if gaps.min() > 0:
                nearest = self.walker.released(nearest, goal)
                self.centres.append(nearest)
            visited.append(nearest)
        return visited

    def _around(
        self,
        centre: Held,
        sags: tuple[Array, Array],
        reach: tuple[float, float],
        bends: int,
        last: bool,
    ) -> Iterator[Held]:
        """States about one that nothing holds: bent to and fro, pulled, and at the last pressures
        and at rest also sheared and twisted."""
        (low, high), (beyond, pull) = sags, reach
        states = [centre]
        for i in self.bends:
            here = centre.strain[i]
            ends = min(here, 0.0) + low[i] - beyond, max(here, 0.0) + high[i] + beyond
            for end in ends:
                steps = bends if abs(end - here) > FAR * beyond else 1
                goals = np.linspace(here, end, steps + 1)[1:]
                states += self._along(centre, [{i: goal} for goal in goals])
        if len(self.bends) == 2:
            one, two = self.bends
            for signs in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                bent = {
                    i: centre.strain[i] + s * beyond / np.sqrt(2)
                    for i, s in zip((one, two), signs, strict=True)
                }
                states += self._along(centre, [bent])
        yield from states
        for number, state in enumerate(states):
            ways = (1, -1) if state is centre else (1 - 2 * (number % 2),)
            for way in ways:
                yield from self._along(state, [{self.along: way * pull}])
        for i in self._others if last else ():
            step = beyond if self.walker.turns[i] else SHEARED * pull / PULLED
            here = centre.strain[i] if self.walker.turns[i] else 0.0
            for way in (1, -1):
                yield from self._along(centre, [{i: here + way * step}])

    def _along(self, start: Held, goals: list[dict[int, float]]) -> list[Held]:
        """States from one to the next, as far as there are any; each goal says what differs from
        the first one's curvatures, and from no force."""
        found: list[Held] = []
        before = np.where(self.walker.turns, start.strain, 0.0)
        for changes in goals:
            goal = before.copy()
            goal[list(changes)] = list(changes.values())
            try:
                start = self.walker.bent(start, goal, start.pressures)
            except NoEquilibriumError:
                self.lost += len(goals) - len(found)
                break
            if not start.stable(self.walker.turns):
                self.lost += len(goals) - len(found)
                break
            found.append(start)
        return found

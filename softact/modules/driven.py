"""The pressures that drive an actuator: which cavities go together, and how far."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softact.errors import SpecError
from softact.mesh.layout import Layout
from softact.spec import Spec, Step

Array = NDArray[np.float64]
ALIKE = 1e-9  # of the largest pressure


@dataclass(frozen=True)
class Driven:
    """groups: cavity of a module -> share, of cavities whose pressures are multiples of each other
    in all segments and steps; the largest share of a group is 1. low, high (m,): the least and the
    largest pressure of each group on the way, zero among them, MPa. goals (steps, segments, m):
    where each step goes to, from where the last one ended."""

    groups: tuple[Mapping[str, float], ...]
    low: Array
    high: Array
    goals: Array

    @property
    def names(self) -> tuple[str, ...]:
        """Of the groups: the cavity with the largest share."""
        return tuple(max(group, key=group.__getitem__) for group in self.groups)

    def cavities(self, pressures: Array) -> dict[str, float]:
        """Pressures of a module's cavities from those (m,) of its groups."""
        return {
            name: share * float(pressure)
            for group, pressure in zip(self.groups, pressures, strict=True)
            for name, share in group.items()
        }


def driven(spec: Spec) -> Driven:
    """By the steps of a spec. Raises SpecError where no step has a pressure."""
    goals, between = [], []
    now: dict[str, float] = {}
    for step in spec.steps:
        goal, on_the_way = _way(step, spec.layout(), now)
        now = on_the_way[-1]
        goals.append(goal)
        between += on_the_way
    rows = [*goals, *between]
    segments = spec.geometry.in_segments()
    names = [n for n in segments[0] if any(row.get(s[n]) for row in rows for s in segments)]
    if not names:
        raise SpecError("a table of a module is walked over its pressure; no step has one")
    table = np.array([[row.get(s[n], 0.0) for n in names] for row in rows for s in segments])
    groups: list[dict[str, float]] = []
    columns: list[Array] = []
    for name, column in zip(names, table.T, strict=True):
        for group, leading in zip(groups, columns, strict=True):
            at = int(np.abs(leading).argmax())
            share = column[at] / leading[at]
            if np.abs(column - share * leading).max() <= ALIKE * np.abs(table).max():
                group[name] = float(share)
                break
        else:
            groups.append({name: 1.0})
            columns.append(column)
    for number, group in enumerate(groups):
        largest = max(group.values(), key=abs)
        columns[number] = columns[number] * largest
        groups[number] = {name: share / largest for name, share in group.items()}
    found = np.array(columns).T
    low, high = np.minimum(found.min(axis=0), 0.0), np.maximum(found.max(axis=0), 0.0)
    by_segments = found.reshape(len(rows), len(segments), -1)
    return Driven(tuple(groups), low, high, by_segments[: len(goals)])


def _way(
    step: Step, layout: Layout, before: Mapping[str, float]
) -> tuple[dict[str, float], list[dict[str, float]]]:
    """Pressures of cavities to which a step goes, and those where its loads turn and at its end:
    an amplitude may come back, or give pressures in time."""
    given = step.loads.get("pressure")
    named = given if isinstance(given, dict) else dict.fromkeys(layout.cavities, given)
    goal = {**before} | {name: float(p) for name, p in named.items() if p is not None}
    timing = step.timing(layout)
    if timing is None:
        return goal, [goal]
    found = []
    for part in (0.0, *timing.amplitude.turns, 1.0):
        share = timing.amplitude.at(part)
        here = {n: (1 - share) * before.get(n, 0.0) + share * p for n, p in goal.items()}
        found.append(here | dict(timing.amplitude.pressures(part)))
    return goal, found

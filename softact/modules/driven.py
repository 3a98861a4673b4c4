"""The pressures that drive an actuator: which cavities go together, and how far."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softact.errors import SpecError
from softact.spec import Spec

Array = NDArray[np.float64]
ALIKE = 1e-9  # of the largest pressure


@dataclass(frozen=True)
class Driven:
    """groups: cavity -> share, of cavities whose pressures are multiples of each other in all
    steps; the largest share of a group is 1. low, high (m,): the least and the largest pressure of
    each group on the way, zero among them, MPa. ends (steps, m): at the end of each step."""

    groups: tuple[Mapping[str, float], ...]
    low: Array
    high: Array
    ends: Array

    @property
    def names(self) -> tuple[str, ...]:
        """Of the groups: the cavity with the largest share."""
        return tuple(max(group, key=group.__getitem__) for group in self.groups)


def driven(spec: Spec) -> Driven:
    """By the steps of a spec. Raises SpecError where no step has a pressure."""
    rows: list[dict[str, float]] = []
    now: dict[str, float] = {}
    for step in spec.steps:
        given = step.loads.get("pressure")
        if given is not None:
            cavities = spec.layout().cavities
            named = given if isinstance(given, dict) else dict.fromkeys(cavities, given)
            now = now | {name: float(value) for name, value in named.items()}
        rows.append(now)
    names = [name for name in spec.layout().cavities if any(row.get(name) for row in rows)]
    if not names:
        raise SpecError("a table of a module is walked over its pressure; no step has one")
    table = np.array([[row.get(name, 0.0) for name in names] for row in rows])
    groups: list[dict[str, float]] = []
    ends: list[Array] = []
    for name, column in zip(names, table.T, strict=True):
        for group, leading in zip(groups, ends, strict=True):
            at = int(np.abs(leading).argmax())
            share = column[at] / leading[at]
            if np.abs(column - share * leading).max() <= ALIKE * np.abs(table).max():
                group[name] = float(share)
                break
        else:
            groups.append({name: 1.0})
            ends.append(column)
    for number, group in enumerate(groups):
        largest = max(group.values(), key=abs)
        ends[number] = ends[number] * largest
        groups[number] = {name: share / largest for name, share in group.items()}
    found = np.array(ends).T
    low, high = np.minimum(found.min(axis=0), 0.0), np.maximum(found.max(axis=0), 0.0)
    return Driven(tuple(groups), low, high, found)

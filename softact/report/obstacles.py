"""Rigid obstacles as bodies to draw: their surface, and where they are in each state."""

from dataclasses import dataclass
from math import ceil

import numpy as np
from pydantic import ValidationError

from softact.contact.obstacles import OBSTACLES
from softact.contact.obstacles.base import Shape
from softact.contact.pose import between
from softact.results.folder import Results

COLOUR = "#a3abb2"


@dataclass(frozen=True)
class Body:
    """points (n, 3) mm and triangles (m, 3) of an obstacle where it was placed.

    middle: (3,) mm, of that; shift: (states, 3) mm how far it has moved in each state, turn:
    (states, 3) degrees, rotation vector about it. there: (states,) whether it is there.
    """

    name: str
    points: np.ndarray
    triangles: np.ndarray
    middle: np.ndarray
    shift: np.ndarray
    turn: np.ndarray
    there: np.ndarray

    def at(self, number: float) -> np.ndarray:
        """(n, 3) mm: its points in state ``number``, linear between two; −1 is where it was
        placed."""
        if number < 0:
            return self.points
        states = np.arange(len(self.shift))
        shift = np.array([np.interp(number, states, moved) for moved in self.shift.T])
        return (self.points - self.middle) @ self.turned(number).T + self.middle + shift

    def turned(self, number: float) -> np.ndarray:
        """(3, 3) its rotation in state ``number``, as of ``at``."""
        return np.eye(3) if number < 0 else between(self.turn, number)

    def seen(self, number: float) -> bool:
        """Whether it is there in state ``number``, between two as in the later one, which belongs
        to the same step; −1 is the undeformed one, as the first."""
        return bool(self.there[max(ceil(number), 0)])


def bodies(results: Results, low: np.ndarray, high: np.ndarray) -> list[Body]:
    """The obstacles of a result; endless ones are drawn as large as the box from ``low`` to
    ``high`` (3,) mm, around its middle."""
    written = results.spec.get("obstacles")
    found = []
    for name, obstacle in written.items() if isinstance(written, dict) else ():
        try:
            shape = OBSTACLES[obstacle["type"]].model_validate(obstacle).shape()
        except (ValidationError, KeyError, TypeError, AttributeError):
            continue  # written by another version of softact, or out of a file that is not there
        found.append(_body(results, name, shape, low, high))
    return found


def _body(results: Results, name: str, shape: Shape, low: np.ndarray, high: np.ndarray) -> Body:
    points, triangles = shape.surface(float((high - low).max()), (low + high) / 2)
    rows = len(results.increments)
    columns, turns = (
        [results.curve.get(f"obstacle_{name}_{what}", np.zeros(rows)) for what in each]
        for each in ([f"{c}_mm" for c in "xyz"], [f"turn_{c}_deg" for c in "xyz"])
    )
    gap = results.curve.get(f"contact_gap_{name}_mm", np.zeros(rows))
    shift, turn = (np.nan_to_num(np.column_stack(each)) for each in (columns, turns))
    middle = np.asarray(shape.center, float)
    return Body(name, points, triangles, middle, shift, turn, np.isfinite(gap))

"""Where a rigid obstacle is: moved and turned from where it was placed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from softact.system.rotation import rotation_about
from softact.system.term import Value

NO_TURN = np.zeros(6)  # of the loads: a rotation vector (degrees) and a point of its axis (mm)


@dataclass(frozen=True)
class Pose:
    """x = a + R (X − a) + s of a point X of the obstacle as it was placed.

    shift: s (3,) mm. turn: R (3, 3); None: it was not turned. about: a (3,) mm.
    """

    shift: np.ndarray
    turn: np.ndarray | None = None
    about: np.ndarray | None = None

    def seen(self, places: np.ndarray) -> np.ndarray:
        """Places (..., 3) as the obstacle sees them: X of x."""
        if self.turn is None:
            return places - self.shift
        return (places - self.shift - self.about) @ self.turn + self.about

    def placed(self, places: np.ndarray) -> np.ndarray:
        """Points (..., 3) of the obstacle, where they are: x of X."""
        if self.turn is None:
            return places + self.shift
        return (places - self.about) @ self.turn.T + self.about + self.shift

    def outward(self, vectors: np.ndarray) -> np.ndarray:
        """Vectors (..., 3) that the obstacle sees, as they are."""
        return vectors if self.turn is None else vectors @ self.turn.T

    def outward_matrices(self, matrices: np.ndarray) -> np.ndarray:
        """The same of matrices (..., 3, 3)."""
        return matrices if self.turn is None else self.turn @ matrices @ self.turn.T

    @property
    def rotation(self) -> np.ndarray:
        """Rotation vector (3,), degrees, of at most half a turn."""
        return np.zeros(3) if self.turn is None else rotation_vector(self.turn)


def pose_of(shift: Value | None, turn: Value | None) -> Pose:
    """The pose of the loads ``shift`` (3,) mm and ``turn`` (6,), see ``NO_TURN``."""
    moved = np.zeros(3) if shift is None else np.asarray(shift, float)
    if turn is None or not np.any(np.asarray(turn)[:3]):
        return Pose(moved)
    vector, about = np.asarray(turn)[:3], np.asarray(turn)[3:]
    return Pose(moved, rotation_about(vector, float(np.linalg.norm(vector))), about)


def rotation_vector(matrix: np.ndarray) -> np.ndarray:
    """Rotation vector (3,), degrees, of a rotation matrix (3, 3): axis times angle, up to 180°."""
    cosine = np.clip((np.trace(matrix) - 1) / 2, -1.0, 1.0)
    skew = matrix - matrix.T
    sine_axis = np.array([skew[2, 1], skew[0, 2], skew[1, 0]]) / 2
    sine = float(np.linalg.norm(sine_axis))
    angle = np.arctan2(sine, cosine)
    if sine > 1e-6:
        return np.degrees(angle) * sine_axis / sine
    if cosine > 0.0:
        return np.degrees(sine_axis)
    # Half a turn: R + 1 = 2 n nᵀ, and n by its largest column.
    column = (matrix + np.eye(3))[:, np.argmax(np.diag(matrix))]
    return np.degrees(angle) * column / np.linalg.norm(column)


def between(states: np.ndarray | Sequence[np.ndarray], number: float) -> np.ndarray:
    """Rotation matrix (3, 3) at a place among the rotation vectors (degrees) of several states,
    on the shortest way between two."""
    before = int(np.clip(np.floor(number), 0, len(states) - 1))
    after = min(before + 1, len(states) - 1)
    one, other = (_matrix(states[n]) for n in (before, after))
    return _matrix((number - before) * rotation_vector(other @ one.T)) @ one


def _matrix(vector: np.ndarray) -> np.ndarray:
    angle = float(np.linalg.norm(vector))
    return rotation_about(vector, angle) if angle > 0.0 else np.eye(3)

"""Rotations in space."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def rotation_about(axis: Sequence[float] | np.ndarray, degrees: float) -> np.ndarray:
    """Rotation matrix (3, 3) about a direction, of any length (Rodrigues)."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.deg2rad(degrees)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross

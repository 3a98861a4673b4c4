"""Faces of a gmsh model that get the same triangles: the two at which a module repeats."""

from __future__ import annotations

from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from softact.errors import MeshError

Array = NDArray[np.float64]
SAME = 1e-4  # of the shift: boxes of faces that are nearer are one


def match(gmsh: ModuleType, left: str, right: str, shift: Array) -> None:
    """Mesh the faces of the group ``right`` of the current model as those of the group ``left``,
    which lie where ``shift`` (3,), mm, takes them.

    Raises MeshError where a face has no like on the other side.
    """
    before, after = (_boxes(gmsh, name) for name in (left, right))
    if len(before) != len(after):
        raise MeshError(
            f"repeats: '{left}' has {len(before)} faces and '{right}' {len(after)}; they are to be "
            "the same face, moved by the pitch"
        )
    pairs = [(tag, _partner(box - np.tile(shift, 2), before)) for tag, box in after.items()]
    off = max(gap for _, (_, gap) in pairs)
    if off > SAME * np.linalg.norm(shift):
        raise MeshError(
            f"repeats: moved by the pitch '{left}' is {off:.3g} mm from '{right}'; they are to be "
            "the same face, moved by pitch along axis"
        )
    moved = np.eye(4)
    moved[:3, 3] = shift
    mine, partners = zip(*((tag, partner) for tag, (partner, _) in pairs), strict=True)
    gmsh.model.mesh.setPeriodic(2, mine, partners, moved.ravel().tolist())


def _boxes(gmsh: ModuleType, name: str) -> dict[int, Array]:
    """Tag of each face of a group -> the corners (6,) of its box, mm."""
    groups = {
        gmsh.model.getPhysicalName(*group): group for group in gmsh.model.getPhysicalGroups(2)
    }
    if name not in groups:
        raise MeshError(f"repeats: there is no surface '{name}'")
    tags = gmsh.model.getEntitiesForPhysicalGroup(*groups[name])
    return {int(tag): np.array(gmsh.model.getBoundingBox(2, tag)) for tag in tags}


def _partner(box: Array, others: dict[int, Array]) -> tuple[int, float]:
    """The nearest of other boxes, and how far it is off, mm."""
    gaps = {tag: float(np.abs(box - other).max()) for tag, other in others.items()}
    nearest = min(gaps, key=gaps.__getitem__)
    return nearest, gaps[nearest]

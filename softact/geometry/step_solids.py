"""gmsh's solids and faces beside those in the text of the STEP file that they were read from.

OCC keeps the order of the file, as a rule, and the corners of each face say whether it did. It may
move a solid (an assembly's parts are placed), so distances of corners are compared, and may give a
face more corners than the file has (the poles of a sphere), which then counts by its place alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType

import numpy as np

from softact.geometry.step_names import Body, Face

TOLERANCE = 1e-5  # of the size of a solid


@dataclass(frozen=True)
class Solid:
    """A solid in gmsh: its tag, its name ("" for none), its faces' tags and their names."""

    tag: int
    name: str
    faces: tuple[int, ...]
    face_names: tuple[str, ...]


def named(gmsh: ModuleType, bodies: Sequence[Body], scale: float | None) -> list[Solid]:
    """The solids of gmsh's current model, in mm, with the names that the file gives them.

    bodies: in the order of the file. scale: mm of the file's unit, None where it has several. A
    solid that fits none of the bodies, or several with other names, has no name, and neither have
    its faces.
    """
    tags = [tag for _, tag in gmsh.model.getEntities(3)]
    solids = []
    for position, tag in enumerate(tags):
        faces = tuple(f for _, f in gmsh.model.getBoundary([(3, tag)], oriented=False))
        corners = [_corners(gmsh, face) for face in faces]
        distances = [_moved(corners, body.faces, scale) for body in bodies]
        fitting = [b for b, d in zip(bodies, distances, strict=True) if d is not None]
        in_place = [b for b, d in zip(bodies, distances, strict=True) if d == 0.0]
        label = gmsh.model.getEntityName(3, tag)  # ends with the product
        of_product = [b for b in fitting if b.product and label.endswith(b.product)]
        both = [body for body in of_product if body in in_place]
        in_order = bodies[position] if len(tags) == len(bodies) else None
        body = _one(both or of_product or in_place or fitting, in_order)
        names = tuple(face.name for face in body.faces) if body else ("",) * len(faces)
        solids.append(Solid(tag, body.name if body else "", faces, names))
    return solids


def _one(fitting: list[Body], in_order: Body | None) -> Body | None:
    """The body that a solid is, of all that fit it: the one at its place in the file where there
    are several."""
    if in_order in fitting:
        return in_order
    return fitting[0] if fitting and all(body == fitting[0] for body in fitting) else None


def _corners(gmsh: ModuleType, face: int) -> np.ndarray:
    tags = {tag for _, tag in gmsh.model.getBoundary([(2, face)], oriented=False, recursive=True)}
    return np.array([gmsh.model.getValue(0, tag, []) for tag in sorted(tags)]).reshape(-1, 3)


def _moved(found: list[np.ndarray], wanted: tuple[Face, ...], scale: float | None) -> float | None:
    """How far (mm) faces have been moved from those in the file, of the same corners in the same
    order; None where they are others. scale: mm of the file's unit, None where nobody knows it."""
    if len(found) != len(wanted):
        return None
    expected = [np.array(sorted(face.corners)).reshape(-1, 3) for face in wanted]
    both = [(a, b) for a, b in zip(found, expected, strict=True) if len(b) and len(a) == len(b)]
    if not both:
        return None if any(map(len, expected)) else 0.0  # a ball has no corners in the file
    ours, theirs = (np.vstack(side) for side in zip(*both, strict=True))
    size = _spread(ours)
    scale = scale or size / _spread(theirs)
    middle, other_middle = ours.mean(axis=0), scale * theirs.mean(axis=0)
    for a, b in both:
        off = _distances(a, middle) - _distances(scale * b, other_middle)
        if not np.abs(off).max() < TOLERANCE * size:
            return None
    distance = float(np.linalg.norm(middle - other_middle))
    return distance if distance > TOLERANCE * size else 0.0


def _spread(points: np.ndarray) -> float:
    return max(float(np.linalg.norm(points - points.mean(axis=0), axis=1).max()), 1e-300)


def _distances(corners: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """Distances of corners to a point and to each other, each sorted: rigid motions keep them."""
    among = np.linalg.norm(corners[:, None] - corners[None], axis=2)
    return np.concatenate(
        [np.sort(np.linalg.norm(corners - middle, axis=1)), np.sort(among.ravel())]
    )

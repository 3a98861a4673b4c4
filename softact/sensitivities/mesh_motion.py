"""How the mesh of a spec moves with the parameters of its geometry."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from softact.geometry.base import THINNEST, Geometry, move_mesh
from softact.geometry.carrying import OTHER_CELLS, NotMovedError
from softact.geometry.flat_sheets import SheetGeometry
from softact.geometry.imported import Imported
from softact.geometry.motion import PARTS, REPEATED, Moved
from softact.geometry.steps import OtherCountsError, recorded, repeated
from softact.sensitivities.parameters import Parameter, changed

#: Part of a parameter by which it is made smaller and larger, to see how the mesh moves. Lengths
#: that are nearer than 1e-7 mm are one, so it is no smaller.
WIDTH = 1e-4
STRAIGHT = np.empty((0, 2), np.int64)  # no edge is curved
IMPORTED = "a mesh that softact does not make itself cannot be moved"


def mesh_motion(
    geometry: Geometry, parameters: Sequence[Parameter], path: Path, curved: bool
) -> Moved:
    """How the points of the mesh move with each parameter, which are those of the geometry; or why
    they do not. path: of a file for the answer of gmsh's process. curved: whether edges may be.

    Raises MeshError where there is no mesh at all.
    """
    if isinstance(geometry, Imported):
        return Moved(np.empty((0, 3)), STRAIGHT, [IMPORTED] * len(parameters), REPEATED)
    pairs = [_pair(geometry, parameter) for parameter in parameters]
    found = [pair for pair in pairs if not isinstance(pair, str)]
    if isinstance(geometry, SheetGeometry):
        moved = _of_sheets(geometry, found)
    elif found:
        move_mesh(geometry, found, path, curved)
        moved = Moved.stored(path)
    else:
        moved = Moved(np.empty((0, 3)), STRAIGHT, [], REPEATED)
    velocities = iter(moved.velocities)
    every = [pair if isinstance(pair, str) else next(velocities) for pair in pairs]
    return Moved(moved.points, moved.edges, every, moved.means)


def _pair(geometry: Geometry, parameter: Parameter) -> tuple[Geometry, Geometry, float] | str:
    """The geometry with a smaller and a larger parameter, as far as both can be built, and how far
    they are apart; else what is wrong with them."""
    place, width = parameter.place[1:], WIDTH * (abs(parameter.value) or 1.0)
    low, high = (changed(geometry, place, parameter.value + s * width) for s in (-1, 1))
    faults = [_fault(low), _fault(high)]
    if all(faults):
        return faults[0]
    if faults[0]:
        return geometry, high, width
    return (low, geometry, width) if faults[1] else (low, high, 2 * width)


def _fault(geometry: Geometry) -> str:
    """What is wrong with a geometry; empty: nothing."""
    values = [getattr(geometry, name) for name in type(geometry).model_fields]
    if any(isinstance(v, float) and 0 < v < THINNEST for v in values):
        return f"a length under {THINNEST:g} mm would vanish"
    return next((f"{name}: {why}" for name, why in geometry.faults()), "")


def _of_sheets(geometry: SheetGeometry, pairs: Sequence[tuple[Geometry, Geometry, float]]) -> Moved:
    with recorded() as numbers:
        base = geometry.sheet_mesh()

    def points(other: Geometry) -> np.ndarray:
        assert isinstance(other, SheetGeometry)
        try:
            with repeated(numbers):
                mesh = other.sheet_mesh()
        except OtherCountsError:
            raise NotMovedError(PARTS) from None
        if not np.array_equal(mesh.triangles, base.triangles):
            raise NotMovedError(OTHER_CELLS)
        return mesh.points

    velocities: list[np.ndarray | str] = []
    for low, high, width in pairs:
        try:
            velocities.append((points(high) - points(low)) / width)
        except NotMovedError as error:
            velocities.append(str(error))
    return Moved(base.points, STRAIGHT, velocities, REPEATED)

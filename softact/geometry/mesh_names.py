"""Names for the triangles of a mesh's skin, by place and direction, where its file gives none."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from softact.errors import MeshError
from softact.geometry import part_axis
from softact.geometry.mesh_files import skin_shells
from softact.geometry.step_faces import CAVITY, NEAR, OUTER, SAME_DIRECTION, Selection
from softact.mesh.file_mesh import FileMesh


def automatic(mesh: FileMesh, clamp: str, tip: str, axis: str) -> dict[str, np.ndarray]:
    """As ``step_faces.automatic``, of triangles: name -> (k, 3).

    The shell with the largest box of each body is its outside.
    """
    outside, rooms = _shells(mesh, axis)
    x = mesh.points[outside][:, :, part_axis.component(axis)]
    near = NEAR * float(np.linalg.norm(np.ptp(mesh.points, axis=0))) + 1e-6
    found = {}
    at_clamp, at_tip = part_axis.clamp_and_tip(axis, x.min(), x.max())
    for name, at in ((clamp, at_clamp), (tip, at_tip)):
        found[name] = outside[(np.abs(x - at) < near).all(axis=1)]
    if rooms:
        found[CAVITY] = np.vstack(rooms)
    found |= {f"{CAVITY}_{number}": room for number, room in enumerate(rooms, start=1)}
    at_ends = (np.abs(x - x.min()) < near).all(axis=1) | (np.abs(x - x.max()) < near).all(axis=1)
    found[OUTER] = outside[~at_ends]
    return {name: triangles for name, triangles in found.items() if name and len(triangles)}


def _shells(mesh: FileMesh, axis: str) -> tuple[np.ndarray, list[np.ndarray]]:
    """The triangles outside, and those around each room, from the clamp on."""

    def box(shell: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        places = mesh.points[shell].reshape(-1, 3)
        return places.min(axis=0), places.max(axis=0)

    outside: list[np.ndarray] = []
    rooms: list[np.ndarray] = []
    found = sorted(
        skin_shells(mesh.cells), key=lambda shell: -np.linalg.norm(np.subtract(*box(shell)))
    )
    for shell in found:
        low, high = box(shell)
        boxes = [box(other) for other in outside]
        inside = any((b[0] < low).all() and (high < b[1]).all() for b in boxes)
        (rooms if inside else outside).append(shell)
    rooms.sort(key=lambda shell: part_axis.order(axis, *box(shell)))
    return np.vstack(outside), rooms


def chosen(mesh: FileMesh, select: Mapping[str, Selection]) -> dict[str, np.ndarray]:
    """The triangles of the skin that selections mean. Raises MeshError where one means none."""
    skin = np.vstack(skin_shells(mesh.cells))
    corners = mesh.points[skin]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    near = NEAR * float(np.linalg.norm(np.ptp(mesh.points, axis=0))) + 1e-6
    found = {
        name: skin[_holds(selection, corners, normal, near)] for name, selection in select.items()
    }
    empty = [
        f"select.{name} chooses no triangle of the skin" for name, t in found.items() if not len(t)
    ]
    if empty:
        raise MeshError(*empty)
    return found


def _holds(
    selection: Selection, corners: np.ndarray, normal: np.ndarray, near: float
) -> np.ndarray:
    """Which triangles (k, 3, 3) a selection means; normal: (k, 3), outward."""
    good = np.full(len(corners), True)
    for axis, value in (selection.plane or {}).items():
        good &= (np.abs(corners[:, :, "xyz".index(axis)] - value) < near).all(axis=1)
    if selection.normal:
        wanted = np.array(selection.normal) / np.linalg.norm(selection.normal)
        good &= np.linalg.norm(normal - wanted, axis=1) < 1e2 * SAME_DIRECTION
    if selection.box:
        low, high = np.sort(np.array(selection.box), axis=0)
        good &= ((corners > low - near) & (corners < high + near)).all(axis=(1, 2))
    return good

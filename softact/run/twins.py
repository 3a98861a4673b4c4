"""The twins of a run: models of its spec with one number a little changed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from softact import compat
from softact.errors import MeshError
from softact.geometry.motion import Moved
from softact.mesh.curves import EDGES, Curves
from softact.mesh.sheets import SheetMesh
from softact.mesh.tetrahedra import Mesh
from softact.run.from_spec import load_steps, model_on, supports_of
from softact.sensitivities.parameters import Parameter, changed, chosen
from softact.sensitivities.twin import Case, Twin

if TYPE_CHECKING:
    from softact.model import Model
    from softact.spec import Spec

SAME_PLACE = 1e-8  # of the body's size


def make_twins(spec: Spec, model: Model, paths: Sequence[str], motion: Path | None) -> list[Twin]:
    """A twin for each parameter at these paths. Collective.

    motion: file that tells how the mesh moves with those of the geometry, in their order.
    """
    parameters = chosen(spec, paths) if paths else []
    moved = Moved.stored(motion) if motion else None
    velocities = iter(moved.velocities if moved else ())
    return [
        _twin(spec, model, p, moved, next(velocities) if p.of_geometry else None)
        for p in parameters
    ]


def _twin(
    spec: Spec,
    model: Model,
    parameter: Parameter,
    moved: Moved | None,
    velocity: np.ndarray | str | None,
) -> Twin:
    other = changed(spec, parameter.place, parameter.value + parameter.step)
    mesh = replace(model.mesh, layout=other.layout())
    if moved is not None and isinstance(velocity, np.ndarray):
        mesh = _move(mesh, moved, parameter.step * velocity)
    there = model_on(mesh, other, model)
    case = Case(there, supports_of(other.supports or ()), load_steps(other, there))
    return Twin(parameter, case)


def _move(mesh: Mesh, moved: Moved, way: np.ndarray) -> Mesh:
    """A mesh with its points and the middles of its edges moved; way (n + k, 3) of these."""
    of_points = moved.of_points(way)
    if mesh.domain is not None:
        number = _numbers(moved.points, mesh.points, mesh.original_points)
        places = mesh.points + of_points[number]
        mesh = replace(mesh, moved=places, middles=_middles(mesh, moved, way, number))
    if mesh.sheets is not None:
        sheets: SheetMesh = mesh.sheets
        number = _numbers(moved.points, sheets.points, np.arange(len(sheets.points)))
        places = sheets.points + of_points[number]
        bent = sheets.bent
        middles = bent.places + moved.of_middles(way, number[bent.edges])
        bent = Curves(bent.edges, middles)
        mesh = replace(mesh, sheets=replace(sheets, points=places, bent=bent))
    return mesh


def _middles(mesh: Mesh, moved: Moved, way: np.ndarray, number: np.ndarray) -> np.ndarray | None:
    """Places (cells, 6, 3) of the middles of a solid's edges; straight ones stay straight.

    number: of each point among those that were moved.
    """
    if mesh.middles is None:
        return None
    ends = compat.geometry_dofs(mesh.domain)[:, EDGES]
    straight = moved.of_points(way)[number[ends]].mean(axis=-2)
    off = mesh.middles - mesh.points[ends].mean(axis=-2)
    are_straight = np.linalg.norm(off, axis=-1, keepdims=True) < SAME_PLACE * np.ptp(mesh.points)
    return mesh.middles + np.where(are_straight, straight, moved.of_middles(way, number[ends]))


def _numbers(points: np.ndarray, places: np.ndarray, order: np.ndarray) -> np.ndarray:
    """Numbers (k,) of the points that lie at these places (k, 3); ``order`` where it is right.

    Raises MeshError where a place is none of theirs.
    """
    small = SAME_PLACE * float(np.ptp(points, axis=0).max())
    if order.max(initial=-1) < len(points) and np.abs(points[order] - places).max() < small:
        return order
    gaps, found = cKDTree(points).query(places)
    if gaps.max(initial=0.0) > small:
        raise MeshError("the mesh that was moved is another one than that of the run")
    return found

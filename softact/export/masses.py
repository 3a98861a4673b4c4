"""Where the mass of an actuator is: from its undeformed mesh and the densities of its spec.

The air in the cavities and what is not in the mesh (tubes, fittings) have no mass.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from softact.materials import Law
from softact.results.folder import Results
from softact.spec import Spec


@dataclass(frozen=True)
class Lumps:
    """Masses of parts of an actuator along its axis.

    mass: (k,) tonne. centre: (k, 3) mm, in the model's directions. inertia: (k, 3, 3) tonne·mm²
    about the centres.
    """

    mass: np.ndarray
    centre: np.ndarray
    inertia: np.ndarray


@dataclass(frozen=True)
class Contents:
    """What the parts of an actuator hold: region -> per volume, surface -> per area."""

    solids: Mapping[str, float]
    surfaces: Sequence[tuple[str, float]]


def contents(spec: Spec, of: Callable[[Law], float]) -> Contents:
    """A property of the materials; of a layer or sheet, times its thickness."""
    films = [(layer.surface, layer.thickness * of(layer.material)) for layer in spec.layers]
    for name, sheet in spec.sheets.items():
        films.append((name, sum(ply.thickness * of(ply.material) for ply in sheet.plies)))
    return Contents({name: of(law) for name, law in spec.materials.items()}, films)


def point_masses(run: Results, spec: Spec) -> tuple[np.ndarray, np.ndarray]:
    """Places (n, 3), mm, and masses (n,), tonne, of the undeformed actuator; see ``points``."""
    return points(run, contents(spec, lambda law: law.density))


def points(run: Results, held: Contents) -> tuple[np.ndarray, np.ndarray]:
    """Undeformed places (n, 3) of points, and (n,) what each holds.

    A cell is as many points as it has corners, so placed that its mass, centre and inertia are
    exact where its edges are straight. A half is completed by its mirror image.
    """
    parts = []
    if run.cells.shape[1] in (4, 10):
        corners = run.points[run.cells[:, :4]]
        volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
        densities = np.array([held.solids[name] for name in run.region_names])
        parts.append(_spread(corners, volumes * densities[run.region]))
    for surface, density in held.surfaces:
        corners = run.points[run.surfaces[surface][:, :3]]
        parts.append(_spread(corners, density * triangles(run, surface)[1]))
    places = np.concatenate([place for place, _ in parts])
    amounts = np.concatenate([amount for _, amount in parts])
    for plane in run.layout.symmetry.values():
        mirror = np.where(np.arange(3) == plane, -1.0, 1.0)
        places, amounts = np.vstack([places, places * mirror]), np.tile(amounts, 2)
    return places, amounts


def _spread(corners: np.ndarray, amounts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Simplices (n, k, 3) as k points each on the lines from the centre to the corners; exact for
    second moments (k points of a rule of degree two: 1/sqrt(k + 1) of the way)."""
    count = corners.shape[1]
    centres = corners.mean(axis=1, keepdims=True)
    places = centres + (corners - centres) / np.sqrt(count + 1)
    return places.reshape(-1, 3), np.repeat(amounts / count, count)


def triangles(run: Results, surface: str) -> tuple[np.ndarray, np.ndarray]:
    """Centres (k, 3) mm and areas (k,) mm² of the triangles of a surface of the meshed part."""
    corners = run.points[run.surfaces[surface][:, :3]]
    sides = corners[:, 1:] - corners[:, :1]
    return corners.mean(axis=1), np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2


def centre(run: Results, surface: str) -> np.ndarray:
    """Centre (3,) mm of a surface of the whole undeformed actuator."""
    centres, areas = triangles(run, surface)
    found = areas @ centres / areas.sum()
    for plane in run.layout.symmetry.values():
        found[plane] = 0.0
    return found


def lumps(places: np.ndarray, masses: np.ndarray, borders: ArrayLike) -> Lumps:
    """Masses between borders along x; what lies outside counts to the first or the last."""
    count = np.size(borders) - 1
    number = np.clip(np.searchsorted(np.asarray(borders), places[:, 0]) - 1, 0, count - 1)
    mass = np.bincount(number, masses, count)
    safe = np.maximum(mass, 1e-300)
    first = np.stack([np.bincount(number, masses * x, count) for x in places.T], axis=1)
    middle = first / safe[:, None]
    arms = places - middle[number]
    squares = np.einsum("ni,nj->nij", arms, arms)
    turning = masses[:, None, None] * (np.trace(squares, axis1=1, axis2=2)[:, None, None]
                                       * np.eye(3) - squares)  # fmt: skip
    inertia = np.zeros((count, 3, 3))
    np.add.at(inertia, number, turning)
    return Lumps(mass, middle, inertia)

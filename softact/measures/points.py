"""Points of the undeformed actuator, and how they follow the nodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from softact import compat
from softact.errors import SpecError
from softact.materials.tensors import COLUMNS, ROWS

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot
    from softact.model import Model

# How far beyond its element a point may lie, as a barycentric coordinate: walls are faceted.
BEYOND = 0.1


@dataclass(frozen=True)
class Probe:
    """A point of the undeformed body (mm), and how it follows the nodes.

    nodes, weights: (k,) of the element that it is in, on one process; none on the others. mirror:
    (3,) signs where the point is of a mirror image of the meshed part.
    """

    point: np.ndarray
    nodes: np.ndarray
    weights: np.ndarray
    mirror: np.ndarray

    def place(self, snapshot: Snapshot) -> np.ndarray:
        """Where the point is (3,), mm. Collective."""
        moved = self.weights @ snapshot.displacement[self.nodes]
        return self.point + self.mirror * snapshot.model.sum(moved)

    def stress(self, snapshot: Snapshot) -> np.ndarray:
        """Cauchy stress (6,) at the point in Voigt's order, MPa, from the nodal means. Collective.

        A component between the normal of a plane and a direction in it changes its sign in the
        mirror image.
        """
        here = self.weights @ snapshot.cauchy[self.nodes]
        return self.mirror[ROWS] * self.mirror[COLUMNS] * snapshot.model.sum(here)


def locate(model: Model, points: Mapping[str, tuple[float, float, float]]) -> dict[str, Probe]:
    """The probes of points (mm) of the undeformed actuator. Collective.

    On a mesh of sheets alone a point is that of the nearest node. Raises SpecError where a point is
    outside.
    """
    return {name: _probe(model, name, np.asarray(point)) for name, point in points.items()}


def _probe(model: Model, name: str, point: np.ndarray) -> Probe:
    mirror, places = np.ones(3), model.nodes.places
    for axis in model.mesh.layout.symmetry.values():
        if point[axis] * model.sum(float(places[:, axis].sum())) < 0:
            mirror[axis] = -1.0
    here = mirror * point
    gap, nodes, weights = _in_solids(model, here) if model.solids else _on_sheets(model, here)
    gaps = model.comm.allgather(gap)
    if min(gaps) > BEYOND:
        distances = np.linalg.norm(places - here, axis=1)
        nearest = min(
            (float(d.min()), tuple(p[d.argmin()]))
            for d, p in model.comm.allgather((distances, places))
        )
        where = ", ".join(f"{c:.4g}" for c in mirror * nearest[1])
        raise SpecError(
            f"probes.{name}: the point is {nearest[0]:.3g} mm outside of the undeformed body; its "
            f"nearest node is at ({where}) mm"
        )
    if model.comm.rank != int(np.argmin(gaps)):
        nodes, weights = nodes[:0], weights[:0]
    return Probe(point, nodes, weights, mirror)


def _in_solids(model: Model, point: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """How far (0: inside) the nearest element of this process is from a point, in barycentric
    coordinates, its nodes and their weights at the point."""
    cells = model.cell_nodes
    if not len(cells):
        return np.inf, np.empty(0, int), np.empty(0)
    corners = model.nodes.places[cells[:, :4]]
    edges = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)
    local = np.linalg.solve(edges, (point - corners[:, 0])[..., None])[..., 0]
    outside = -np.minimum(local.min(axis=1), 1 - local.sum(axis=1))
    best = int(outside.argmin())
    weights = compat.tabulate_values(model.degree, local[best : best + 1])
    return max(float(outside[best]), 0.0), cells[best], np.ravel(weights)


def _on_sheets(model: Model, point: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """The nearest node as the same; how far it is counts by a hundredth of the actuator's size."""
    distances = np.linalg.norm(model.nodes.places - point, axis=1)
    nearest = int(distances.argmin())
    far = float(distances[nearest]) / model.diagonal
    return far, np.array([nearest]), np.ones(1)

"""One equilibrium, seen by the measures: nodal fields, the tip's motion, reactions.

Everything here is collective: all processes ask for the same things in the same order.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from softact import compat
from softact.bodies.soundness import NOTHING, Smallest, smallest_jacobian
from softact.materials.tensors import largest_eigenvalue, symmetric, von_mises
from softact.measures.nodal_means import nodal_means, nodal_means_at
from softact.measures.sheet_fields import sheet_stress, sheet_stretch, sheet_wrinkles
from softact.mesh.node_order import vtk_order
from softact.model import Model
from softact.system.term import State

if TYPE_CHECKING:
    from softact.bodies.solid import Solid
    from softact.measures.points import Probe
    from softact.measures.target_line import Followed
    from softact.mesh.layout import Layout

#: Points, cells, regions and surfaces, see ``gather_mesh``.
WholeMesh = tuple[np.ndarray, np.ndarray, np.ndarray, dict[str, np.ndarray]]
# A tip that is a straight line: second by first singular value.
STRAIGHT = 1e-9


@dataclass(frozen=True)
class Motion:
    """Points of a surface before and after (k, 3) in mm; weights (k,): their shares of its area."""

    before: np.ndarray
    after: np.ndarray
    weights: np.ndarray

    @property
    def centre_before(self) -> np.ndarray:
        """Centre of the undeformed surface."""
        return self.weights @ self.before

    @property
    def centre_after(self) -> np.ndarray:
        """Mean position of the deformed surface, by undeformed area."""
        return self.weights @ self.after


@dataclass
class Deciding:
    """What decided in the row of a snapshot.

    failure: region -> criterion -> process and, there, number of the point, see ``percentile``.
    jacobian: process, region and cell of the smallest J. growth: nodes (k,) of the slice that
    swells most, as all processes together number theirs.
    """

    failure: dict[str, Mapping[str, tuple[int, int]]] = field(default_factory=dict)
    jacobian: tuple[int, str, int] | None = None
    growth: np.ndarray | None = None


@dataclass
class Snapshot:
    """A model in one state. Lengths in mm, stresses in MPa.

    previous: the columns of the last accepted row, for what is counted on (angles past 180°,
    work). safety_factor: by which a failure pressure is divided to get the safe one. actuator: of a
    model that differs a little from another one, the snapshot of that after its row was made: what
    is largest or smallest is looked at where it is that there.
    """

    model: Model
    state: State
    previous: dict[str, float] = field(default_factory=dict)
    safety_factor: float = 1.0
    probes: Mapping[str, Probe] = field(default_factory=dict)
    followed: Followed | None = None
    actuator: Snapshot | None = None
    deciding: Deciding = field(default_factory=Deciding)
    _cauchy: dict[str, np.ndarray] = field(default_factory=dict)
    _covers: dict[tuple[str, str], bool] = field(default_factory=dict)

    @property
    def layout(self) -> Layout:
        """Names of the parts and what they mean."""
        return self.model.mesh.layout

    @property
    def decider(self) -> Snapshot | None:
        """Whose points decide in this row; None where all count, as where there are sheets."""
        return None if self.model.sheets else self.actuator

    @property
    def decided(self) -> Deciding | None:
        """What decides in this row; None as above."""
        return self.decider.deciding if self.decider else None

    @functools.cached_property
    def deciding_nodes(self) -> np.ndarray:
        """Nodes (k,) of this process where a field is largest in a region, and those of probes."""
        names = ("max_principal_stress", "von_mises", "max_principal_stretch")
        fields = [self.__dict__[name] for name in names if name in self.__dict__]
        found = [probe.nodes for probe in self.probes.values()]
        for nodes in self.model.parts.nodes.values():
            found += [nodes[[np.argmax(values[nodes])]] for values in fields if len(nodes)]
        number = self.model.nodes.number
        every = self.model.comm.allgather(number[np.concatenate([np.empty(0, int), *found])])
        return np.flatnonzero(np.isin(number, np.concatenate(every)))

    @functools.cached_property
    def deciding_cells(self) -> dict[str, np.ndarray]:
        """Cells of each solid at ``deciding_nodes``."""
        return self.model.parts.cells_at(self.deciding_nodes)

    @functools.cached_property
    def solids(self) -> dict[str, Solid]:
        """Where fields are looked at: all solids, or the parts of them that decide."""
        solids = self.model.solids
        if self.decider is None:
            return solids
        chosen = self.decider.deciding_cells
        return {name: solid.part(chosen[name]) for name, solid in solids.items()}

    def _at_nodes(self, of: Callable[[np.ndarray], np.ndarray], tensors: np.ndarray) -> np.ndarray:
        """A number (nodes,) of nodal tensors (nodes, 6); −inf at nodes that do not decide."""
        if self.decider is None:
            return of(tensors)
        found, nodes = np.full(len(tensors), -np.inf), self.decider.deciding_nodes
        found[nodes] = of(tensors[nodes])
        return found

    @functools.cached_property
    def positions(self) -> np.ndarray:
        """Undeformed positions (nodes, 3) of the displacement nodes that this process holds."""
        return self.model.nodes.places

    @functools.cached_property
    def displacement(self) -> np.ndarray:
        """Displacements (nodes, 3) of the nodes that this process holds."""
        return self.state.x[self.model.displacement_dofs]

    def motion(self, surface: str) -> Motion:
        """How a surface of the whole actuator moves; the same on all processes.

        Halves are completed by their mirror images.
        """
        here, weights = self.model.surfaces.points(surface)
        mine = self.positions[here], self.displacement[here], weights
        parts = zip(*self.model.comm.allgather(mine), strict=True)
        before, moved, weights = (np.concatenate(part) for part in parts)
        after = before + moved
        for plane in self.layout.symmetry.values():
            mirror = np.ones(3)
            mirror[plane] = -1
            before, after = np.vstack([before, mirror * before]), np.vstack([after, mirror * after])
            weights = np.tile(weights, 2)
        return Motion(before, after, weights / weights.sum())

    @functools.cached_property
    def tip(self) -> Motion:
        """Motion of the tip's end face, see ``motion``."""
        return self.motion(self.layout.tip)

    @functools.cached_property
    def tip_rotation(self) -> np.ndarray:
        """Rotation matrix of the tip's end face, counted from that of the layout's base."""
        turned = best_rotation(self.tip)
        if self.layout.base is None:
            return turned
        return best_rotation(self.motion(self.layout.base)).T @ turned

    @functools.cached_property
    def cavity_volumes(self) -> dict[str, float]:
        """Volume of each cavity of the meshed part, mm³."""
        names = self.layout.cavities
        return {name: self.model.cavity_volume(self.state, name) for name in names}

    # --- fields -----------------------------------------------------------------------------

    def average_at_nodes(self, per_solid: list[np.ndarray]) -> np.ndarray:
        """Volume-weighted mean at the nodes of what the cells say there.

        per_solid: for each of ``solids`` (cells, nodes per cell, k); returns (nodes, k), zero
        where no solid is and at nodes that do not decide.
        """
        values = list(zip(self.solids.values(), per_solid, strict=True))
        if self.decider is None:
            return nodal_means(self.model, values)
        return nodal_means_at(self.model, values, self.decider.deciding_nodes)

    def cauchy_at_points(self, name: str) -> np.ndarray:
        """Cauchy stress (cells, points, 3, 3) at the quadrature points of one of ``solids``."""
        if name not in self._cauchy:
            self._cauchy[name] = self.solids[name].cauchy(self.state)
        return self._cauchy[name]

    @functools.cached_property
    def cauchy(self) -> np.ndarray:
        """Cauchy stress (nodes, 6) in Voigt's order: extrapolated from the quadrature points,
        averaged."""
        if not self.model.solids:
            return self.sheet_cauchy
        extrapolation, values = _extrapolation(self.model.degree), []
        for name in self.model.solids:
            sigma = self.cauchy_at_points(name)
            values.append(extrapolation @ symmetric(sigma).reshape(*sigma.shape[:2], 6))
        return self._with_sheets(self.average_at_nodes(values), lambda: self.sheet_cauchy)

    @functools.cached_property
    def sheet_cauchy(self) -> np.ndarray:
        """Cauchy stress (nodes, 6) of the sheets, zero where there is none."""
        return sheet_stress(self.model, self.state)

    def _with_sheets(self, values: np.ndarray, of_sheets: Callable[[], np.ndarray]) -> np.ndarray:
        """Nodal values with those of sheets at the nodes that no solid has."""
        loose = len(self.model.unknowns.loose_dofs)
        if loose:
            values[-loose:] = of_sheets()[-loose:]
        return values

    @functools.cached_property
    def max_principal_stress(self) -> np.ndarray:
        """Largest principal Cauchy stress (nodes,)."""
        return self._at_nodes(largest_eigenvalue, self.cauchy)

    @functools.cached_property
    def von_mises(self) -> np.ndarray:
        """Von Mises stress (nodes,)."""
        return self._at_nodes(von_mises, self.cauchy)

    @functools.cached_property
    def max_principal_stretch(self) -> np.ndarray:
        """Largest principal stretch (nodes,), from the averaged C = FᵀF."""
        if not self.model.solids:
            return sheet_stretch(self.model, self.state)
        gradients = compat.tabulate_gradients(
            self.model.degree, compat.reference_nodes(self.model.degree)
        )
        values = []
        for solid in self.solids.values():
            values.append(solid.right_cauchy_green(self.state.x, gradients))
        squares = self._at_nodes(largest_eigenvalue, self.average_at_nodes(values))
        found = np.sqrt(np.maximum(squares, 0.0))
        return self._with_sheets(found, lambda: sheet_stretch(self.model, self.state))

    def quadrature_places(self, solid: Solid, chosen: np.ndarray) -> np.ndarray:
        """Undeformed places (k, 3), mm, of quadrature points of a solid.

        chosen: (k,) their numbers, counted cell after cell.
        """
        from softact.system.forms import QUADRATURE_DEGREE

        points, _ = compat.quadrature_rule(QUADRATURE_DEGREE)
        cell, point = np.divmod(chosen, len(points))
        return solid.places(points, cell)[np.arange(len(cell)), point]

    def largest(self, values: np.ndarray) -> tuple[float, np.ndarray]:
        """Largest nodal value over all processes and its undeformed place (3,) in mm."""
        here = int(np.argmax(values))
        found = self.model.comm.allgather((float(values[here]), self.positions[here]))
        return max(found, key=lambda pair: pair[0])

    @property
    def smallest_jacobian(self) -> Smallest:
        """The smallest J anywhere in an element of the whole actuator, and where."""
        comm, x, found = self.model.comm, self.state.x, [(NOTHING, "")]
        for name, solid in self.model.solids.items():
            if self.decided is None or self.decided.jacobian is None:
                found.append((smallest_jacobian(solid, x), name))
            elif self.decided.jacobian[:2] == (comm.rank, name):
                cell = np.array([self.decided.jacobian[2]])
                found.append((smallest_jacobian(solid, x, cell), name))
        every = comm.allgather(min(found))
        rank = min(range(comm.size), key=every.__getitem__)
        worst, name = every[rank]
        self.deciding.jacobian = rank, name, worst.cell
        return worst

    def nodal_fields(self) -> dict[str, np.ndarray]:
        """The fields of ``fields.h5`` at this process's nodes."""
        wrinkles = sheet_wrinkles(self.model, self.state)
        return ({} if wrinkles is None else {"wrinkled": wrinkles}) | {
            "displacement": self.displacement,
            "hydrostatic_pressure": self.cauchy[:, :3].mean(axis=1),
            "von_mises": self.von_mises,
            "max_principal_stress": self.max_principal_stress,
            "max_principal_stretch": self.max_principal_stretch,
        }

    def of_whole(self, force: np.ndarray) -> np.ndarray:
        """Force (3,) on the whole actuator from that on the part that was meshed."""
        for plane in self.layout.symmetry.values():
            force = np.where(np.arange(3) == plane, 0.0, 2.0) * force
        return force

    @functools.cached_property
    def reaction(self) -> tuple[np.ndarray, np.ndarray]:
        """Force (3,) N and moment (3,) N·mm about the layout's origin that the clamp exerts on
        the whole actuator."""
        return self.reaction_at(self.layout.clamp, np.asarray(self.layout.origin))

    def reaction_at(self, surface: str, about: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force (3,) N and moment (3,) N·mm about a point that what holds a surface exerts on the
        whole actuator; both are zero where it is free.

        Where supports of other surfaces hold the same points too, as along a common edge, each has
        an equal share of the force there.
        """
        owned = self.model.nodes.owned
        nodes = self.model.surfaces.nodes(surface)
        nodes = nodes[nodes < owned]
        dofs = self.model.displacement_dofs[nodes]
        forces = self._support_forces(surface)[dofs]
        arms = self.positions[nodes] + self.displacement[nodes] - about
        force = self.model.sum(forces.sum(axis=0))
        moment = self.model.sum(np.cross(arms, forces).sum(axis=0))
        for plane in self.layout.symmetry.values():
            # A mirror image turns round a force along the normal, a moment across it.
            moment = np.where(np.arange(3) == plane, 2.0, 0.0) * moment
        return self.of_whole(force), moment

    def _support_forces(self, surface: str) -> np.ndarray:
        """Forces (local,) N on a surface's points by the supports that hold it."""
        holders = np.zeros((2, self.model.unknowns.local))  # all of them, and those of the surface
        for support in self.model.supports:
            dofs = self.model.displacement_dofs[self.model.surfaces.nodes(support.surface)]
            for component in support.components:
                holders[0, dofs[:, component]] += 1
                holders[1, dofs[:, component]] += self._holds(support.surface, surface)
        return self._forces * holders[1] / np.maximum(holders[0], 1)

    @functools.cached_property
    def _forces(self) -> np.ndarray:
        """Forces (local,) N that the body needs at its supported nodes, at equilibrium."""
        return self.model.parts.force_at_supports(self.state)

    def held(self, surface: str) -> bool:
        """Whether a support holds a surface in some direction (symmetry planes do not count)."""
        return any(self._holds(support.surface, surface) for support in self.model.supports)

    def _holds(self, support: str, surface: str) -> bool:
        """Whether the support of a surface holds another one: itself, or one that is part of it;
        a common edge is not enough."""
        if support == surface:
            return True
        if (support, surface) not in self._covers:
            nodes = self.model.surfaces.nodes
            outside = int(np.setdiff1d(nodes(surface), nodes(support)).size)
            self._covers[support, surface] = self.model.sum(outside) == 0
        return self._covers[support, surface]


def best_rotation(motion: Motion) -> np.ndarray:
    """Rotation matrix that best maps a surface onto its deformed self.

    Least squares over its area (Kabsch 1976, Acta Cryst. A32:922).
    """
    arms = (motion.before - motion.centre_before) * motion.weights[:, None]
    u, values, vt = np.linalg.svd(arms.T @ (motion.after - motion.centre_after))
    if values[1] < STRAIGHT * values[0]:
        return _least_rotation(u[:, 0], vt[0])
    sign = np.sign(np.linalg.det(vt.T @ u.T))
    return vt.T @ np.diag([1.0, 1.0, sign]) @ u.T


def _least_rotation(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The smallest rotation between two unit vectors; about a line itself nothing is known."""
    axis, cosine = np.cross(one, other), float(one @ other)
    cross = np.cross(np.eye(3), axis)
    return np.eye(3) + cross + cross @ cross / (1 + cosine) if cosine > -1 else -np.eye(3)


@functools.cache
def _extrapolation(degree: int) -> np.ndarray:
    """Matrix (nodes, points): linear field through the four quadrature points, at the nodes."""
    from softact.system.forms import QUADRATURE_DEGREE

    points, _ = compat.quadrature_rule(QUADRATURE_DEGREE)
    nodes = compat.reference_nodes(degree)

    def barycentric(x: np.ndarray) -> np.ndarray:
        return np.column_stack([1 - x.sum(axis=1), x])

    return barycentric(nodes) @ np.linalg.inv(barycentric(points))


def gather_nodes(model: Model, values: np.ndarray) -> np.ndarray | None:
    """Nodal values (nodes, ...) of all processes in global order, on rank 0 (None elsewhere)."""
    owned = model.nodes.owned
    parts = model.comm.gather(np.ascontiguousarray(values[:owned]))
    return np.concatenate(parts) if parts is not None else None


def gather_mesh(model: Model) -> WholeMesh | None:
    """The whole mesh for output, on rank 0 (None elsewhere).

    Returns (points (n, 3), cells (m, 10) or (m, 4) in VTK order, region (m,), surfaces: name ->
    (k, 6) or (k, 3)); nodes are numbered as ``gather_nodes`` orders them.
    """
    number = model.nodes.number
    points = gather_nodes(model, model.nodes.places)
    if not model.solids:
        return _sheet_mesh(model, points) if points is not None else None
    reference = compat.reference_nodes(model.degree)
    cells = number[model.cell_nodes][:, vtk_order(reference)]
    surfaces = {
        name: _stacked(model, number[model.surfaces.facet_nodes(facets)])
        for name, facets in model.mesh.facets.items()
    }
    for name, part in model.sheets.items():
        surfaces[name] = part.triangles.nodes
    cells, region = _stacked(model, cells), _stacked(model, model.mesh.region)
    return (points, cells, region, surfaces) if points is not None else None


def _sheet_mesh(model: Model, points: np.ndarray) -> WholeMesh:
    """The same for sheets alone: the cells are their triangles, the regions the sheets."""
    parts = [part.triangles.nodes for part in model.sheets.values()]
    region = np.repeat(np.arange(len(parts)), [len(nodes) for nodes in parts])
    return points, np.concatenate(parts), region, dict(zip(model.sheets, parts, strict=True))


def _stacked(model: Model, rows: np.ndarray) -> np.ndarray:
    """The rows of all processes, on rank 0; none elsewhere."""
    return np.concatenate(model.comm.gather(rows) or [rows[:0]])

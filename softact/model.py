"""A meshed actuator with materials, loads and supports: its residual and tangent."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from softact import compat
from softact.assembly import Assembler
from softact.bending import LayerBending, is_flat
from softact.contact.contacts import Contacts
from softact.contact.facets import ContactFacets
from softact.contact.rigid import Obstacle, RigidContact
from softact.contact.surfaces import SurfaceContact, Touching
from softact.elements import facet_tables
from softact.errors import SpecError
from softact.fibres import fibre_field
from softact.mesh import Mesh
from softact.nodes import nodes_of
from softact.sheets.body import Sheet, SheetPart, make_parts, node_numbers
from softact.sheets.cavity import SheetCavity
from softact.sheets.membrane import BondedMembrane, Membrane
from softact.sheets.mesh import nodes_of as sheet_nodes_of
from softact.sheets.plane_stress import GreenLaw
from softact.sheets.tension_field import KEPT_BONDED, relaxed
from softact.sheets.triangles import Triangles
from softact.solid import Solid
from softact.tensors import determinant
from softact.terms import (
    CavityPressure,
    Inertia,
    InvertedElementError,
    Layer,
    Origin,
    State,
    SurfaceForce,
    SurfacePressure,
    Weight,
    shared_forces,
    unit_forces,
)
from softact.unknowns import Unknowns

UP = (0.0, 0.0, 1.0)
SIMPSON, TRAPEZIUM = (1 / 6, 1 / 6, 2 / 3), (1 / 2, 1 / 2)
# name in the spec -> displacement degree, pressure degree (None: no pressure unknown)
ELEMENTS: dict[str, tuple[int, int | None]] = {
    "P2/P1": (2, 1),
    "P2/P0": (2, 0),
    "P2": (2, None),
    "P1": (1, None),
}


@dataclass(frozen=True)
class BondedLayer:
    """A thin layer on a surface: its material (see ``softact.terms.Layer``), thickness in mm.

    bending: part of a plate's bending stiffness E t³/12(1 − ν²); a woven fabric has little of it.
    relaxed: whether fine wrinkles take its compression (``softact.sheets.tension_field``); None:
    where it has no bending stiffness.
    """

    surface: str
    material: object
    thickness: float
    bending: float = 1.0
    relaxed: bool | None = None


@dataclass(frozen=True)
class Support:
    """Prescribed displacements (mm) of a surface: component (0, 1, 2) -> value.

    None holds each point where it is when the support begins.
    """

    surface: str
    values: Mapping[int, float | None]


def _smaller(one, other):
    return np.minimum(one, other)


class Model:
    """Everything that decides the equilibrium of an actuator.

    mesh: see ``softact.mesh``. materials: region name -> law. layers: thin layers. element: one of
    ``ELEMENTS``. wall_normal: region name, points (n, 3) -> the wall's normal there, for fibres;
    default: up. obstacles: rigid bodies. touching: surfaces that may touch, for one process only.
    sheets: name -> what each sheet of the mesh is made of, for one process only; a mesh may have
    sheets and no solid.
    The residual is the derivative of the potential energy by the unknowns.
    """

    def __init__(
        self,
        mesh: Mesh,
        materials: Mapping[str, object],
        layers: Sequence[BondedLayer] = (),
        element: str = "P2/P1",
        wall_normal: Callable[[str, np.ndarray], np.ndarray] = lambda region, points: UP,
        obstacles: Sequence[Obstacle] = (),
        touching: Sequence[Touching] = (),
        sheets: Mapping[str, Sheet] | None = None,
    ):
        self.mesh, self.comm = mesh, mesh.comm
        self.degree, pressure_degree = ELEMENTS[element]
        self._number(pressure_degree, sheets or {})
        self.solids = {
            name: Solid(
                self.assembler,
                np.flatnonzero(mesh.region == number),
                materials[name],
                self.degree,
                pressure_degree,
                fibre_field(
                    materials[name].law, mesh.layout.axis, functools.partial(wall_normal, name)
                ),
            )
            for number, name in enumerate(mesh.layout.regions)
        }
        self.cavities = {
            name: CavityPressure(self.assembler, name, self.facets(*walls), self.degree)
            for name, walls in mesh.layout.cavities.items()
            if not set(walls) & set(self.sheets)
        } | {
            name: SheetCavity(
                name, [self.sheets[wall].triangles for wall in walls], mesh.layout.flux
            )
            for name, walls in mesh.layout.cavities.items()
            if set(walls) & set(self.sheets)
        }
        self.bonded_layers = tuple(layers)
        bending = [(la, b) for la in layers if (b := self._bending(la)) is not None]
        self.bending = [LayerBending(*b) for _, b in bending]
        self._bent = [la for la, _ in bending]
        self.layers = [self._layer(la) for la in layers]
        planes = tuple(mesh.layout.symmetry.values())
        for part in self.sheets.values():
            part.add_bending(self.assembler, self.nodes, planes)
        self.weights = [
            Weight(s.material.density * unit_forces(self.assembler, s.cells, self.degree))
            for s in self.solids.values()
        ] + [
            Weight(la.material.density * la.thickness * self._unit_forces(la.surface))
            for la in layers
            if la.material.density
        ]
        self.weights += [part.weight(self.unknowns.local) for part in self.sheets.values()]
        self.inertia: list[Inertia] = []
        self.surface_loads: dict[tuple[type, str], SurfaceForce | SurfacePressure] = {}
        self.contacts = Contacts(
            self.comm,
            [*map(self._against, obstacles), *(SurfaceContact(t, self) for t in touching)],
        )
        self.assembler.symmetric = self.contacts.symmetric
        self._ghosted = self.unknowns.create_vector()
        self.pressure_weights = self._pressure_weights()
        self.force_floor = self._force_floor()

    def _number(self, pressure_degree: int | None, sheets: Mapping[str, Sheet]) -> None:
        """Nodes and unknowns of the solids, then of the sheets."""
        mesh, spaces = self.mesh, []
        if mesh.domain is not None:
            spaces.append(compat.function_space(mesh.domain, self.degree, 3))
            if pressure_degree is not None:
                constant = pressure_degree == 0
                spaces.append(compat.function_space(mesh.domain, pressure_degree, 1, constant))
        loose, number, tables = np.empty((0, 3)), None, []
        if mesh.sheets:
            layout = mesh.layout
            mesh.sheets.check(layout.cavities, list(layout.symmetry.values()), layout.flux)
            sheet_nodes = sheet_nodes_of(mesh.sheets, self.degree)
            solid = spaces[0].tabulate_dof_coordinates() if spaces else np.empty((0, 3))
            number, loose = node_numbers(mesh.sheets, sheet_nodes, solid)
        self.unknowns = Unknowns(self.comm, spaces, len(loose))
        self.nodes = nodes_of(self.unknowns, loose)
        self.sheets: dict[str, SheetPart] = {}
        self.curves: dict[str, np.ndarray] = {}
        if mesh.sheets:
            self.sheets = make_parts(mesh.sheets, number[sheet_nodes.elements], sheets, self.nodes)
            self.curves = {name: number[edges] for name, edges in sheet_nodes.curves.items()}
            tables = [part.triangles.table for part in self.sheets.values()]
        self.assembler = Assembler(mesh, self.unknowns, tables)
        self.displacement_dofs = self.nodes.dofs
        self.cell_nodes = compat.cell_dofs(spaces[0]) if spaces else np.empty((0, 0), np.int32)

    def facets(self, *surfaces: str) -> np.ndarray:
        """Cells and local facets of the named surfaces together."""
        return np.vstack([self.mesh.facets[name] for name in surfaces])

    def _against(self, obstacle: Obstacle) -> RigidContact:
        surfaces = obstacle.surfaces or self.mesh.layout.outside
        return RigidContact(obstacle, ContactFacets(self, surfaces))

    def _bending(self, layer: BondedLayer):
        """Arguments of the layer's bending term, None where it has none (see the docs)."""
        nodes = self.facet_nodes(self.mesh.facets[layer.surface])
        everywhere = np.concatenate(self.comm.allgather(self.nodes.places[nodes].reshape(-1, 3)))
        if not layer.bending or self.degree != 2 or not is_flat(everywhere):
            return None
        young, poisson = layer.material.youngs_modulus, layer.material.poissons_ratio
        rigidity = layer.bending * young * layer.thickness**3 / (12 * (1 - poisson**2))
        planes = tuple(self.mesh.layout.symmetry.values())
        return self.assembler, self.nodes, nodes, rigidity, poisson, planes

    def bends(self, layer: BondedLayer) -> bool:
        """Whether one of ``bonded_layers`` has bending stiffness."""
        return layer in self._bent

    def wrinkles(self, layer: BondedLayer) -> bool:
        """Whether fine wrinkles take the compression of one of ``bonded_layers``."""
        return not self.bends(layer) if layer.relaxed is None else layer.relaxed

    @property
    def has_kinks(self) -> bool:
        """Whether forces have kinks: where bodies touch, and where bonded layers slacken."""
        return len(self.contacts) > 0 or any(map(self.wrinkles, self.bonded_layers))

    def _layer(self, layer: BondedLayer) -> Layer | Membrane:
        facets, material = self.facets(layer.surface), layer.material
        if not self.wrinkles(layer):
            return Layer(self.assembler, facets, material, layer.thickness, self.degree)
        nodes = self.facet_nodes(facets)
        table = self.assembler.add_table(self.nodes.blocks[nodes])
        triangles = Triangles(nodes, self.nodes.places[nodes], self.nodes.dofs[nodes], table)
        law = GreenLaw(material.youngs_modulus, material.poissons_ratio)
        frames = triangles.frames(np.array([1.0, 0.0, 0.0]))
        relaxed_law = relaxed(law, material.poissons_ratio, KEPT_BONDED)
        return BondedMembrane(triangles, frames, [(relaxed_law, layer.thickness)])

    @property
    def terms(self):
        """All parts of the potential energy."""
        return [
            *self.solids.values(),
            *self.cavities.values(),
            *self.layers,
            *self.bending,
            *(term for part in self.sheets.values() for term in part.elastic),
            *self.weights,
            *self.surface_loads.values(),
            *(inertia for inertia in self.inertia if inertia.time_step is not None),
            *self.contacts,
        ]

    def add_surface_load(self, kind: type[SurfaceForce | SurfacePressure], surface: str) -> None:
        """Make room for a load on a surface; its value is part of the state."""
        if surface in self.sheets or surface in self.curves:
            if kind is not SurfaceForce:
                raise SpecError(f"surface_pressure: '{surface}' is a sheet; only cavities press it")
        if (kind, surface) not in self.surface_loads:
            self.surface_loads[kind, surface] = (
                SurfaceForce(surface, self._unit_forces(surface))
                if kind is SurfaceForce
                else SurfacePressure(self.assembler, surface, self.facets(surface), self.degree)
            )

    def _unit_forces(self, surface: str) -> np.ndarray:
        """Forces (3, local) of 1 N/mm² on a surface or a sheet, or 1 N/mm along a curve."""
        if surface in self.sheets or surface in self.curves:
            nodes, shares = self.surface_points(surface)
            return shared_forces(self.nodes.dofs[nodes], shares, self.unknowns.local)
        return unit_forces(self.assembler, self.facets(surface), self.degree)

    def add_inertia(self) -> None:
        """Give the regions their inertia, for motions; it acts while it has a time step."""
        if not self.inertia:
            self.inertia = [
                Inertia(self.assembler, s.cells, s.material.density, self.degree)
                for s in self.solids.values()
            ] + [part.inertia(self.unknowns.local) for part in self.sheets.values()]

    def initial_state(self) -> State:
        """The unloaded state."""
        rigid = [contact.obstacle for contact in self.contacts if contact.rigid]
        return State(
            np.zeros(self.unknowns.local),
            shift={obstacle.name: np.zeros(3) for obstacle in rigid},
            presence={obstacle.name: float(obstacle.active) for obstacle in rigid},
        )

    # --- parallel vectors -------------------------------------------------------------------

    def to_local(self, vector: PETSc.Vec) -> np.ndarray:
        """Values of a PETSc vector with ghosts, as a new local array."""
        vector.copy(self._ghosted)
        self._ghosted.ghostUpdate(PETSc.InsertMode.INSERT, PETSc.ScatterMode.FORWARD)
        with self._ghosted.localForm() as local:
            return local.getArray(readonly=True).copy()

    def sum_shared(self, local: np.ndarray) -> np.ndarray:
        """Add up what all processes hold of each unknown; returns the sums, ghosts included."""
        with self._ghosted.localForm() as form:
            form.setArray(local)
        self._ghosted.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
        self._ghosted.ghostUpdate(PETSc.InsertMode.INSERT, PETSc.ScatterMode.FORWARD)
        with self._ghosted.localForm() as form:
            return form.getArray(readonly=True).copy()

    def sum(self, value):
        """Sum over processes of a number or an array."""
        return self.comm.allreduce(value)

    # --- residual and tangent ---------------------------------------------------------------

    def force(self, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Out-of-balance and internal force of the free body (local, ghosts included).

        Supports are ignored: at equilibrium the out-of-balance force is zero except where the
        body is held, and there it is the reaction (N). An inverted element gives NaN.
        """
        both = np.zeros((2, self.unknowns.local))
        for term in self.terms:
            internal = isinstance(term, Solid | Layer | LayerBending | Membrane)
            try:
                term.add_force(state, both[int(internal)])
            except InvertedElementError:
                # On this process alone, perhaps: the others wait for it in the terms that follow.
                both[:] = np.nan
        internal = self.sum_shared(both[1])
        return internal + self.sum_shared(both[0]), internal

    def smallest_jacobian(self, x: np.ndarray) -> float:
        """Smallest J at a quadrature point over all processes; −inf where it is not a number."""
        with np.errstate(all="ignore"):
            smallest = min(
                (
                    float(determinant(s.deformation_gradient(x)).min(initial=np.inf))
                    for s in self.solids.values()
                ),
                default=np.inf,
            )
        return self.comm.allreduce(smallest if smallest == smallest else -np.inf, op=MPI.MIN)

    def tangent(self, state: State, origin: Origin | None = None) -> PETSc.Mat:
        """Tangent with the rows and columns of supported unknowns replaced by the identity."""
        self.assembler.clear()
        for term in self.terms:
            term.add_tangent(state, origin)
        return self.assembler.finish_matrix()

    def energy(self, state: State, terms=None) -> float:
        """Potential energy of the given terms (all where None), mJ."""
        return self.sum(sum(t.energy(state) for t in (self.terms if terms is None else terms)))

    def strain_energy(self, state: State) -> float:
        """Elastic energy stored in the solids, layers and sheets of the meshed part, mJ."""
        sheets = [term for part in self.sheets.values() for term in part.elastic]
        return self.energy(state, [*self.solids.values(), *self.layers, *self.bending, *sheets])

    @property
    def diagonal(self) -> float:
        """Diagonal (mm) of the undeformed body's bounding box."""
        points = self.nodes.places
        low = self.comm.allreduce(points.min(axis=0), op=_smaller)
        high = -self.comm.allreduce(-points.max(axis=0), op=_smaller)
        return float(np.linalg.norm(high - low))

    def cavity_volume(self, state: State, name: str) -> float:
        """Volume of a cavity of the meshed part, mm³."""
        return self.sum(self.cavities[name].volume(state.x))

    def _pressure_weights(self) -> np.ndarray:
        """Volume that belongs to each pressure unknown (local, zero at displacements), mm³."""
        out = np.zeros(self.unknowns.local)
        for solid in self.solids.values():
            if solid.pressure_values is None:
                continue
            dofs = self.unknowns.cell_dofs[solid.cells, 3 * self.cell_nodes.shape[1] :]
            np.add.at(out, dofs, solid.volumes @ np.abs(solid.pressure_values))
        return self.sum_shared(out)

    def _force_floor(self) -> float:
        """Force (N) below which nothing is out of balance: a strain of 1e-12 over the body."""
        volume = self.sum(sum(float(s.volumes.sum()) for s in self.solids.values()))
        stiffest = max((s.material.shear_modulus for s in self.solids.values()), default=0.0)
        sheets = [p.sheet.stiffness * p.triangles.areas.sum() ** 0.5 for p in self.sheets.values()]
        return 1e-12 * max([stiffest * volume ** (2 / 3), *sheets])

    # --- supports ---------------------------------------------------------------------------

    def facet_nodes(self, facets: np.ndarray) -> np.ndarray:
        """Displacement nodes (k, n) of each facet in VTK's order, turned so that the normal
        points out of the facet's cell."""
        tables = facet_tables(compat.reference_nodes(self.degree))
        nodes = self.cell_nodes[facets[:, :1], tables[facets[:, 1]]]
        x = self.nodes.places
        a, b, c = (x[nodes[:, i]] for i in range(3))
        inside = x[self.cell_nodes[facets[:, 0], facets[:, 1]]]  # the vertex opposite the facet
        inward = np.einsum("ki,ki->k", np.cross(b - a, c - a), inside - a) > 0
        swap = [0, 2, 1, 5, 4, 3] if nodes.shape[1] == 6 else [0, 2, 1]
        nodes[inward] = nodes[inward][:, swap]
        return nodes

    def area(self, surface: str) -> float:
        """Undeformed area of a surface of the meshed part, mm²; length of a curve, mm."""
        return self.sum(float(self.surface_points(surface)[1].sum()))

    def surface_points(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Nodes (k,) of this process's facets, sheets or edges of that name, and their shares of
        its area (mm²) or length (mm); a node counts once for each element."""
        if name in self.curves:
            nodes = self.curves[name]
            ends = self.nodes.places[nodes[:, 1]] - self.nodes.places[nodes[:, 0]]
            rule = SIMPSON if nodes.shape[1] == 3 else TRAPEZIUM
            return nodes.ravel(), (np.linalg.norm(ends, axis=1)[:, None] * rule).ravel()
        if name in self.sheets:
            nodes = self.sheets[name].triangles.nodes
        else:
            nodes = self.facet_nodes(self.mesh.facets[name])
        a, b, c = np.moveaxis(self.nodes.places[nodes[:, :3]], 1, 0)
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        # The middles of the edges integrate a quadratic exactly; linear facets have corners only.
        return nodes[:, -3:].ravel(), np.repeat(area / 3, 3)

    def surface_nodes(self, surface: str) -> np.ndarray:
        """Displacement nodes on a surface or curve that this process holds, also where the facet
        itself belongs to another process."""
        if surface in self.curves:
            return np.unique(self.curves[surface])
        if surface in self.sheets:
            return np.unique(self.sheets[surface].triangles.nodes)
        mark = np.zeros(self.unknowns.local)
        mark[self.displacement_dofs[self.facet_nodes(self.mesh.facets[surface]), 0]] = 1.0
        return np.flatnonzero(self.sum_shared(mark)[self.displacement_dofs[:, 0]])

    def set_supports(self, supports: Sequence[Support], state: State):
        """Fix the given components and those normal to symmetry planes.

        Returns (dofs, values): local unknowns and their prescribed displacements, mm.
        Raises SpecError where two supports contradict.
        """
        values = np.full(self.unknowns.local, np.nan)
        planes = [Support(name, {c: 0.0}) for name, c in self.mesh.layout.symmetry.items()]
        for support in (*planes, *supports):
            nodes = self.surface_nodes(support.surface)
            for component, prescribed in support.values.items():
                dofs = self.displacement_dofs[nodes, component]
                value = state.x[dofs] if prescribed is None else prescribed
                clash = self.sum(int(np.sum(np.abs(values[dofs] - value) > 1e-9)))
                if clash:
                    raise SpecError(
                        f"supports: '{support.surface}' prescribes {'xyz'[component]} on "
                        f"{clash} points where another support prescribes a different value"
                    )
                values[dofs] = value
        dofs = np.flatnonzero(~np.isnan(values))
        self.assembler.fixed[:] = 0
        self.assembler.fixed[dofs] = 1
        return dofs, values[dofs]

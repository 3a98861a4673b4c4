"""A meshed actuator with materials, loads and supports: its residual and tangent."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from softact import compat
from softact.bodies.layer import BondedLayer, BondedLayers
from softact.bodies.membrane import Membrane
from softact.bodies.named_surfaces import Surfaces
from softact.bodies.plate import LayerBending
from softact.bodies.sheet import Sheet, SheetPart, make_parts, node_numbers
from softact.bodies.sheet_bending import add_bending
from softact.bodies.solid import Solid
from softact.contact.contacts import Contacts
from softact.contact.facets import ContactFacets
from softact.contact.rigid import Obstacle, RigidContact
from softact.contact.surfaces import SurfaceContact, Touching
from softact.errors import SpecError
from softact.loads.sheet_cavity import SheetCavity
from softact.materials.fibres import fibre_field
from softact.materials.tensors import determinant
from softact.mesh.sheets import nodes_of as sheet_nodes_of
from softact.mesh.tetrahedra import Mesh
from softact.system.assembly import Assembler
from softact.system.nodes import nodes_of
from softact.system.term import (
    CavityPressure,
    Inertia,
    InvertedElementError,
    Layer,
    Origin,
    State,
    SurfaceForce,
    SurfacePressure,
    Weight,
    unit_forces,
)
from softact.system.unknowns import Unknowns

UP = (0.0, 0.0, 1.0)
# name in the spec -> displacement degree, pressure degree (None: no pressure unknown)
ELEMENTS: dict[str, tuple[int, int | None]] = {
    "P2/P1": (2, 1),
    "P2/P0": (2, 0),
    "P2": (2, None),
    "P1": (1, None),
}


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

    mesh: see ``softact.mesh.tetrahedra``. materials: region name -> law. layers: thin layers.
    element: one of ``ELEMENTS``. wall_normal: region name, points (n, 3) -> the wall's normal
    there, for fibres; default: up. obstacles: rigid bodies. touching: surfaces that may touch, for
    one process only. sheets: name -> what each sheet of the mesh is made of, for one process only;
    a mesh may have sheets and no solid.
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
            name: self._cavity(name, walls) for name, walls in mesh.layout.cavities.items()
        }
        self.layers = BondedLayers(self, layers)
        planes = tuple(mesh.layout.symmetry.values())
        continuous = mesh.sheets.continuous if mesh.sheets else ()
        add_bending(self.sheets, continuous, self.assembler, self.nodes, planes)
        self.weights = [
            Weight(s.material.density * unit_forces(self.assembler, s.cells, self.degree))
            for s in self.solids.values()
        ]
        self.weights += self.layers.weights()
        self.weights += [part.weight(self.unknowns.local) for part in self.sheets.values()]
        self.supports: tuple[Support, ...] = ()
        self.inertia: list[Inertia] = []
        self.surface_loads: dict[tuple[type, str], SurfaceForce | SurfacePressure] = {}
        self.contacts = Contacts(
            self.comm,
            [*map(self._against, obstacles), *(SurfaceContact(t, self) for t in touching)],
        )
        self.assembler.symmetric = self.contacts.symmetric
        self.pressure_weights = self._pressure_weights()
        self.force_floor = self._force_floor()
        self.cavity_volumes_at_rest = self._volumes_at_rest()

    def _volumes_at_rest(self) -> dict[str, float]:
        """Volume of each cavity of the meshed part, mm³; sheets may lie flat.

        Raises SpecError where walls of solids enclose none.
        """
        rest = self.initial_state()
        volumes = {name: self.cavity_volume(rest, name) for name in self.cavities}
        for name, walls in self.mesh.layout.cavities.items():
            if volumes[name] <= 0.0 and not set(walls) & set(self.sheets):
                raise SpecError(
                    f"cavities.{name}: its walls ({', '.join(walls)}) enclose a volume of "
                    f"{volumes[name]:.4g} mm³; name the surfaces around the air, not the outside"
                )
        return volumes

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
        curves: dict[str, np.ndarray] = {}
        if mesh.sheets:
            self.sheets = make_parts(mesh.sheets, number[sheet_nodes.elements], sheets, self.nodes)
            curves = {name: number[edges] for name, edges in sheet_nodes.curves.items()}
            tables = [part.triangles.table for part in self.sheets.values()]
        self.assembler = Assembler(mesh, self.unknowns, tables)
        self.displacement_dofs = self.nodes.dofs
        self.cell_nodes = compat.cell_dofs(spaces[0]) if spaces else np.empty((0, 0), np.int32)
        self.surfaces = Surfaces(
            mesh, self.unknowns, self.nodes, self.cell_nodes, self.degree, self.sheets, curves
        )

    def _cavity(self, name: str, walls: Sequence[str]) -> CavityPressure | SheetCavity:
        if set(walls) & set(self.sheets):
            triangles = [self.sheets[wall].triangles for wall in walls]
            return SheetCavity(name, triangles, self.mesh.layout.flux)
        return CavityPressure(self.assembler, name, self.surfaces.facets(*walls), self.degree)

    def _against(self, obstacle: Obstacle) -> RigidContact:
        return RigidContact(obstacle, ContactFacets(self, obstacle.surfaces or self.outside))

    @property
    def outside(self) -> tuple[str, ...]:
        """Surfaces and sheets that may touch something; a solid's facets stand for what is bonded
        to them."""
        bonded = self.mesh.sheets.bonded if self.mesh.sheets else ()
        return (*self.mesh.layout.outside, *(name for name in self.sheets if name not in bonded))

    def kinks_between(self, state: State, here: np.ndarray, there: np.ndarray) -> bool:
        """Whether forces have kinks on the way between two arrays of unknowns (local,) at the loads
        of ``state``: where bodies touch at one end of it, and where bonded layers slacken."""
        return self.layers.slacken or any(
            self.contacts.touch(replace(state, x=x)) for x in (here, there)
        )

    @property
    def smooth(self) -> bool:
        """Whether no force has a kink anywhere."""
        return not (len(self.contacts) or self.sheets or self.layers.slacken)

    @property
    def terms(self):
        """All parts of the potential energy."""
        return [
            *self.solids.values(),
            *self.cavities.values(),
            *self.layers.elastic,
            *(term for part in self.sheets.values() for term in part.elastic),
            *self.weights,
            *self.surface_loads.values(),
            *(inertia for inertia in self.inertia if inertia.time_step is not None),
            *self.contacts,
        ]

    def add_surface_load(self, kind: type[SurfaceForce | SurfacePressure], surface: str) -> None:
        """Make room for a load on a surface; its value is part of the state."""
        if self.surfaces.is_sheet(surface):
            if kind is not SurfaceForce:
                raise SpecError(f"surface_pressure: '{surface}' is a sheet; only cavities press it")
        if (kind, surface) not in self.surface_loads:
            self.surface_loads[kind, surface] = (
                SurfaceForce(surface, self.unit_forces(surface))
                if kind is SurfaceForce
                else SurfacePressure(
                    self.assembler, surface, self.surfaces.facets(surface), self.degree
                )
            )

    def unit_forces(self, surface: str) -> np.ndarray:
        """Forces (3, local) of 1 N/mm² on a surface or a sheet, or 1 N/mm along a curve."""
        return self.surfaces.unit_forces(self.assembler, surface)

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
        internal = self.unknowns.sum_shared(both[1])
        return internal + self.unknowns.sum_shared(both[0]), internal

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
        return self.energy(state, [*self.solids.values(), *self.layers.elastic, *sheets])

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
        return self.unknowns.sum_shared(out)

    def _force_floor(self) -> float:
        """Force (N) below which nothing is out of balance: a strain of 1e-12 over the body."""
        volume = self.sum(sum(float(s.volumes.sum()) for s in self.solids.values()))
        stiffest = max((s.material.shear_modulus for s in self.solids.values()), default=0.0)
        sheets = [p.sheet.stiffness * p.triangles.areas.sum() ** 0.5 for p in self.sheets.values()]
        return 1e-12 * max([stiffest * volume ** (2 / 3), *sheets])

    def set_supports(self, supports: Sequence[Support], state: State):
        """Fix the given components and those normal to symmetry planes.

        Returns (dofs, values): local unknowns and their prescribed displacements, mm.
        Raises SpecError where two supports contradict.
        """
        values = np.full(self.unknowns.local, np.nan)
        symmetry = self.mesh.layout.symmetry
        planes = [Support(name, {c: 0.0}) for name, c in symmetry.items()]
        for support in (*planes, *supports):
            nodes = self.surfaces.nodes(support.surface)
            if support.surface in symmetry:
                nodes = np.concatenate([nodes, self.surfaces.covering(nodes)])
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
        self.supports = tuple(supports)
        dofs = np.flatnonzero(~np.isnan(values))
        self.assembler.fixed[:] = 0
        self.assembler.fixed[dofs] = 1
        return dofs, values[dofs]

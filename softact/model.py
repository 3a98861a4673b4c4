"""A meshed actuator with materials, loads and supports: its residual and tangent."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from softact import compat
from softact.bodies import BODIES
from softact.bodies.base import Body
from softact.bodies.carried_mass import MassOnSurface
from softact.bodies.inertia import Carried, Inertia, RigidInertia
from softact.bodies.layer import BondedLayer, Layer
from softact.bodies.memory import without_rates
from softact.bodies.named_surfaces import Surfaces, turned_round
from softact.bodies.parts import Parts
from softact.bodies.regions import SolidParts
from softact.bodies.remembering import Remembering, RememberingMembrane, RememberingSolid
from softact.bodies.repeat import THREES, Repeat
from softact.bodies.sheet import Sheet, SheetPart, make_parts, node_numbers
from softact.bodies.solid import Solid
from softact.bodies.spring import SpringSupport
from softact.bodies.weight import Weight
from softact.contact.contacts import Contacts
from softact.contact.facets import ContactFacets
from softact.contact.free_body import FreeBody
from softact.contact.rigid import Obstacle, RigidContact
from softact.contact.surfaces import SurfaceContact, Touching
from softact.errors import SpecError
from softact.loads import BY_FIELD, LOADS
from softact.loads.cavity_pressure import CavityPressure
from softact.loads.repeated_cavity import RepeatedCavity
from softact.loads.sheet_cavity import SheetCavity
from softact.loads.support import Held, Support, Turn, Turned
from softact.materials.base import Material
from softact.mesh.sheets import SheetMesh
from softact.mesh.sheets import nodes_of as sheet_nodes_of
from softact.mesh.tetrahedra import Mesh
from softact.system.assembly import Assembler, BlockTable
from softact.system.nodes import Nodes, nodes_of, solid_places
from softact.system.term import InvertedElementError, Origin, State, Term, Value
from softact.system.unknowns import Unknowns

if TYPE_CHECKING:
    import dolfinx

# name in the spec -> displacement degree, pressure degree (None: no pressure unknown)
ELEMENTS: dict[str, tuple[int, int | None]] = {
    "P2/P1": (2, 1),
    "P2/P0": (2, 0),
    "P2": (2, None),
    "P1": (1, None),
}


NOTHING = 1e-12  # strain


def _upwards(region: str, points: np.ndarray) -> np.ndarray:
    return np.array([0.0, 0.0, 1.0])


def _smaller(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.minimum(one, other)


class Model:
    """Everything that decides the equilibrium of an actuator.

    mesh: see ``softact.mesh.tetrahedra``. materials: region name -> law. layers: thin layers.
    element: one of ``ELEMENTS``. wall_normal: region name, points (n, 3) -> the wall's normal
    there, for fibres; default: up. obstacles: rigid bodies. touching: surfaces that may touch.
    sheets: name -> what each sheet of the mesh is made of, for one process only; a mesh may have
    sheets and no solid. more: bodies of further kinds, see ``softact.bodies``.
    like: a model of the same cells and triangles, whose numbering this one shares; the tangent is
    that one's alone.
    The residual is the derivative of the potential energy with respect to the unknowns.
    """

    def __init__(
        self,
        mesh: Mesh,
        materials: Mapping[str, Material],
        layers: Sequence[BondedLayer] = (),
        element: str = "P2/P1",
        wall_normal: Callable[[str, np.ndarray], np.ndarray] = _upwards,
        obstacles: Sequence[Obstacle] = (),
        touching: Sequence[Touching] = (),
        sheets: Mapping[str, Sheet] | None = None,
        more: Mapping[str, Any] | None = None,
        like: Model | None = None,
    ):
        self.mesh, self.comm = mesh, mesh.comm
        self.degree, pressure_degree = ELEMENTS[element]
        free = [obstacle for obstacle in obstacles if obstacle.mass]
        self._number(pressure_degree, sheets or {}, like, len(free))
        parts = {
            "materials": SolidParts(materials, wall_normal, pressure_degree),
            "layers": layers,
            "sheets": sheets or {},
            **(more or {}),
        }
        self.bodies: list[Body] = [
            body for key, part in parts.items() for body in BODIES[key].build(self, part)
        ]
        self.solids = {body.name: body for body in self.bodies if isinstance(body, Solid)}
        self.layers = [body for body in self.bodies if isinstance(body, Layer)]
        self.masses = [body for body in self.bodies if isinstance(body, MassOnSurface)]
        self.springs = [body for body in self.bodies if isinstance(body, SpringSupport)]
        repeats = mesh.layout.repeats
        self.repeat = Repeat(self, repeats) if repeats else None
        self.cavities = {
            name: self._cavity(name, walls) for name, walls in mesh.layout.cavities.items()
        }
        weights = [body.weight() for body in self.bodies]
        self.weights: list[Weight] = [weight for weight in weights if weight is not None]
        self.supports: tuple[Support, ...] = ()
        self.turned: list[Turned] = []
        self.parts = Parts(self)
        self.inertia: list[Inertia] = []
        self.carried = Carried()
        self.load_terms: dict[tuple[str, str], Term] = {}
        placed = [obstacle for obstacle in obstacles if not obstacle.mass]
        self.free_bodies = {
            obstacle.name: FreeBody(self, obstacle, placed, self.apart, number)
            for number, obstacle in enumerate(free)
        }
        self.contacts = Contacts(
            self.comm,
            [*map(self._against, obstacles), *(SurfaceContact(t, self) for t in touching)],
            self.free_bodies.values(),
        )
        self.assembler.symmetric = self.contacts.symmetric
        self.pressure_weights = self._pressure_weights()
        # Force (N) below which nothing is out of balance.
        self.force_floor = NOTHING * max(body.stiffness for body in self.bodies)
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

    def _number(
        self,
        pressure_degree: int | None,
        sheets: Mapping[str, Sheet],
        like: Model | None,
        free: int,
    ) -> None:
        """Nodes and unknowns of the solids, then of the sheets, and those of free bodies."""
        mesh = self.mesh
        spaces: list[dolfinx.fem.FunctionSpace] = list(like.unknowns.spaces) if like else []
        if mesh.domain is not None and like is None:
            spaces.append(compat.function_space(mesh.domain, self.degree, 3))
            if pressure_degree is not None:
                constant = pressure_degree == 0
                spaces.append(compat.function_space(mesh.domain, pressure_degree, 1, constant))
        loose, elements = np.empty((0, 3)), np.empty((0, 0), np.int64)
        curves: dict[str, np.ndarray] = {}
        middles = mesh.middles if self.degree == 2 else None
        if spaces and mesh.moved is not None:
            places = self._moved_places(spaces[0], middles)
        else:
            places = solid_places(spaces, middles)
        if mesh.sheets:
            loose, elements, curves = self._sheet_nodes(mesh.sheets, places)
        apart = THREES if mesh.layout.repeats else 2 * free
        if mesh.layout.repeats and self.comm.size > 1:
            raise SpecError("module: runs in one process only; leave -n out")
        self.unknowns: Unknowns = (
            like.unknowns if like else Unknowns(self.comm, spaces, len(loose), apart, free > 0)
        )
        self.nodes: Nodes = nodes_of(self.unknowns, places, loose)
        self.sheets: dict[str, SheetPart] = {}
        if mesh.sheets:
            size = self.unknowns.local
            self.sheets = make_parts(mesh.sheets, elements, sheets, self.nodes, size)
        tables = [part.triangles.table for part in self.sheets.values()]
        together = THREES if mesh.layout.repeats else 2
        self.apart: BlockTable = BlockTable(self.unknowns.apart_blocks.reshape(-1, together))
        tables += [self.apart] if apart else []
        shared = like.assembler if like else None
        self.assembler: Assembler = Assembler(
            mesh, self.unknowns, tables, shared, None if middles is None else places
        )
        self.displacement_dofs: np.ndarray = self.nodes.dofs
        self.cell_nodes = compat.cell_dofs(spaces[0]) if spaces else np.empty((0, 0), np.int32)
        self.surfaces: Surfaces = Surfaces(
            mesh, self.unknowns, self.nodes, self.cell_nodes, self.degree, self.sheets, curves
        )

    def _moved_places(
        self, space: dolfinx.fem.FunctionSpace, middles: np.ndarray | None
    ) -> np.ndarray:
        """Places (n, 3) of a space's nodes where the points of the mesh have been moved, mm.

        middles: (cells, 6, 3) of its edges; None where all are straight.
        """
        corners = self.mesh.points[compat.geometry_dofs(self.mesh.domain)]
        if middles is None:
            reference = compat.reference_nodes(self.degree)
            nodes = np.column_stack([1 - reference.sum(axis=1), reference]) @ corners
        else:
            nodes = np.concatenate([corners, middles], axis=1)
        places = np.array(space.tabulate_dof_coordinates())
        places[compat.cell_dofs(space)] = nodes
        return places

    def _sheet_nodes(
        self, sheets: SheetMesh, solid: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
        """Places (n, 3) of the sheets' loose nodes, and the model's nodes of their elements and
        curves. solid: (m, 3) places of the solids' nodes."""
        layout = self.mesh.layout
        ends = layout.repeats
        open_at = (ends.left, ends.right) if ends else ()
        sheets.check(layout.cavities, list(layout.symmetry.values()), layout.flux, open_at)
        nodes = sheet_nodes_of(sheets, self.degree)
        number, loose = node_numbers(sheets, nodes, solid)
        curves = {name: number[edges] for name, edges in nodes.curves.items()}
        return loose, number[nodes.elements], curves

    def _cavity(
        self, name: str, walls: Sequence[str]
    ) -> CavityPressure | SheetCavity | RepeatedCavity:
        if set(walls) & set(self.sheets):
            triangles = [self.sheets[wall].triangles for wall in walls]
            sheets = SheetCavity(name, triangles, self.mesh.layout.flux)
            if not self.repeat:
                return sheets
            # Normals of sheets point out of the air, those of solids into it.
            nodes = np.concatenate([turned_round(part.nodes) for part in triangles])
            return RepeatedCavity(self, self.repeat, sheets, nodes)
        facets = self.surfaces.facets(*walls)
        closed = CavityPressure(self.assembler, name, facets, self.degree)
        if not self.repeat:
            return closed
        return RepeatedCavity(self, self.repeat, closed, self.surfaces.facet_nodes(facets))

    def _against(self, obstacle: Obstacle) -> RigidContact:
        facets = ContactFacets(self, obstacle.surfaces or self.outside)
        return RigidContact(obstacle, facets, self, self.free_bodies.get(obstacle.name))

    @property
    def outside(self) -> tuple[str, ...]:
        """Surfaces and sheets that may touch something; a solid's facets stand for what is bonded
        to them."""
        bonded = self.mesh.sheets.bonded if self.mesh.sheets else ()
        return (*self.mesh.layout.outside, *(name for name in self.sheets if name not in bonded))

    def kinks_between(self, state: State, here: np.ndarray, there: np.ndarray) -> bool:
        """Whether forces have kinks on the way between two arrays of unknowns (local,) at the loads
        of ``state``: where bodies touch at one end of it, and where bonded layers slacken."""
        slackens = any(body.slackens for body in self.bodies)
        return slackens or any(self.contacts.touch(replace(state, x=x)) for x in (here, there))

    @property
    def smooth(self) -> bool:
        """Whether no force has a kink anywhere, but where bodies touch."""
        return all(body.smooth for body in self.bodies)

    @property
    def is_solid(self) -> bool:
        """Whether it is of solids, and no sheet is there that swings."""
        return bool(self.solids) and self.mesh.sheets is None

    @property
    def elastic(self) -> list[Term]:
        """Terms of the stored energy."""
        return [term for body in self.bodies for term in body.elastic]

    @property
    def external(self) -> list[Term]:
        """All other parts of the potential energy."""
        return [
            *self.cavities.values(),
            *self.weights,
            *self.load_terms.values(),
            *(term for body in self.bodies for term in body.external),
            *self.inertia,
            self.carried,
            *self.free_bodies.values(),
            *self.contacts,
        ]

    @property
    def terms(self) -> list[Term]:
        """All parts of the potential energy."""
        return [*self.elastic, *self.external]

    def make_room(self, loads: Mapping[str, Mapping[str, Value]]) -> None:
        """Make the terms of loads, by field, that are not there yet; values are part of states."""
        for field, named in loads.items():
            for name in named:
                if (field, name) in self.load_terms:
                    continue
                term = BY_FIELD[field].term(self, name)
                if term is not None:
                    self.load_terms[field, name] = term

    def unit_forces(self, surface: str) -> np.ndarray:
        """Forces (3, local) of 1 N/mm² on a surface or a sheet, or 1 N/mm along a curve."""
        return self.surfaces.unit_forces(self.assembler, surface)

    def add_inertia(self) -> None:
        """Give the bodies their inertia, which acts while a time step is part of the state."""
        if not self.inertia:
            found = [body.inertia() for body in self.bodies]
            self.inertia = [inertia for inertia in found if inertia is not None]
            self.inertia += [
                RigidInertia(free.dofs, free.mass_matrix, free.add_to_matrix, free.mine)
                for free in self.free_bodies.values()
            ]

    @property
    def moving_dofs(self) -> np.ndarray:
        """Unknowns (n,) that are displacements of nodes, or of free bodies."""
        free = [body.dofs for body in self.free_bodies.values()]
        return np.concatenate([self.displacement_dofs.ravel(), *free])

    def momentum(self, velocity: np.ndarray) -> np.ndarray:
        """Mass matrix times a velocity (local,), this process's share; bodies have inertia."""
        return sum((i.momentum(velocity) for i in self.inertia), np.zeros_like(velocity))

    def initial_state(self) -> State:
        """The unloaded state."""
        loads: dict[str, dict[str, Value]] = {}
        for load in LOADS.values():
            if not load.holds_volume:
                loads |= load.initial(self)
        return State(np.zeros(self.unknowns.local), loads)

    def sum(self, value: Any) -> Any:
        """Sum over processes of a number or an array."""
        return self.comm.allreduce(value)

    def remember(self, state: State) -> None:
        """Take ``state`` as the last equilibrium: from it friction and materials count on."""
        self.contacts.remember(state)
        for body in self.remembering:
            state.memory = {**state.memory, **body.remember(state)}

    def recall(self, state: State, memory: Mapping[str, np.ndarray | float]) -> None:
        """Let the materials of ``state`` remember what they did in an earlier memory."""
        mine = tuple(body.name_of("") for body in self.remembering)
        if mine:
            others = {k: v for k, v in state.memory.items() if not k.startswith(mine)}
            state.memory = others | {k: v for k, v in memory.items() if k.startswith(mine)}

    def forget_rates(self, state: State) -> None:
        """Let no rate of a stress be taken over from before ``state``: loads turn there."""
        if self.remembering:
            without_rates(state)

    def time_error(self, state: State) -> float:
        """Largest error of the internal stresses of a time step, by the largest stress so far; 0
        where nothing creeps. Collective."""
        return max((body.time_error(state) for body in self.remembering), default=0.0)

    @property
    def remembering(self) -> list[Remembering]:
        """Parts of bodies whose materials have a memory."""
        terms = [term for body in self.bodies for term in body.elastic]
        return [t for t in terms if isinstance(t, RememberingSolid | RememberingMembrane)]

    # --- residual and tangent ---------------------------------------------------------------

    def force(self, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Out-of-balance and internal force of the free body (local, ghosts included).

        Supports are ignored: at equilibrium the out-of-balance force is zero except where the
        body is held, and there it is the reaction (N). An inverted element gives NaN.
        """
        force, internal = self.sum_of_forces(state, self.elastic)
        return (self.repeat.force(state, force) if self.repeat else force), internal

    def sum_of_forces(self, state: State, elastic: Sequence[Term]) -> tuple[np.ndarray, np.ndarray]:
        """Forces (local,) of these elastic terms and of all others, and of the elastic alone."""
        both = np.zeros((2, self.unknowns.local))
        for terms, out in zip((elastic, self.external), both, strict=True):
            for term in terms:
                try:
                    term.add_force(state, out)
                except InvertedElementError:
                    # On this process alone, perhaps: the others wait for it in what follows.
                    both[:] = np.nan
        internal = self.unknowns.sum_shared(both[0])
        return internal + self.unknowns.sum_shared(both[1]), internal

    def follow(self, x: np.ndarray) -> np.ndarray:
        """Put what follows other unknowns where they take it, in ``x`` (local,), in place."""
        return self.repeat.follow(x) if self.repeat else x

    def smallest_jacobian(self, x: np.ndarray) -> float:
        """Smallest J at a quadrature point over all processes; −inf where it is not a number."""
        with np.errstate(all="ignore"):
            smallest = min(
                (float(s.jacobian(x).min(initial=np.inf)) for s in self.solids.values()),
                default=np.inf,
            )
        return self.comm.allreduce(smallest if smallest == smallest else -np.inf, op=MPI.MIN)

    def tangent(self, state: State, origin: Origin | None = None) -> PETSc.Mat:
        """Tangent with the rows and columns of supported unknowns replaced by the identity."""
        self.assembler.clear()
        for term in self.terms:
            term.add_tangent(state, origin)
        if self.repeat:
            self.repeat.fold_tangent(state)
        return self.assembler.finish_matrix()

    def energy(self, state: State, terms: Sequence[Term] | None = None) -> float:
        """Potential energy of the given terms (all where None), mJ."""
        chosen = self.terms if terms is None else terms
        return self.sum(sum(term.energy(state) for term in chosen))

    def strain_energy(self, state: State) -> float:
        """Elastic energy stored in the bodies of the meshed part, mJ."""
        return self.energy(state, self.elastic)

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

    def set_supports(self, supports: Sequence[Support], state: State) -> Held:
        """Fix the given components and those normal to symmetry planes.

        Returns the displacements from those of ``state`` to the prescribed ones. Raises SpecError
        where two supports contradict.
        """
        values = np.full(self.unknowns.local, np.nan)
        symmetry = self.mesh.layout.symmetry
        planes = [Support(name, {c: 0.0}) for name, c in symmetry.items()]
        before, self.turned = self.turned, []
        for support in (*planes, *supports):
            nodes = self.surfaces.nodes(support.surface)
            if support.surface in symmetry:
                nodes = np.concatenate([nodes, self.surfaces.covering(nodes)])
            if support.turn is not None:
                self.turned.append(
                    self._turned(support.surface, support.turn, nodes, state, before)
                )
            for component in support.components:
                dofs = self.displacement_dofs[nodes, component]
                value = self._prescribed(support, component, state.x[dofs])
                clash = self.sum(int(np.sum(np.abs(values[dofs] - value) > 1e-9)))
                if clash:
                    raise SpecError(
                        f"supports: '{support.surface}' prescribes {'xyz'[component]} on "
                        f"{clash} points where another support prescribes a different value"
                    )
                values[dofs] = value
        still = [self.repeat.held()] if self.repeat else []
        still += [body.still for body in self.free_bodies.values()]
        for dof, value in (item for each in still for item in each.items()):
            values[dof] = value
        self.supports = tuple(supports)
        dofs = np.flatnonzero(~np.isnan(values))
        self.assembler.fixed[:] = 0
        self.assembler.fixed[dofs] = 1
        return Held(dofs, state.x[dofs], values[dofs], tuple(self.turned))

    def _prescribed(self, support: Support, component: int, now: np.ndarray) -> np.ndarray | float:
        if support.turn is not None:
            return self.turned[-1].displacements(0.0, 1.0)[:, component]
        value = support.values[component]
        return now if value is None else value

    def _turned(
        self,
        surface: str,
        turn: Turn,
        nodes: np.ndarray,
        state: State,
        before: Sequence[Turned],
    ) -> Turned:
        """The rotation of a surface from where the surface is: at the angle to which it was turned
        before, or else at its mean one, less than half a turn."""
        places = self.nodes.places
        axis = np.asarray(turn.axis) / np.linalg.norm(turn.axis)
        points, weights = self.surfaces.points(surface)
        sums = self.sum(np.append(weights @ places[points], weights.sum()))
        centre = sums[:3] / sums[3] if turn.about is None else np.asarray(turn.about)
        known = [t for t in before if t.surface == surface and axis @ t.axis > 1 - 1e-9]
        if known:
            start = known[0].end
        else:
            arms = places[points] - centre
            arms = arms - np.outer(arms @ axis, axis)
            moved = arms + state.x[self.displacement_dofs[points]]
            sine = self.sum(float(weights @ np.cross(arms, moved) @ axis))
            cosine = self.sum(float(weights @ np.sum(arms * moved, axis=1)))
            start = float(np.degrees(np.arctan2(sine, cosine)))
        dofs = self.displacement_dofs[nodes]
        return Turned(surface, dofs, places[nodes], centre, axis, start, turn.angle)

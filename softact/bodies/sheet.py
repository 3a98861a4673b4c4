"""Sheets of a model: what they are made of, and their terms of the potential energy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from mpi4py import MPI
from scipy.spatial import cKDTree

from softact.bodies.compiled_sheet_law import compiled, relaxed
from softact.bodies.inertia import SheetInertia
from softact.bodies.membrane import Membrane
from softact.bodies.plate import LayerBending
from softact.bodies.remembering import RememberingMembrane
from softact.bodies.weight import Weight
from softact.errors import MeshError, SpecError
from softact.materials.base import FibreLaw, Law
from softact.materials.plane_stress import SheetLaw, sheet_law, small_strain_constants
from softact.mesh.sheets import SheetMesh, SheetNodes
from softact.mesh.triangles import MEMBRANE_RULE, Triangles
from softact.system.assembly import BlockTable
from softact.system.nodes import Nodes
from softact.system.term import Term, shared_forces

COINCIDENT = 1e-6  # of the sheet's size


@dataclass(frozen=True)
class Ply:
    """One layer of a sheet: law of the library, thickness (mm), the angle (degrees) by which its
    own axis is turned from the sheet's about the normal, and whether its volume is constant (then
    the law's bulk modulus does not count)."""

    law: Law
    thickness: float
    angle: float = 0.0
    incompressible: bool = False


@dataclass(frozen=True)
class Sheet:
    """What a sheet is made of.

    plies: bonded to each other; they share the strain and their energies add up. tension_field:
    whether compression is relaxed by fine wrinkles, see ``tension_field``. bending: part of the
    bending stiffness Σ E t³/12(1 − ν²) of its plies, each by itself, that it has. axis: (3,)
    direction in the undeformed state from which angles count, put into the sheet.
    """

    plies: Sequence[Ply]
    tension_field: bool = False
    bending: float = 1.0
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not self.plies or min(ply.thickness for ply in self.plies) <= 0:
            raise SpecError("a sheet needs plies of a thickness above 0 mm")

    @property
    def density(self) -> float:
        """Mass per area, tonne/mm²."""
        return sum(ply.law.density * ply.thickness for ply in self.plies)

    @property
    def stiffness(self) -> float:
        """Young's modulus times thickness, all plies, N/mm."""
        return sum(small_strain_constants(p.law)[0] * p.thickness for p in self.plies)

    def rigidity(self) -> tuple[float, float]:
        """Bending stiffness D (N·mm) and its Poisson's ratio."""
        each = []
        for ply in self.plies:
            young, poisson = small_strain_constants(ply.law)
            each.append((young * ply.thickness**3 / (12 * (1 - poisson**2)), poisson))
        total = sum(d for d, _ in each)
        return self.bending * total, sum(d * nu for d, nu in each) / total


class SheetPart:
    """One named sheet in a model: its triangles and terms.

    patches: (k,) number of the piece between hinges of each triangle. size: number of unknowns of
    the model. comm: of the model. bend: terms of the bending
    energy, see ``bend``.
    """

    def __init__(
        self,
        name: str,
        sheet: Sheet,
        triangles: Triangles,
        patches: np.ndarray,
        size: int,
        comm: MPI.Comm,
    ):
        self.name, self.sheet, self.triangles = name, sheet, triangles
        self.materials = [ply.law.material() for ply in sheet.plies]
        self.patches, self._size = patches, size
        along = np.asarray(sheet.axis, dtype=float)
        directed = any(isinstance(ply.law, FibreLaw) for ply in sheet.plies)
        across = np.abs(triangles.normals @ along) > (1 - 1e-6) * np.linalg.norm(along)
        if directed and across.any():
            raise SpecError(
                f"sheet '{name}': its axis {list(sheet.axis)} is normal to it; fibres lie in it"
            )
        self.membrane = self._membrane(along, comm)
        self.bend: list[LayerBending] = []

    def _membrane(self, along: np.ndarray, comm: MPI.Comm) -> Membrane:
        plies, triangles = self.sheet.plies, self.triangles
        if not any(ply.law.remembers for ply in plies):
            return Membrane(triangles, along, [(self._law(p), p.thickness) for p in plies])
        known = [(ply.law, self._law(ply), ply.thickness) for ply in plies]
        return RememberingMembrane(f"sheet {self.name}", triangles, along, known, comm)

    def _law(self, ply: Ply) -> SheetLaw:
        """The law of a ply in its plane."""
        law = sheet_law(ply.law, self._fibres(ply), ply.incompressible)
        if self.sheet.tension_field:
            return relaxed(law, small_strain_constants(ply.law)[1])
        return law if ply.law.remembers else compiled(law)

    def _fibres(self, ply: Ply) -> np.ndarray | None:
        """Fibre directions (k q, families, 3) in the frames of the triangles, or None."""
        if not isinstance(ply.law, FibreLaw):
            return None
        count = len(self.triangles.nodes) * len(MEMBRANE_RULE[1])
        turned = np.radians(ply.angle)
        axis = np.broadcast_to([np.cos(turned), np.sin(turned), 0.0], (count, 3))
        return ply.law.fibre_directions(axis, np.broadcast_to([0.0, 0.0, 1.0], (count, 3)))

    slackens = False  # as a whole; its folds are found point by point
    smooth = False
    external: Sequence[Term] = ()

    @property
    def elastic(self) -> Sequence[Term]:
        """See ``Body``."""
        return [self.membrane, *self.bend]

    @property
    def slowness(self) -> float:
        """See ``Body``: of waves in its plane."""
        return self.sheet.density / self.sheet.stiffness

    @property
    def stiffness(self) -> float:
        """See ``Body``."""
        return self.sheet.stiffness * float(self.triangles.areas.sum()) ** 0.5

    def weight(self) -> Weight:
        """See ``Body``."""
        shares = self.sheet.density * self.triangles.mass().sum(axis=2)
        return Weight(shared_forces(self.triangles.dofs, shares, self._size))

    def inertia(self) -> SheetInertia:
        """See ``Body``."""
        return SheetInertia(self.triangles, self.sheet.density)


def node_numbers(
    mesh: SheetMesh, sheet_nodes: SheetNodes, solid_places: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Model nodes (n,) of a mesh's nodes and the loose ones' places; bonded ones are the solid's.

    Raises MeshError where a bonded sheet has a node where the solid has none.
    """
    count = len(sheet_nodes.places)
    bonded = np.zeros(count, dtype=bool)
    for part in mesh.bonded:
        bonded[sheet_nodes.elements[mesh.parts[part]]] = True
    number = np.empty(count, dtype=np.int64)
    number[~bonded] = len(solid_places) + np.arange(int((~bonded).sum()))
    if bonded.any():
        if not len(solid_places):
            raise MeshError(f"sheet '{mesh.bonded[0]}' is bonded, and there is no solid")
        gaps, nearest = cKDTree(solid_places).query(sheet_nodes.places[bonded])
        if gaps.max() > COINCIDENT * np.ptp(sheet_nodes.places, axis=0).max():
            raise MeshError(
                f"a bonded sheet has a node {gaps.max():.3g} mm off the nearest of the solid; "
                "both need the same mesh there"
            )
        number[bonded] = nearest
    return number, sheet_nodes.places[~bonded]


def make_parts(
    mesh: SheetMesh,
    elements: np.ndarray,
    sheets: Mapping[str, Sheet],
    nodes: Nodes,
    size: int,
) -> dict[str, SheetPart]:
    """The sheets of a model of so many unknowns; elements: (m, n) model nodes of all triangles."""
    parts, patches = {}, mesh.patches()
    for name, numbers in mesh.parts.items():
        if name not in sheets:
            raise SpecError(f"sheet '{name}' has no material")
        of_part = elements[numbers]
        table = BlockTable(nodes.blocks[of_part])
        triangles = Triangles(of_part, nodes.places[of_part], nodes.dofs[of_part], table)
        parts[name] = SheetPart(name, sheets[name], triangles, patches[numbers], size, nodes.comm)
    return parts

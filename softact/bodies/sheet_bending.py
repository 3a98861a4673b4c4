"""The bending stiffness of sheets: which of them bend as one.

Each flat piece of a sheet between hinges is a plate. Sheets that the geometry calls continuous are
one, of as many stiffnesses: a moment passes from one to the next.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from softact.bodies.plate import LayerBending, is_flat
from softact.bodies.sheet import Sheet, SheetPart
from softact.errors import SpecError
from softact.system.assembly import Assembler
from softact.system.nodes import Nodes

if TYPE_CHECKING:
    from softact.model import Model

STRAIGHT = 1e-6  # sine of the angle to a plane of symmetry


def add_bending(
    parts: Mapping[str, SheetPart],
    continuous: Sequence[str],
    assembler: Assembler,
    nodes: Nodes,
    symmetry: Sequence[int],
) -> None:
    """Give sheets that have a bending stiffness its terms, one for each plate, with the first of
    its sheets. continuous: names of sheets that bend as one. symmetry: indices of the coordinates
    that are zero in the symmetry planes.

    Raises SpecError where a sheet that is not flat has one.
    """
    bending = {
        n: p for n, p in parts.items() if p.sheet.bending and p.triangles.nodes.shape[1] == 6
    }
    groups = [[part] for name, part in bending.items() if name not in continuous]
    groups.append([part for name, part in bending.items() if name in continuous])
    for group in filter(None, groups):
        for patch in np.unique(np.concatenate([part.patches for part in group])):
            here = [(part, np.flatnonzero(part.patches == patch)) for part in group]
            plate = [(part, members) for part, members in here if len(members)]
            plate[0][0].bend.append(_plate(plate, assembler, nodes, symmetry))


def _plate(
    plate: Sequence[tuple[SheetPart, np.ndarray]],
    assembler: Assembler,
    nodes: Nodes,
    symmetry: Sequence[int],
) -> LayerBending:
    """plate: sheets and the numbers (k,) of their triangles in it."""
    elements = np.concatenate([part.triangles.nodes[members] for part, members in plate])
    if not is_flat(nodes.places[elements]):
        raise SpecError(
            f"sheet '{plate[0][0].name}': the bending stiffness is that of a flat sheet, and this "
            "one is curved; give it bending: 0, make it of flat sheets, or write curved: false "
            "under solver, so that each flat side of the mesh bends"
        )
    each = np.array([part.sheet.rigidity() for part, _ in plate])
    rigidity, poisson = np.repeat(each, [len(members) for _, members in plate], axis=0).T
    # Its mirror image continues it only where the two meet without a crease.
    part, members = plate[0]
    normal = part.triangles.normals[members[0]]
    planes = tuple(c for c in symmetry if abs(normal[c]) < STRAIGHT)
    return LayerBending(assembler, nodes, elements, rigidity, poisson, planes)


def build(model: Model, parts: Mapping[str, Sheet]) -> list[SheetPart]:
    """The sheets of a model, see ``BodyKind``: it has made them with its nodes, here they get their
    bending."""
    mesh = model.mesh
    planes = tuple(mesh.layout.symmetry.values())
    continuous = mesh.sheets.continuous if mesh.sheets else ()
    add_bending(model.sheets, continuous, model.assembler, model.nodes, planes)
    return list(model.sheets.values())

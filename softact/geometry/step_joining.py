"""Solids of a STEP file that touch, joined by OCC before they are meshed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from types import ModuleType

import numpy as np

from softact.errors import MeshError
from softact.geometry.step_solids import Solid
from softact.mesh.components import place
from softact.units import show

OTHERWISE = (
    "join them in the CAD program, or write separate: true, and a contact that holds them together"
)
SAME_AREA = 1e-6  # relative


def join(
    gmsh: ModuleType, solids: Sequence[Solid], names: Sequence[str]
) -> tuple[list[Solid], dict[int, list[int]]]:
    """Give solids that touch a common face; returns the solids with their new tags, and face of a
    solid when it was read -> its pieces now.

    names: of the solids, for messages. Raises MeshError where two overlap, or OCC fails.
    """
    occ = gmsh.model.occ
    entities = [(3, solid.tag) for solid in solids]
    entities += [(2, face) for solid in solids for face in solid.faces]
    areas = {entity: occ.getMass(*entity) for entity in entities if entity[0] == 2}
    # Where old numbers are kept, gmsh 4.8 loses pieces of faces.
    gmsh.option.setNumber("Geometry.OCCBooleanPreserveNumbering", 0)
    try:
        _, pieces = occ.fragment(entities, [])
        occ.synchronize()
    except Exception as error:
        raise MeshError(f"OCC cannot join the solids ({_words(error)}); {OTHERWISE}") from None
    found = dict(zip(entities, pieces, strict=True))
    _refuse_overlap(gmsh, [found[3, solid.tag] for solid in solids], names)
    for face, area in areas.items():
        if abs(sum(occ.getMass(*piece) for piece in found[face]) - area) > SAME_AREA * area:
            raise MeshError(f"OCC loses a face where it joins the solids; {OTHERWISE}")
    moved = [replace(solid, tag=found[3, solid.tag][0][1]) for solid in solids]
    return moved, {face[1]: [tag for _, tag in found[face]] for face in areas}


def _words(error: Exception) -> str:
    return " ".join(str(error).split())


def _refuse_overlap(
    gmsh: ModuleType, pieces: Sequence[list[tuple[int, int]]], names: Sequence[str]
) -> None:
    for (i, one), (j, other) in combinations(enumerate(pieces), 2):
        if common := set(one) & set(other):
            volume = sum(gmsh.model.occ.getMass(*piece) for piece in common)
            where = place(np.array(gmsh.model.occ.getCenterOfMass(*min(common))))
            raise MeshError(
                f"the solids {show(names[i])} and {show(names[j])} overlap by {volume:.3g} mm^3 "
                f"near {where}; cut one out of the other in the CAD program"
            )

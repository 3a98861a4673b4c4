"""The displacement nodes of a model, whatever bodies they belong to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from softact.system.unknowns import Unknowns

if TYPE_CHECKING:
    from mpi4py import MPI


@dataclass(frozen=True)
class Nodes:
    """Displacement nodes that this process holds: its own, then ghosts; those of sheets come last,
    in a model of one process.

    comm: of the model. places: (n, 3) undeformed, mm. number: (n,) in the whole model. owned: how
    many are this process's own. dofs: (n, 3) local unknowns. blocks: (n,) blocks of the unknowns.
    """

    comm: MPI.Comm
    places: np.ndarray
    number: np.ndarray
    owned: int
    dofs: np.ndarray
    blocks: np.ndarray


def nodes_of(
    unknowns: Unknowns, loose_places: np.ndarray, places_of_space: np.ndarray | None = None
) -> Nodes:
    """All displacement nodes: those of the first space, and the loose ones at their places.

    places_of_space: (n, 3) mm, of the first space, where they are not its own.
    """
    places, number = np.empty((0, 3)), np.empty(0, np.int64)
    owned, dofs = 0, np.empty((0, 3), np.int32)
    if unknowns.spaces:
        space = unknowns.spaces[0]
        index_map = space.dofmap.index_map
        owned, dofs = index_map.size_local, unknowns.space_dofs[0]
        held = np.arange(owned + index_map.num_ghosts, dtype=np.int32)
        own = space.tabulate_dof_coordinates() if places_of_space is None else places_of_space
        places, number = own, index_map.local_to_global(held)
    loose = len(loose_places)
    return Nodes(
        unknowns.comm,
        np.vstack([places, loose_places]) if loose else places,
        np.concatenate([number, len(number) + np.arange(loose)]) if loose else number,
        owned + loose,
        np.vstack([dofs, unknowns.loose_dofs]) if loose else dofs,
        np.concatenate([np.arange(len(dofs)), unknowns.loose_blocks]),
    )

"""A plate that goes on in the next module of a chain: its bending across the border.

The facets of a plate at the right face meet the images of those at the left one there
(``softact.bodies.images``), at the same slope but for the jumps that the plate's penalty takes.
Each module has one such border; the energy of the edges there is quadratic in the places on both
sides.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse

from softact.system.term import Origin, State

if TYPE_CHECKING:
    from softact.bodies.images import Images, Triplets
    from softact.bodies.repeat import Repeat
    from softact.system.assembly import Assembler
    from softact.system.nodes import Nodes


@dataclass(frozen=True)
class Meeting:
    """Facets at the right face, then the images of those at the left one.

    elements: (k, 6) their nodes, 0 and so on; on the face both have the same. places: (k, 6, 3)
    undeformed, mm. own: (m, 3) unknowns of the first m nodes. images: the others.
    """

    elements: np.ndarray
    places: np.ndarray
    own: np.ndarray
    images: Images


def meet(
    repeat: Repeat, nodes: Nodes, facets: np.ndarray
) -> tuple[np.ndarray, np.ndarray, Meeting]:
    """Which of the facets (k, 6) are at the right face, which at the left one, and how they meet.
    nodes: of the model."""
    right, left = (_touching(facets, face) for face in (repeat.right_nodes, repeat.left_nodes))
    count = len(nodes.places)
    beyond = count + np.arange(count)  # numbers of the images
    beyond[repeat.left_nodes] = repeat.right_nodes
    both = np.concatenate([facets[right], beyond[facets[left]]])
    number, elements = np.unique(both, return_inverse=True)
    source = number[number >= count] - count
    images = repeat.images(source)
    places = np.concatenate(
        [nodes.places[facets[right]], nodes.places[facets[left]] + repeat.pitch]
    )
    own = nodes.dofs[number[number < count]]
    return right, left, Meeting(elements.reshape(-1, 6), places, own, images)


def _touching(facets: np.ndarray, face: np.ndarray) -> np.ndarray:
    """Numbers of the facets that have an edge in a face, and do not lie in it."""
    return np.flatnonzero(np.isin(facets[:, :3], face).sum(axis=1) == 2)


class Seam:
    """½ Σ_c v_cᵀ M v_c with the displacements v of both sides: M bends no plane.

    matrix: (n, n) M, N/mm, of the meeting's nodes; kept as (3 n, 3 n), of their displacements.
    """

    def __init__(self, assembler: Assembler, meeting: Meeting, matrix: scipy.sparse.csr_matrix):
        self._assembler, self._matrix = assembler, matrix
        self._own, self._images = meeting.own, meeting.images
        self.matrix = scipy.sparse.kron(matrix, np.eye(3)).tocsr()
        self._size = assembler.unknowns.local
        self._lay_out()

    def _displacements(self, x: np.ndarray) -> np.ndarray:
        return np.concatenate([x[self._own], self._images.displacements(x)])

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        own, beyond = self._forces(state.x)
        out[self._own] += own
        self._images.pull(state.x, beyond, out)

    def _forces(self, x: np.ndarray) -> list[np.ndarray]:
        """Of the own nodes and of the images, N."""
        return np.split(self._matrix @ self._displacements(x), [len(self._own)])

    def energy(self, state: State) -> float:
        """See ``Term``."""
        moved = self._displacements(state.x)
        return float(np.sum(moved * (self._matrix @ moved))) / 2

    def sides(self, x: np.ndarray) -> tuple[scipy.sparse.csr_matrix, scipy.sparse.csr_matrix]:
        """Derivatives (3 n, local) of the displacements: those of the own nodes, of the images."""
        own, images = map(self._sparse, self._entries_of(x))
        return own, images

    def _entries_of(self, x: np.ndarray) -> tuple[Triplets, Triplets]:
        rows = np.arange(3 * self._matrix.shape[0]).reshape(-1, 3)
        mine = rows[: len(self._own)].ravel()
        own = mine, self._own.ravel(), np.ones(len(mine))
        return own, self._images.jacobian(x, rows[len(self._own) :])

    def _sparse(self, entries: Triplets) -> scipy.sparse.csr_matrix:
        rows, columns, values = entries
        shape = self.matrix.shape[0], self._size
        return scipy.sparse.csr_matrix((values, (rows, columns)), shape=shape)

    def _jacobian(self, x: np.ndarray) -> scipy.sparse.csr_matrix:
        """Derivatives (3 n, local) of the displacements, zeros among them, so that all states have
        the same entries."""
        pairs = zip(*self._entries_of(x), strict=True)
        rows, columns, values = (np.concatenate(pair) for pair in pairs)
        return self._sparse((rows, columns, values))

    def _lay_out(self) -> None:
        """Make room in the matrix."""
        rest = np.zeros(self._size)
        ones = self._jacobian(rest)
        ones.data[:] = 1.0
        each = self.matrix.copy()
        each.data[:] = 1.0
        found = (ones.T @ each @ ones).tocoo()
        rows, columns, _ = self._images.second(rest, np.zeros((len(self._images.dofs), 3)))
        self._keys = np.unique(np.append(self._key(found.row, found.col), self._key(rows, columns)))
        self._entries = np.divmod(self._keys, self._size)
        self._slots = self._assembler.couple(*self._entries)

    def _key(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """One number for each entry of the matrix."""
        return rows.astype(np.int64) * self._size + columns

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """See ``Term``."""
        jacobian = self._jacobian(state.x)
        folded = (jacobian.T @ self.matrix @ jacobian).tocoo()
        rows, columns, values = self._images.second(state.x, self._forces(state.x)[1])
        keys = np.append(self._key(folded.row, folded.col), self._key(rows, columns))
        at = np.searchsorted(self._keys, keys)
        found = np.bincount(at, np.append(folded.data, values), len(self._keys))
        free = self._assembler.fixed == 0
        rows, columns = self._entries
        self._assembler.extra_values[self._slots] += found * free[rows] * free[columns]

"""Bending stiffness of a flat thin layer on the quadratic facets of a solid.

A membrane without bending stiffness that is stiff and embedded in soft rubber wrinkles at the
size of the elements as soon as it is pressed: mesh, not physics. Paper has a bending stiffness
D = E t³/(12 (1 − ν²)), and it is what sets the true wrinkling strain.

A stiff layer bends almost without stretching. For such deformations the second derivatives of the
position x by the coordinates of the flat layer are the curvatures, so the bending energy

    ½ D ∫ (1 − ν) |∇∇x|² + ν |Δx|² dA

is quadratic in x with a constant matrix, and does not change under rotation (the isometric
bending model: Bergou, Wardetzky, Harmon, Zorin, Grinspun, SGP 2006). Facets are only C0, so the
jumps of slope between them enter by symmetric interior penalty (C0-IP: Engel et al., CMAME 191
(2002) 3669; Brenner and Sung, J. Sci. Comput. 22 (2005) 83). Where facets of different stiffness
meet, the mean of their moments is weighted by that of the other, and the penalty goes with their
harmonic mean (Ern, Stephansen and Zunino, IMA J. Numer. Anal. 29 (2009) 235): a soft layer beside a
stiff one does not lock.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse

from softact.bodies.seam import Seam, meet
from softact.system.assembly import Assembler
from softact.system.nodes import Nodes
from softact.system.term import Origin, State

if TYPE_CHECKING:
    from softact.bodies.repeat import Repeat

PENALTY = 8.0  # times D over the edge length; positive definite from about 3 on
FLATNESS = 1e-6  # of the layer's size
GAUSS = (0.5 - 0.5 / np.sqrt(3), 0.5 + 0.5 / np.sqrt(3))


class LayerBending:
    """Bending energy of one flat layer; see the module.

    nodes: of the model. facets: (k, 6) those of this process's facets, corners then middles of the
    edges 01 12 20. rigidity: D in N·mm, and poisson: one for all facets or (k,). symmetry: indices
    of the coordinates that are zero in the symmetry planes.
    """

    def __init__(
        self,
        assembler: Assembler,
        nodes: Nodes,
        facets: np.ndarray,
        rigidity: float | np.ndarray,
        poisson: float | np.ndarray,
        symmetry: Collection[int],
    ):
        self._assembler, self._comm, self._nodes = assembler, nodes.comm, nodes
        number = nodes.number
        stiffness, ratio = _of_each(facets, rigidity, poisson)
        self._facets, self._made_of = facets, (stiffness, ratio)
        self.seam: Seam | None = None
        each = number[facets], nodes.places[facets], stiffness, ratio
        triangles, x, stiffness, ratio = (
            np.concatenate(nodes.comm.allgather(values)) for values in each
        )
        layer_nodes, compact = np.unique(triangles, return_inverse=True)
        compact = compact.reshape(-1, 6)
        even, odd = bending_matrices(x, compact, len(layer_nodes), stiffness, ratio, symmetry)
        owned = np.flatnonzero(np.isin(number[: nodes.owned], layer_nodes))
        self._owned_dofs = nodes.dofs[owned]
        mine = np.searchsorted(layer_nodes, number[owned])
        self._order = np.argsort(np.concatenate(nodes.comm.allgather(mine)))
        # Of all three components of this process's nodes, by those of all nodes of the layer.
        across = np.isin(np.arange(3), list(symmetry))
        self._rows = scipy.sparse.csr_matrix(
            scipy.sparse.kron(even[mine], np.diag(~across).astype(float))
            + scipy.sparse.kron(odd[mine], np.diag(across).astype(float))
        )
        self._register()

    def _register(self) -> None:
        """Tell the assembler which unknowns are coupled, and keep the entries' order."""
        u = self._assembler.unknowns
        mine, entries = u.number[self._owned_dofs], self._rows.tocoo()
        self._slots = self._assembler.couple(
            mine.ravel()[entries.row], self._gather(mine).ravel()[entries.col]
        )
        self._entries = entries.row, entries.col, entries.data
        self._free = np.ones_like(mine, dtype=bool), np.ones((len(self._order), 3), dtype=bool)
        self._values = entries.data

    def go_on(self, repeat: Repeat) -> None:
        """Bend across the border to the next module, too; in one process."""
        right, left, meeting = meet(repeat, self._nodes, self._facets)
        stiffness, ratio = (np.concatenate([v[right], v[left]]) for v in self._made_of)
        matrix = matrix_between(meeting.places, meeting.elements, stiffness, ratio, len(right))
        if matrix.nnz:
            self.seam = Seam(self._assembler, meeting, matrix)

    def _gather(self, mine: np.ndarray) -> np.ndarray:
        """Values (n, 3) at all nodes of the layer, from those at each process's own."""
        parts = self._comm.allgather(mine) if self._comm.size > 1 else [mine]
        return np.concatenate(parts)[self._order]

    def _forces(self, state: State) -> np.ndarray:
        u = self._gather(state.x[self._owned_dofs])
        return (self._rows @ u.ravel()).reshape(-1, 3)

    def add_force(self, state: State, out: np.ndarray) -> None:
        out[self._owned_dofs] += self._forces(state)
        if self.seam:
            self.seam.add_force(state, out)

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        mine = self._assembler.fixed[self._owned_dofs] == 0
        free = mine, self._gather(mine)
        if not all(map(np.array_equal, free, self._free)):
            row, column, data = self._entries
            self._free = free
            self._values = data * (free[0].ravel()[row] & free[1].ravel()[column])
        self._assembler.extra_values[self._slots] += self._values
        if self.seam:
            self.seam.add_tangent(state, origin)

    def energy(self, state: State) -> float:
        inside = float(np.sum(self._forces(state) * state.x[self._owned_dofs])) / 2
        return inside + self.seam.energy(state) if self.seam else inside


def bending_matrices(
    x: np.ndarray,
    triangles: np.ndarray,
    count: int,
    rigidity: float | np.ndarray,
    poisson: float | np.ndarray,
    symmetry: Collection[int] = (),
) -> tuple[scipy.sparse.csr_matrix, scipy.sparse.csr_matrix]:
    """Stiffness of one component of the position: (even, odd) sparse matrices (count, count).

    x: (k, 6, 3) nodes of each facet in mm; triangles: (k, 6) their numbers, below ``count``;
    rigidity, poisson: one for all or (k,).
    even: for components along the symmetry planes (their mirror image continues evenly), odd:
    for the component across. Raises ValueError where the layer is not flat.
    """
    rigidity, poisson = _of_each(triangles, rigidity, poisson)
    s = _plane_coordinates(x)
    basis = _basis(s)
    hessian = _hessian(basis)
    area = np.abs(np.cross(s[:, 1] - s[:, 0], s[:, 2] - s[:, 0])) / 2
    moment = _moments(hessian, rigidity, poisson)
    weighted = moment * np.array([1.0, 2.0, 1.0])[:, None] * area[:, None, None]
    inner = np.einsum("kai,kaj->kij", weighted, hessian)
    facing, edges = _edges(triangles)
    jumps = _jumps(facing, edges, s, basis, moment, triangles, count, rigidity)
    even = odd = _scatter(inner, triangles, count) + jumps
    outer = facing[:, 1] < 0
    facet, edge = facing[outer, 0], edges[outer]
    corner = _corners(facet, edge, triangles)
    for plane in symmetry:
        inside = (np.abs(x[facet[:, None], corner, plane]) < 1e-9).all(axis=1)
        even = even + _mirror(
            facet[inside], edge[inside], s, basis, moment, triangles, count, rigidity
        )
    return even.tocsr(), odd.tocsr()


def matrix_between(
    x: np.ndarray,
    triangles: np.ndarray,
    rigidity: np.ndarray,
    poisson: np.ndarray,
    first: int,
) -> scipy.sparse.csr_matrix:
    """The part of ``bending_matrices`` of the edges where one of the first so many facets meets one
    of the others. Numbers of nodes go from 0 on; there may be no facet."""
    count = int(triangles.max(initial=-1)) + 1
    facing, edges = _edges(triangles)
    meet = (facing[:, 0] < first) & (facing[:, 1] >= first)
    if not meet.any():
        return scipy.sparse.csr_matrix((count, count))
    s = _plane_coordinates(x)
    basis = _basis(s)
    moment = _moments(_hessian(basis), rigidity, poisson)
    return _jumps(facing[meet], edges[meet], s, basis, moment, triangles, count, rigidity).tocsr()


def is_flat(x: np.ndarray) -> bool:
    """Whether points (..., 3) lie in one plane."""
    points = x.reshape(-1, 3)
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[2] < FLATNESS * spread[0])


def _plane_coordinates(x: np.ndarray) -> np.ndarray:
    if not is_flat(x):
        raise ValueError("the layer is not flat")
    points = x.reshape(-1, 3)
    centre = points.mean(axis=0)
    axes = np.linalg.svd(points - centre, full_matrices=False)[2]
    return (x - centre) @ axes[:2].T


def _basis(s: np.ndarray) -> np.ndarray:
    """Coefficients (k, 6 monomials, 6 functions) of 1, s, t, s², st, t² about the first corner."""
    local = s - s[:, :1]
    a, b = local[..., 0], local[..., 1]
    return np.linalg.inv(np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], axis=-1))


def _hessian(basis: np.ndarray) -> np.ndarray:
    """Second derivatives xx, xy, yy of each function: (k, 3, 6)."""
    return np.stack([2 * basis[:, 3], basis[:, 4], 2 * basis[:, 5]], axis=1)


def _of_each(
    facets: np.ndarray, rigidity: float | np.ndarray, poisson: float | np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Bending stiffness and Poisson's ratio (k,) of k facets."""
    of_each = (np.broadcast_to(np.asarray(v, float), len(facets)) for v in (rigidity, poisson))
    stiffness, ratio = of_each
    return stiffness, ratio


def _moments(hessian: np.ndarray, rigidity: np.ndarray, poisson: np.ndarray) -> np.ndarray:
    """Moments (k, 3, 6) of the second derivatives (k, 3, 6)."""
    xx, xy, yy = hessian[:, 0], hessian[:, 1], hessian[:, 2]
    rigidity, poisson = rigidity[:, None], poisson[:, None]
    bulk = poisson * (xx + yy)
    return rigidity[:, None] * np.stack(
        [(1 - poisson) * xx + bulk, (1 - poisson) * xy, (1 - poisson) * yy + bulk], axis=1
    )


def _slopes(points: np.ndarray, normal: np.ndarray, s: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Derivative along ``normal`` (k, 2) of the six functions at ``points`` (k, 2): (k, 6)."""
    a, b = (points - s[:, 0]).T[..., None]
    gx = basis[:, 1] + 2 * a * basis[:, 3] + b * basis[:, 4]
    gy = basis[:, 2] + a * basis[:, 4] + 2 * b * basis[:, 5]
    return normal[:, :1] * gx + normal[:, 1:] * gy


def _normal_moment(moment: np.ndarray, normal: np.ndarray) -> np.ndarray:
    n0, n1 = normal.T[..., None]
    return n0 * n0 * moment[:, 0] + 2 * n0 * n1 * moment[:, 1] + n1 * n1 * moment[:, 2]


def _edges(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges of all facets: (facing: (m, 2) facet on either side or -1, edges: (m, 2) nodes)."""
    sides = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    owner = np.repeat(np.arange(len(triangles)), 3)
    edges, place = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    place = place.ravel()
    facing = np.full((len(edges), 2), -1)
    order = np.argsort(place, kind="stable")
    first = np.searchsorted(place[order], np.arange(len(edges)))
    facing[:, 0] = owner[order[first]]
    last = np.searchsorted(place[order], np.arange(len(edges)), side="right") - 1
    shared = last > first
    facing[shared, 1] = owner[order[last[shared]]]
    return facing, edges


def _corners(facet: np.ndarray, edge: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Which corners (m, 2) of its facet the nodes of an edge are."""
    return np.argmax(triangles[facet][:, None, :3] == edge[:, :, None], axis=2)


def _edge_frame(
    facet: np.ndarray, edge: np.ndarray, s: np.ndarray, triangles: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ends (m, 2, 2), length (m,) and normal (m, 2), out of ``facet``, of edges."""
    ends = s[facet[:, None], _corners(facet, edge, triangles)]
    along = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(along, axis=1)
    normal = np.column_stack([along[:, 1], -along[:, 0]]) / length[:, None]
    outward = np.einsum("mi,mi->m", normal, ends[:, 0] - s[facet, :3].mean(axis=1))
    return ends, length, normal * np.sign(outward)[:, None]


def _penalty_terms(
    mean: np.ndarray, jump: np.ndarray, length: np.ndarray, rigidity: np.ndarray
) -> np.ndarray:
    """∫ −2 {M} [∂x] + σ/h [∂x]² over edges, one Gauss point: (m, n, n)."""
    crossed = mean[:, :, None] * jump[:, None]
    stiff = (PENALTY * rigidity / length)[:, None, None] * jump[:, :, None] * jump[:, None]
    return (length / 2)[:, None, None] * (stiff - crossed - crossed.transpose(0, 2, 1))


def _jumps(
    facing: np.ndarray,
    edges: np.ndarray,
    s: np.ndarray,
    basis: np.ndarray,
    moment: np.ndarray,
    triangles: np.ndarray,
    count: int,
    rigidity: np.ndarray,
) -> scipy.sparse.csr_matrix:
    """Edge terms between facets that face each other."""
    inner = facing[:, 1] >= 0
    (one, two), edge = facing[inner].T, edges[inner]
    ends, length, normal = _edge_frame(one, edge, s, triangles)
    d = np.column_stack([rigidity[one], rigidity[two]])
    share = d[:, ::-1] / d.sum(axis=1, keepdims=True)
    mean = np.hstack(
        [_normal_moment(moment[f], normal) * share[:, i, None] for i, f in enumerate((one, two))]
    )
    harmonic = 2 * share[:, 0] * d[:, 0]
    total = np.zeros((len(mean), mean.shape[1], mean.shape[1]))
    for t in GAUSS:
        points = (1 - t) * ends[:, 0] + t * ends[:, 1]
        jump = np.hstack(
            [
                _slopes(points, normal, s[one], basis[one]),
                -_slopes(points, normal, s[two], basis[two]),
            ]
        )
        total = total + _penalty_terms(mean, jump, length, harmonic)
    return _scatter(total, np.hstack([triangles[one], triangles[two]]), count)


def _mirror(
    facet: np.ndarray,
    edge: np.ndarray,
    s: np.ndarray,
    basis: np.ndarray,
    moment: np.ndarray,
    triangles: np.ndarray,
    count: int,
    rigidity: np.ndarray,
) -> scipy.sparse.csr_matrix:
    """Half of the edge terms between a facet and its mirror image, for an even component."""
    if not len(facet):
        return scipy.sparse.csr_matrix((count, count))
    ends, length, normal = _edge_frame(facet, edge, s, triangles)
    mean = _normal_moment(moment[facet], normal)
    total = np.zeros((len(mean), mean.shape[1], mean.shape[1]))
    for t in GAUSS:
        points = (1 - t) * ends[:, 0] + t * ends[:, 1]
        jump = 2 * _slopes(points, normal, s[facet], basis[facet])
        total = total + _penalty_terms(mean, jump, length, rigidity[facet]) / 2
    return _scatter(total, triangles[facet], count)


def _scatter(blocks: np.ndarray, nodes: np.ndarray, count: int) -> scipy.sparse.csr_matrix:
    n = nodes.shape[1]
    rows, columns = np.repeat(nodes, n, axis=1), np.tile(nodes, (1, n))
    return scipy.sparse.csr_matrix(
        (blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(count, count)
    )

"""Whether elements keep their orientation everywhere, not only at their quadrature points.

An element whose middle is inside out is none any more. One that is folded at a corner alone still
carries its forces (a coarse mesh of a balloon has such elements, and the balloon's pressure): that
is told, not refused.

With quadratic displacements on straight edges J = det F is a cubic polynomial over the tetrahedron,
and on curved ones J times the determinant of the undeformed shape is. It lies between the smallest
and the largest of its Bernstein coefficients (Johnen, Remacle and Geuzaine 2013, J. Comput. Phys.
233:359); where these do not decide, the tetrahedron is cut into eight, which brings them closer.
"""

from __future__ import annotations

import functools
import itertools
from dataclasses import dataclass
from math import factorial

import numpy as np

from softact import compat
from softact.bodies.solid import Solid

DEGREE = 3  # of J
MIDDLE = np.full((1, 3), 0.25)  # reference coordinates
# Times that an undecided element is cut into eight; what is undecided then counts as sound.
CUTS = 2

# Corners of the eight pieces, from corners of the whole: one at each, and four around the line from
# the middle of 03 to that of 12.
EIGHT: tuple[tuple[tuple[int, ...], ...], ...] = (
    *(((i,), *(tuple(sorted((i, j))) for j in range(4) if j != i)) for i in range(4)),
    *(
        ((0, 3), (1, 2), a, b)
        for a, b in itertools.pairwise([(0, 1), (0, 2), (2, 3), (1, 3), (0, 1)])
    ),
)


@dataclass(frozen=True, order=True)
class Smallest:
    """The smallest J that was found, and where: undeformed place (3,) mm, number of the cell in
    its region."""

    jacobian: float
    place: tuple[float, float, float]
    cell: int = -1


NOTHING = Smallest(np.inf, (np.nan, np.nan, np.nan))  # where there are no tetrahedra


def lattice(order: int) -> np.ndarray:
    """Barycentric multi-indices (n, 4) of a tetrahedron: whole numbers with the sum ``order``."""
    numbers = itertools.product(range(order + 1), repeat=3)
    return np.array([(order - sum(n), *n) for n in numbers if sum(n) <= order])


def _place(point: np.ndarray) -> tuple[float, float, float]:
    x, y, z = map(float, point)
    return x, y, z


@functools.cache
def _to_bernstein() -> np.ndarray:
    """Matrix (20, 20): Bernstein coefficients of a cubic from its values on its lattice."""
    powers = lattice(DEGREE)
    places = powers / DEGREE
    times = np.array([factorial(DEGREE) / np.prod([factorial(i) for i in a]) for a in powers])
    basis = times * np.prod(places[:, None] ** powers, axis=2)
    return np.linalg.inv(basis)


@functools.cache
def _pieces(cuts: int) -> tuple[np.ndarray, np.ndarray]:
    """Lattice (n, 4), barycentric, of the element that has been cut so often, and the numbers
    (m, 20) of its points that each piece has."""
    corners = np.eye(4, dtype=int)[None] * 2**cuts
    for _ in range(cuts):
        corner: dict[tuple[int, ...], np.ndarray] = {(i,): corners[:, i] for i in range(4)}
        pairs = itertools.combinations(range(4), 2)
        corner |= {(i, j): (corners[:, i] + corners[:, j]) // 2 for i, j in pairs}
        corners = np.concatenate([np.stack([corner[c] for c in part], axis=1) for part in EIGHT])
    order = DEGREE * 2**cuts
    whole = lattice(order)
    number = {tuple(a): i for i, a in enumerate(whole)}
    points = np.einsum("nk,pkc->pnc", lattice(DEGREE), corners)
    members = np.array([[number[tuple(a)] for a in piece] for piece in points])
    return whole / order, members


def smallest_in_the_middle(solid: Solid, x: np.ndarray) -> Smallest:
    """The smallest J at the middle of a tetrahedron of a region."""
    if not len(solid.cells):
        return NOTHING
    gradients = compat.tabulate_gradients(solid.degree, MIDDLE)
    jacobian = solid.jacobian(x, gradients)[:, 0]
    least = int(np.argmin(jacobian))
    return Smallest(float(jacobian[least]), _place(solid.centres()[least]), least)


def smallest_jacobian(solid: Solid, x: np.ndarray, cells: np.ndarray | None = None) -> Smallest:
    """The smallest J over a region of tetrahedra, as far as it decides whether it is above zero; of
    some cells (k,) of it, where these are given."""
    cells, best = np.arange(len(solid.cells)) if cells is None else cells, NOTHING
    for cuts in range(CUTS + 1):
        if not len(cells):
            return best
        barycentric, members = _pieces(cuts)
        gradients = compat.tabulate_gradients(solid.degree, barycentric[:, 1:])
        jacobian = solid.jacobian(x, gradients, cells)
        least = np.unravel_index(np.argmin(jacobian), jacobian.shape)
        if jacobian[least] < best.jacobian:
            place = solid.places(barycentric[least[1]][None, 1:], cells[least[0]])[0]
            best = Smallest(float(jacobian[least]), _place(place), int(cells[least[0]]))
        polynomial = jacobian * np.abs(solid.shape_determinant(gradients, cells))
        bounds = (polynomial[:, members] @ _to_bernstein().T).min(axis=(1, 2))
        cells = cells[(bounds <= 0) & (jacobian.min(axis=1) > 0)]
    return best

"""What a planar module answers, as one energy whose derivatives are moment, force and air."""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Response:
    """A polynomial energy by length over curvature in 1/mm, stretch and pressure in MPa.

    `low` and `high`, shape (3,), are the range of the states it was fitted to; `powers` (terms, 3)
    and `constants` (terms,) count in that range as -1 to 1.
    """

    low: Array
    high: Array
    powers: NDArray[np.int64]
    constants: Array

    def derivative(self, states: Array, orders: tuple[int, int, int]) -> Array:
        """A partial derivative at states (n, 3), shape (n,), also outside of the range."""
        return _columns(self.low, self.high, self.powers, states, orders) @ self.constants

    def check(self, states: Array) -> None:
        """Raise ValueError where states (n, 3) are outside of the range."""
        names = ("curvature", "stretch", "pressure")
        for name, column, low, high in zip(names, states.T, self.low, self.high, strict=True):
            slack = 1e-9 * (high - low)
            if column.min() < low - slack or column.max() > high + slack:
                span = f"{column.min():g} to {column.max():g}"
                raise ValueError(f"{name} {span} is outside of the table: {low:g} to {high:g}")

    def conjugates(self, states: Array) -> Array:
        """Moment in N mm, force in N and air by length in mm^2, shape (3, n)."""
        return np.stack([sign * self.derivative(states, order) for sign, order in CONJUGATES])


CONJUGATES = ((1, (1, 0, 0)), (1, (0, 1, 0)), (-1, (0, 0, 1)))


@dataclass(frozen=True)
class AtPressure:
    """The law of a rod at one pressure in MPa; more: curvature of the module beyond the rod's,
    where the ends of the rod bend less than its modules."""

    response: Response
    pressure: float
    more: float = 0.0

    def states(self, curvature: Array, stretch: Array) -> Array:
        """Of the modules, shape (n, 3)."""
        return np.stack(
            [curvature + self.more, stretch, np.full_like(stretch, self.pressure)], axis=1
        )

    def energy(self, curvature: Array, stretch: Array) -> Array:
        """Of each of n pieces, mJ/mm, shape (n,)."""
        return self.response.derivative(self.states(curvature, stretch), (0, 0, 0))

    def derivatives(self, curvature: Array, stretch: Array) -> tuple[Array, Array]:
        """Moment and force, shape (2, n), and their derivatives, shape (2, 2, n)."""
        states = self.states(curvature, stretch)
        bend, mixed, grow = (
            self.response.derivative(states, order) for order in ((2, 0, 0), (1, 1, 0), (0, 2, 0))
        )
        return self.response.conjugates(states)[:2], np.array([[bend, mixed], [mixed, grow]])


def fit(
    states: Array, conjugates: Array, degree: int, within: tuple[Array, Array] | None = None
) -> Response:
    """The energy of least squares to moment, force and air (3, n) at states (n, 3).

    Each of the three counts by its own largest value. within: the range, by default that of the
    states. Raises ValueError where the states are too few, or do not spread in all directions.
    """
    low, high = within or (states.min(axis=0), states.max(axis=0))
    if np.any(high <= low):
        raise ValueError("curvature, stretch and pressure must each take two values or more")
    powers = np.array([p for p in product(range(degree + 1), repeat=3) if 0 < sum(p) <= degree])
    scales = np.abs(conjugates).max(axis=1)
    scales[scales == 0] = 1.0
    blocks = [
        sign * _columns(low, high, powers, states, order) / scale
        for (sign, order), scale in zip(CONJUGATES, scales, strict=True)
    ]
    matrix = np.vstack(blocks)
    size = np.linalg.norm(matrix, axis=0)
    constants, _, rank, _ = np.linalg.lstsq(
        matrix / size, (conjugates / scales[:, None]).ravel(), rcond=None
    )
    if rank < len(powers):
        raise ValueError(f"{len(states)} states are too few for an energy of degree {degree}")
    return Response(low, high, powers, constants / size)


def errors(response: Response, states: Array, conjugates: Array) -> Array:
    """Largest deviation of moment, force and air at held-out states, as a part of each largest."""
    off = np.abs(response.conjugates(states) - conjugates).max(axis=1)
    return np.asarray(off / np.abs(conjugates).max(axis=1))


def _columns(
    low: Array,
    high: Array,
    powers: NDArray[np.int64],
    states: Array,
    orders: tuple[int, int, int],
) -> Array:
    """Derivatives of every monomial, shape (n, terms)."""
    half = (high - low) / 2
    places = (states - (low + high) / 2) / half
    columns = np.ones((len(states), len(powers)))
    for axis, order in enumerate(orders):
        power = powers[:, axis]
        factor = np.prod([power - k for k in range(order)], axis=0) / half[axis] ** order
        columns *= factor * places[:, [axis]] ** np.maximum(power - order, 0)
    return columns

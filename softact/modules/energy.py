"""What a module answers, as one energy by length over its strains and pressures.

A polynomial, fitted by least squares to its first and its second derivatives at once: moment,
force and air, their stiffness, and what the pressure changes of them. So the stiffness is
symmetric, and no cycle of loads and pressures makes work from nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SECOND = 0.3  # of the weight of a first derivative
AT_REST = 30.0  # times the weight of another state: nothing is bent by nothing
NEAR = 0.1  # of the largest load: states with more count less, for a rod is seldom there
OF_COMPLIANCE = 2  # degree of the compliance over the other variables, at most
LEAST = 0.02  # of the largest compliance: smaller ones count as this
MOST = 3  # terms for each state: more of them swing between the states
CHECKED = 2000  # places at which a compliance shall be positive
SECONDARY = 2  # the highest power of all strains that hardly change


@dataclass(frozen=True)
class Energy:
    """A polynomial of n variables, mJ/mm: strains (rad/mm, or 1) first, then pressures (MPa).

    names: of the variables. low, high (n,): the range of the states it was fitted to. powers
    (terms, n) and constants (terms,) count in that range as −1 to 1.
    """

    names: tuple[str, ...]
    low: Array
    high: Array
    powers: NDArray[np.int64]
    constants: Array

    @cached_property
    def half(self) -> Array:
        """Half of the range (n,)."""
        return (self.high - self.low) / 2

    @cached_property
    def _derivatives(self) -> tuple[Array, Array]:
        """Constants of the first (n, terms) and second derivatives (n, n, terms) in the same
        terms."""
        number = {tuple(power): at for at, power in enumerate(self.powers.tolist())}
        n, terms = len(self.names), len(self.powers)

        def by(constants: Array, variable: int) -> Array:
            out = np.zeros(terms)
            for at in np.flatnonzero(constants):
                power = self.powers[at].tolist()
                if power[variable]:
                    factor = power[variable] / self.half[variable]
                    power[variable] -= 1
                    out[number[tuple(power)]] += factor * constants[at]
            return out

        first = np.array([by(self.constants, i) for i in range(n)])
        second = np.array([[by(first[i], j) for j in range(n)] for i in range(n)])
        return first, second

    def terms(self, places: Array) -> Array:
        """Of every monomial at places (m, n), shape (m, terms)."""
        return _monomials((places - (self.low + self.high) / 2) / self.half, self.powers)

    def value(self, places: Array) -> Array:
        """At places (m, n), (m,)."""
        return self.terms(places) @ self.constants

    def first(self, places: Array) -> Array:
        """Derivatives (m, n): moment in N mm, force in N, and minus the air by length in mm²."""
        return self.terms(places) @ self._derivatives[0].T

    def both(self, places: Array) -> tuple[Array, Array]:
        """First (m, n) and second (m, n, n) derivatives."""
        first, second = self._derivatives
        n, terms = len(self.names), self.terms(places)
        return terms @ first.T, (terms @ second.reshape(n * n, -1).T).reshape(-1, n, n)


def _monomials(scaled: Array, powers: NDArray[np.int64]) -> Array:
    """Of places (m, n) in the range −1 to 1, (m, terms)."""
    out = np.ones((len(scaled), len(powers)))
    for axis, column in enumerate(powers.T):
        table = np.ones((column.max(initial=0) + 1, len(scaled)))
        for power in range(1, len(table)):
            table[power] = table[power - 1] * scaled[:, axis]
        out *= table[column].T
    return out


def _powers(
    names: Sequence[str], degree: int, secondary: Sequence[bool], of_compliance: int
) -> NDArray[np.int64]:
    """Of all terms up to a degree, those without the secondary variables' higher powers. Forces are
    small: they come once, with all of the others but for one degree, and twice, with so many of
    the others: a compliance."""
    forces = [name.startswith("force") for name in names]
    most = [
        2 if force else min(degree, SECONDARY) if few else degree
        for force, few in zip(forces, secondary, strict=True)
    ]
    others = {0: degree, 1: degree - 1, 2: of_compliance}
    found = []
    for power in product(*(range(m + 1) for m in most)):
        pulled = sum(p for p, force in zip(power, forces, strict=True) if force)
        few = sum(p for p, f, s in zip(power, forces, secondary, strict=True) if s and not f)
        if few <= SECONDARY and pulled <= 2 and sum(power) - pulled <= others[pulled]:
            found.append(power)
    return np.array(found).reshape(len(found), len(names))


@dataclass(frozen=True)
class Samples:
    """What is known of an energy: at places (s, n) its first (s, n) and second (s, n, n)
    derivatives."""

    places: Array
    first: Array
    second: Array

    def weights(self, strains: int) -> Array:
        """(s,), by the loads that hold the first so many variables."""
        loads = np.abs(self.first[:, :strains])
        largest = loads.max(axis=0)
        size = (loads / np.where(largest > 0, largest, 1.0)).max(axis=1, initial=0.0)
        return np.asarray(NEAR / (NEAR + size))

    def part(self, chosen: NDArray[np.bool_]) -> Samples:
        """Some of them."""
        return Samples(self.places[chosen], self.first[chosen], self.second[chosen])


def fit(
    samples: Samples,
    names: Sequence[str],
    degree: int,
    secondary: Sequence[bool],
    within: tuple[Array, Array],
) -> Energy:
    """The energy of least squares to first and second derivatives, concave in the forces.

    The first of the samples is at rest. secondary: which variables have powers up to two alone.
    within: the range (n,), (n,). Raises ValueError where the samples are too few.
    """
    forces = [i for i, name in enumerate(names) if name.startswith("force")]
    for of_compliance in range(OF_COMPLIANCE, 0, -1):
        found = _fitted(samples, names, degree, secondary, within, of_compliance)
        if _concave(found, forces):
            return found
    return _fitted(samples, names, degree, secondary, within, 0)


def _concave(energy: Energy, forces: Sequence[int]) -> bool:
    """Whether it is, over the forces, all over its range."""
    if not forces:
        return True
    places = np.random.default_rng(0).uniform(
        energy.low, energy.high, size=(CHECKED, len(energy.low))
    )
    second = energy.both(places)[1][:, forces][:, :, forces]
    return bool((np.linalg.eigvalsh(second) < 0).all())


def _fitted(
    samples: Samples,
    names: Sequence[str],
    degree: int,
    secondary: Sequence[bool],
    within: tuple[Array, Array],
    of_compliance: int,
) -> Energy:
    low, high = within
    n = len(names)
    powers = _powers(names, degree, secondary, of_compliance)
    basis = Energy(tuple(names), low, high, powers, np.zeros(len(powers)))
    terms, half = basis.terms(samples.places), basis.half
    number = {tuple(power): at for at, power in enumerate(powers.tolist())}

    def columns(orders: Sequence[int]) -> Array:
        """Derivatives of every monomial by scaled variables (s, terms)."""
        out = np.zeros_like(terms)
        for at, power in enumerate(powers.tolist()):
            factor, lower = 1, list(power)
            for i in orders:
                factor *= lower[i]
                lower[i] -= 1
            if factor:
                out[:, at] = factor * terms[:, number[tuple(lower)]]
        return out

    near = samples.weights(sum(not name.startswith("pressure") for name in names))
    weights = near * np.where(np.arange(len(terms)) == 0, AT_REST, 1.0)
    first, second = samples.first * half, samples.second * np.outer(half, half)
    sizes = np.abs(first).max(axis=0)
    sizes = np.maximum(sizes, 1e-6 * sizes.max())
    rows, right = [], []
    for i in range(n):
        scale = weights / sizes[i]
        rows.append(columns([i]) * scale[:, None])
        right.append(first[:, i] * scale)
        for j in range(i, n):
            size = np.full(len(terms), max(np.abs(second[:, i, j]).max(), min(sizes[i], sizes[j])))
            if i == j and names[i].startswith("force"):
                # Where a layer is taut the compliance is small, and shall be right there, too.
                size = np.maximum(np.abs(second[:, i, i]), LEAST * size)
            rows.append(columns([i, j]) * (SECOND / size * near)[:, None])
            right.append(second[:, i, j] * (SECOND / size * near))
    matrix = np.vstack(rows)
    matrix[:, (powers == 0).all(axis=1)] = 0.0
    size = np.linalg.norm(matrix, axis=0)
    size[size == 0] = 1.0
    constants, _, rank, _ = np.linalg.lstsq(matrix / size, np.concatenate(right), rcond=None)
    if rank < len(powers) - 1 or len(powers) > MOST * len(terms):
        raise ValueError(f"{len(terms)} states are too few for an energy of degree {degree}")
    return replace(basis, constants=constants / size)


def errors(energy: Energy, samples: Samples, largest: Array) -> Array:
    """Largest deviation (n,) of each first derivative, as a part of a largest value (n,)."""
    off = np.abs(energy.first(samples.places) - samples.first).max(axis=0)
    return np.asarray(off / np.where(largest > 0, largest, 1.0))


def weighted(energy: Energy, samples: Samples, largest: Array) -> Array:
    """The same (n,), of each state as much as it counts in a fit."""
    strains = sum(not name.startswith("pressure") for name in energy.names)
    off = np.abs(energy.first(samples.places) - samples.first)
    counted = (off * samples.weights(strains)[:, None]).max(axis=0)
    return np.asarray(counted / np.where(largest > 0, largest, 1.0))

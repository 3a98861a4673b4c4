"""A planar rod of equal pieces, each bent and stretched alike all along, under dead loads and
against obstacles without friction."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Places = NDArray[np.complex128]
POINTS, WEIGHTS = (half / 2 for half in np.polynomial.legendre.leggauss(12))
POINTS = POINTS + 0.5
STIFFNESSES = (1.0, 10.0, 100.0, 1000.0)  # N/mm, of an obstacle: the last one counts
STILL = 1e-10  # rad, or of the stretch: a Newton step below it is none
LARGEST = 0.2  # rad of a piece in one iteration
MOST = 60  # iterations
#: Signed distances (m,) of places (m,), their unit normals (m,) and curvatures across them (m,).
Distance = Callable[[Places], tuple[Array, Places, Array]]


class Law(Protocol):
    """Energy of a rod by its length in mJ/mm, as a function of curvature in 1/mm and stretch."""

    def energy(self, curvature: Array, stretch: Array) -> Array:
        """Of each of n pieces, (n,)."""

    def derivatives(self, curvature: Array, stretch: Array) -> tuple[Array, Array]:
        """Moment and force, shape (2, n), and their derivatives, shape (2, 2, n)."""


@dataclass(frozen=True)
class Linear:
    """A straight elastic rod: EI in N mm^2, EA in N."""

    bending: float
    axial: float

    def energy(self, curvature: Array, stretch: Array) -> Array:
        """As in Law."""
        return (self.bending * curvature**2 + self.axial * (stretch - 1) ** 2) / 2

    def derivatives(self, curvature: Array, stretch: Array) -> tuple[Array, Array]:
        """As in Law."""
        stiffness = np.diag([self.bending, self.axial])
        conjugates = np.stack([self.bending * curvature, self.axial * (stretch - 1)])
        return conjugates, np.repeat(stiffness[:, :, None], len(curvature), axis=2)


@dataclass(frozen=True)
class Points:
    """Points (m,) that the ends of pieces carry along: at the end of which piece, and where, beside
    it in its frame (along + i across), mm."""

    at: NDArray[np.int64]
    arms: Places

    @classmethod
    def ends(cls, pieces: int, arm: complex = 0.0) -> "Points":
        """One at each end."""
        return cls(np.arange(pieces), np.full(pieces, arm, dtype=complex))

    @classmethod
    def joined(cls, *parts: "Points") -> "Points":
        """All of several."""
        return cls(np.concatenate([p.at for p in parts]), np.concatenate([p.arms for p in parts]))


@dataclass(frozen=True)
class Loads:
    """Dead forces, N, on points; a moment, N mm, on the tip; obstacles, which some points may not
    enter."""

    points: Points
    forces: Places
    moment: float = 0.0
    touching: Points = field(default_factory=lambda: Points(np.empty(0, int), np.empty(0, complex)))
    obstacles: Sequence[Distance] = ()

    def part(self, part: float) -> "Loads":
        """The same, of forces and moment a part."""
        return Loads(
            self.points, part * self.forces, part * self.moment, self.touching, self.obstacles
        )


@dataclass(frozen=True)
class Rod:
    """Clamped at the origin, along x at first; no shear. Places are complex: x + i z, in mm."""

    law: Law
    pieces: int
    pitch: float

    def chords(self, angles: Array) -> tuple[Places, Places, Places]:
        """The mean of exp(i angle u) over u in 0 to 1, and its first two derivatives."""
        turned = np.exp(1j * np.outer(angles, POINTS))
        first, second, third = (WEIGHTS * (1j * POINTS) ** k for k in range(3))
        return turned @ first, turned @ second, turned @ third

    def steps(self, curvature: Array, stretch: Array) -> Places:
        """From the start of each piece to its end."""
        angles = curvature * self.pitch
        before = np.cumsum(angles) - angles
        return self.pitch * stretch * np.exp(1j * before) * self.chords(angles)[0]

    def places(self, curvature: Array, stretch: Array) -> Places:
        """Ends of the pieces, shape (pieces,)."""
        return np.cumsum(self.steps(curvature, stretch))

    def positions(self, strains: Array, points: Points) -> Places:
        """Of points, (m,)."""
        curvature, stretch = strains.reshape(2, self.pieces)
        turned = np.exp(1j * self.pitch * np.cumsum(curvature))
        return self.places(curvature, stretch)[points.at] + points.arms * turned[points.at]

    def slopes(self, strains: Array, points: Points) -> Places:
        """Derivatives of the positions by all (curvature, stretch), shape (m, 2 pieces)."""
        curvature, stretch = strains.reshape(2, self.pieces)
        zeroth, first, _ = self.chords(curvature * self.pitch)
        step = self.steps(curvature, stretch)
        ends = np.cumsum(step)
        carried = np.arange(self.pieces) <= points.at[:, None]
        levers = 1j * (self.positions(strains, points)[:, None] - ends) + step * first / zeroth
        return np.hstack([self.pitch * levers * carried, step / stretch * carried])

    def energy(self, strains: Array, loads: Loads, stiffness: float) -> float:
        """Potential energy, mJ: of the rod, of the forces, and of what enters obstacles."""
        curvature, stretch = strains.reshape(2, self.pieces)
        stored = self.pitch * self.law.energy(curvature, stretch).sum()
        places = self.positions(strains, loads.points)
        done = (np.conj(loads.forces) * places).real.sum()
        done += loads.moment * self.pitch * curvature.sum()
        touching = self.positions(strains, loads.touching)
        for distance in loads.obstacles:
            stored += stiffness / 2 * (np.minimum(distance(touching)[0], 0) ** 2).sum()
        return float(stored - done)

    def balance(
        self, strains: Array, loads: Loads, stiffness: float = STIFFNESSES[-1]
    ) -> tuple[Array, Array]:
        """Out-of-balance of all (curvature, stretch) and its symmetric derivative."""
        residual, tangent = self._inner(strains)
        found = [(loads.points, loads.forces)]
        if loads.obstacles:
            points = loads.touching
            slopes = self.slopes(strains, points)
            for distance in loads.obstacles:
                gaps, normals, curved = distance(self.positions(strains, points))
                pressed = stiffness * np.maximum(-gaps, 0)
                found.append((points, pressed * normals))
                across = (np.conj(normals)[:, None] * slopes).real[gaps < 0]
                along = (np.conj(1j * normals)[:, None] * slopes).real[gaps < 0]
                tangent += stiffness * across.T @ across
                tangent -= along.T @ ((pressed * curved)[gaps < 0, None] * along)
        for points, forces in found:
            pull, change = self._pulled(strains, points, forces)
            residual -= pull
            tangent -= change
        residual[: self.pieces] -= self.pitch * loads.moment
        return residual, tangent

    def pressed(self, strains: Array, loads: Loads) -> list[Places]:
        """Forces of each obstacle on the touching points, N."""
        places = self.positions(strains, loads.touching)
        found = []
        for distance in loads.obstacles:
            gaps, normals, _ = distance(places)
            found.append(STIFFNESSES[-1] * np.maximum(-gaps, 0) * normals)
        return found

    def _inner(self, strains: Array) -> tuple[Array, Array]:
        conjugates, stiffness = self.law.derivatives(*strains.reshape(2, self.pieces))
        tangent = np.block([[np.diag(self.pitch * part) for part in row] for row in stiffness])
        return self.pitch * conjugates.ravel(), tangent

    def _pulled(self, strains: Array, points: Points, forces: Places) -> tuple[Array, Array]:
        """What dead forces do on all (curvature, stretch), and its derivative."""
        n, pitch = self.pieces, self.pitch
        curvature, stretch = strains.reshape(2, n)
        zeroth, first, second = self.chords(curvature * pitch)
        turned = np.exp(1j * pitch * np.cumsum(curvature))
        at_ends, twisting = np.zeros(n, dtype=complex), np.zeros(n, dtype=complex)
        np.add.at(at_ends, points.at, np.conj(forces))
        np.add.at(twisting, points.at, np.conj(forces) * points.arms * turned[points.at])
        work = np.cumsum(at_ends[::-1])[::-1] * self.steps(curvature, stretch)
        beyond = np.cumsum((work + twisting)[::-1])[::-1] - work
        pull = np.concatenate(
            [pitch * (1j * beyond + work * first / zeroth).real, (work / stretch).real]
        )
        later = np.maximum.outer(np.arange(n), np.arange(n))
        bend = (-beyond + 1j * work * first / zeroth).real[later]
        np.fill_diagonal(bend, (-beyond + work * second / zeroth).real)
        mixed = np.triu(np.tile((1j * work / stretch).real, (n, 1)), 1)
        np.fill_diagonal(mixed, (work / stretch * first / zeroth).real)
        change = np.block([[pitch**2 * bend, pitch * mixed], [pitch * mixed.T, np.zeros((n, n))]])
        return pull, change

    def equilibrium(self, start: Array, loads: Loads, steps: int = 10) -> Array:
        """Curvatures and stretches, shape (2 pieces,), from those of no load.

        Raises ArithmeticError where there is no equilibrium.
        """
        strains = np.array(start, dtype=float)
        for part in np.linspace(0, 1, steps + 1)[1:]:
            strains = self.settle(strains, loads.part(part))
        return strains

    def settle(self, strains: Array, loads: Loads) -> Array:
        """The least energy near strains. Raises ArithmeticError where there is none."""
        for stiffness in STIFFNESSES if loads.obstacles else STIFFNESSES[-1:]:
            strains = self._newton(strains, loads, stiffness)
        return strains

    def _newton(self, strains: Array, loads: Loads, stiffness: float) -> Array:
        for _ in range(MOST):
            residual, tangent = self.balance(strains, loads, stiffness)
            change = _downhill(residual, tangent)
            size = self._size(change)
            if size < STILL:
                return strains + change
            change *= min(1.0, LARGEST / size)
            strains = self._lower(strains, change, float(residual @ change), loads, stiffness)
        raise ArithmeticError("the rod finds no equilibrium under these loads")

    def _size(self, change: Array) -> float:
        bent, stretched = np.abs(change.reshape(2, self.pieces)).max(axis=1)
        return float(max(self.pitch * bent, stretched))

    def _lower(
        self, strains: Array, change: Array, slope: float, loads: Loads, stiffness: float
    ) -> Array:
        """The longest part of a change that lowers the energy as its slope promises."""
        before = self.energy(strains, loads, stiffness)
        rounding = 1e-13 * abs(before)
        for part in 0.5 ** np.arange(20):
            moved = strains + part * change
            if self.energy(moved, loads, stiffness) <= before + 1e-4 * part * slope + rounding:
                return np.asarray(moved)
        return strains + change


def _downhill(residual: Array, tangent: Array) -> Array:
    """Newton's step, or where the tangent is indefinite that of its positive part."""
    try:
        np.linalg.cholesky(tangent)
    except np.linalg.LinAlgError:
        values, vectors = np.linalg.eigh(tangent)
        values = np.maximum(np.abs(values), 1e-8 * np.abs(values).max())
        return np.asarray(-vectors @ ((vectors.T @ residual) / values))
    return np.asarray(np.linalg.solve(tangent, -residual))

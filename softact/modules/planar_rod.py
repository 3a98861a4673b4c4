"""A planar rod of equal pieces, each bent and stretched alike all along, under dead loads."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Places = NDArray[np.complex128]
POINTS, WEIGHTS = (half / 2 for half in np.polynomial.legendre.leggauss(12))
POINTS = POINTS + 0.5


class Law(Protocol):
    """Energy of a rod by its length in mJ/mm, as a function of curvature in 1/mm and stretch."""

    def derivatives(self, curvature: Array, stretch: Array) -> tuple[Array, Array]:
        """Moment and force, shape (2, n), and their derivatives, shape (2, 2, n)."""


@dataclass(frozen=True)
class Linear:
    """A straight elastic rod: EI in N mm^2, EA in N."""

    bending: float
    axial: float

    def derivatives(self, curvature: Array, stretch: Array) -> tuple[Array, Array]:
        """As in Law."""
        stiffness = np.diag([self.bending, self.axial])
        conjugates = np.stack([self.bending * curvature, self.axial * (stretch - 1)])
        return conjugates, np.repeat(stiffness[:, :, None], len(curvature), axis=2)


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

    def balance(self, strains: Array, forces: Places, moment: float) -> tuple[Array, Array]:
        """Out-of-balance of all (curvature, stretch) and its symmetric derivative.

        `forces` in N act at the ends of the pieces, `moment` in N mm on the tip.
        """
        n, pitch = self.pieces, self.pitch
        curvature, stretch = strains.reshape(2, n)
        zeroth, first, second = self.chords(curvature * pitch)
        passed = np.conj(np.cumsum(forces[::-1])[::-1])
        work = passed * self.steps(curvature, stretch)
        beyond = np.cumsum(work[::-1])[::-1] - work
        conjugates, stiffness = self.law.derivatives(curvature, stretch)
        residual = pitch * conjugates
        residual[0] -= pitch * ((1j * beyond + work * first / zeroth).real + moment)
        residual[1] -= (work / stretch).real
        inner = (-beyond + 1j * work * first / zeroth).real
        later = np.maximum.outer(np.arange(n), np.arange(n))
        bend = inner[later]
        np.fill_diagonal(bend, (-beyond + work * second / zeroth).real)
        mixed = np.triu(np.tile((1j * work / stretch).real, (n, 1)), 1)
        np.fill_diagonal(mixed, (work / stretch * first / zeroth).real)
        tangent = np.block([[np.diag(pitch * part) for part in row] for row in stiffness])
        tangent -= np.block([[pitch**2 * bend, pitch * mixed], [pitch * mixed.T, np.zeros((n, n))]])
        return residual.ravel(), tangent

    def equilibrium(
        self, start: Array, forces: Places, moment: float = 0.0, steps: int = 10
    ) -> Array:
        """Curvatures and stretches, shape (2 pieces,), from those of no load.

        Raises ArithmeticError where Newton's method finds no equilibrium.
        """
        strains = np.array(start, dtype=float)
        for part in np.linspace(0, 1, steps + 1)[1:]:
            strains = self._newton(strains, part * forces, part * moment)
        return strains

    def _newton(self, strains: Array, forces: Places, moment: float) -> Array:
        for _ in range(30):
            residual, tangent = self.balance(strains, forces, moment)
            change = np.linalg.solve(tangent, -residual)
            strains = strains + change
            small = self.pitch * np.abs(change[: self.pieces]).max()
            if max(small, np.abs(change[self.pieces :]).max()) < 1e-11:
                return strains
        raise ArithmeticError("the rod finds no equilibrium under these loads")

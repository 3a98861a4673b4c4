"""Laws of the library in plane stress: the thickness stretch eliminated exactly.

In a sheet's plane C is (n, 2, 2); stress and moduli are S = 2 ∂W/∂C and D = 4 ∂²W/∂C∂C in the order
11, 22, 12 (tensor components), W per undeformed volume.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from softact.materials.base import Elastic, Law, Material
from softact.materials.laws.linear import Linear
from softact.materials.tensors import determinant, volumetric_response

IN_PLANE = [0, 1, 3]  # of Voigt's order 11, 22, 33, 12, 13, 23
THICKNESS = 2
MOST_ITERATIONS, TOLERANCE = 60, 1e-7  # quadratic: the step after is below 1e-14

Response = tuple[np.ndarray, np.ndarray, np.ndarray]


class SheetLaw(Protocol):
    """What a membrane asks of its material: W (n,), S (n, 3) and D (n, 3, 3) in MPa at C."""

    def evaluate(self, c: np.ndarray) -> Response: ...


class RememberedLaw(SheetLaw, Protocol):
    """A law in whose stress, before it is brought into the plane, a memory can step in."""

    def elastic(self, c: np.ndarray) -> Elastic:
        """The stress (n, k) that creeps and softens, its moduli (n, k, k), and the energy (n,)."""

    def in_plane(
        self, c: np.ndarray, stress: np.ndarray, moduli: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """S (n, 3) and D (n, 3, 3) in the plane of such a stress."""


class GreenLaw:
    """Plane-stress St. Venant-Kirchhoff, W = E/(2(1 − ν²)) ((1 − ν) E:E + ν (tr E)²) with the
    Green strain E: that of the facet layers."""

    def __init__(self, young: float, poisson: float):
        self.young, self.poisson = young, poisson
        a = young / (1 - poisson**2)
        self.moduli = a * np.array(
            [[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]], dtype=float
        )

    def evaluate(self, c: np.ndarray) -> Response:
        strain = (c[:, [0, 1, 0], [0, 1, 1]] - [1.0, 1.0, 0.0]) / 2
        stress = (strain * [1, 1, 2]) @ self.moduli
        energy = (stress * strain * [1, 1, 2]).sum(axis=1) / 2
        return energy, stress, np.broadcast_to(self.moduli, (len(c), 3, 3))

    def elastic(self, c: np.ndarray) -> Elastic:
        """See ``RememberedLaw``: in the plane."""
        energy, stress, moduli = self.evaluate(c)
        return stress, moduli, energy

    def in_plane(
        self, c: np.ndarray, stress: np.ndarray, moduli: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """See ``RememberedLaw``."""
        return stress, moduli


class SolidLaw:
    """A law of solids with S33 = 0. fibres: (n, families, 3) in the sheet's frame, or None."""

    def __init__(self, material: Material, fibres: np.ndarray | None = None):
        self.material, self.fibres = material, fibres

    def evaluate(self, c: np.ndarray) -> Response:
        """Newton's method for C33; not finite where it does not converge."""
        full = np.zeros((len(c), 3, 3))
        full[:, :2, :2] = c
        with np.errstate(all="ignore"):
            full[:, 2, 2] = 1 / np.linalg.det(c)
            for _ in range(MOST_ITERATIONS):
                stress, moduli = self._total(full)
                change = -2 * stress[:, THICKNESS] / moduli[:, THICKNESS, THICKNESS]
                old = full[:, 2, 2]
                full[:, 2, 2] = np.clip(old + change, 0.5 * old, 2.0 * old)
                if not np.any(np.abs(change) > TOLERANCE * np.abs(old)):
                    break
            stress, moduli = self._total(full)
            jacobian = np.sqrt(determinant(full))
            energy = (
                self.material.energy(full, self.fibres)
                + self.material.bulk_modulus * (jacobian - 1) ** 2 / 2
                + self.material.extra_volumetric(jacobian)[0]
            )
            coupling = moduli[:, IN_PLANE, THICKNESS]
            condensed = moduli[:, IN_PLANE][:, :, IN_PLANE] - (
                coupling[:, :, None]
                * coupling[:, None]
                / moduli[:, THICKNESS, THICKNESS][:, None, None]
            )
        return energy, stress[:, IN_PLANE], condensed

    def _total(self, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """S and D of W̄ + U(J)."""
        stress, moduli = self.material.stress_tangent(c, self.fibres)
        jacobian = np.sqrt(determinant(c))
        _, first, second = self.material.extra_volumetric(jacobian)
        first = first + self.material.bulk_modulus * (jacobian - 1)
        second = second + self.material.bulk_modulus
        more_stress, more_moduli = volumetric_response(_inverse(c), jacobian, first, second)
        return stress + more_stress, moduli + more_moduli


class IncompressibleLaw:
    """A law of solids at constant volume, C33 = 1/det C in the plane, and S33 = 0.

    With g(C) = C33 the energy is W̄(C, g(C)), and stress and moduli follow by the chain rule: no
    bulk modulus, no iterations and no rounding of its size. fibres: as of ``SolidLaw``.
    """

    def __init__(self, material: Material, fibres: np.ndarray | None = None):
        self.material, self.fibres = material, fibres

    def evaluate(self, c: np.ndarray) -> Response:
        """Not finite where det C ≤ 0."""
        stress, moduli, energy = self.elastic(c)
        assert energy is not None
        return energy, *self.in_plane(c, stress, moduli)

    def elastic(self, c: np.ndarray) -> Elastic:
        """See ``RememberedLaw``: isochoric, of all six components."""
        full = np.zeros((len(c), 3, 3))
        full[:, :2, :2] = c
        with np.errstate(all="ignore"):
            full[:, 2, 2] = _thickness(c)
            stress, moduli = self.material.stress_tangent(full, self.fibres)
            return stress, moduli, self.material.energy(full, self.fibres)

    def in_plane(
        self, c: np.ndarray, stress: np.ndarray, moduli: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """See ``RememberedLaw``."""
        with np.errstate(all="ignore"):
            g = _thickness(c)
            one, two, twelve = b = np.stack([c[:, 1, 1], c[:, 0, 0], -c[:, 0, 1]]) * g  # C⁻¹
            square = np.array(
                [
                    [one * one, twelve * twelve, one * twelve],
                    [twelve * twelve, two * two, two * twelve],
                    [one * twelve, two * twelve, (one * two + twelve * twelve) / 2],
                ]
            ).transpose(2, 0, 1)
            b = b.T
            rate = -g[:, None] * b  # ∂g/∂C
            curving = g[:, None, None] * (b[:, :, None] * b[:, None] + square)  # ∂²g/∂C∂C
            out = stress[:, THICKNESS]
            mixed = moduli[:, IN_PLANE, THICKNESS][:, :, None] * rate[:, None]
            condensed = (
                moduli[:, IN_PLANE][:, :, IN_PLANE]
                + mixed
                + mixed.transpose(0, 2, 1)
                + moduli[:, THICKNESS, THICKNESS][:, None, None] * rate[:, :, None] * rate[:, None]
                + 2 * out[:, None, None] * curving
            )
        return stress[:, IN_PLANE] + out[:, None] * rate, condensed


def _thickness(c: np.ndarray) -> np.ndarray:
    """C33 (n,) at constant volume; not a number where det C ≤ 0."""
    area = c[:, 0, 0] * c[:, 1, 1] - c[:, 0, 1] ** 2
    return np.where(area > 0, 1 / area, np.nan)


def _inverse(c: np.ndarray) -> np.ndarray:
    """Of symmetric (n, 3, 3); not finite where it is singular, as in a triangle that collapsed."""
    one, two, three = np.moveaxis(c, 1, 0)
    cofactors = np.cross(two, three), np.cross(three, one), np.cross(one, two)
    return np.stack(cofactors, axis=1) / determinant(c)[:, None, None]


def sheet_law(law: Law, fibres: np.ndarray | None = None, incompressible: bool = False) -> SheetLaw:
    """The plane-stress form of a law of the library; see ``SolidLaw`` for ``fibres``.

    incompressible: volume is constant, and the law's own bulk modulus does not count.
    """
    if isinstance(law, Linear):
        return GreenLaw(law.youngs_modulus, law.poissons_ratio)
    return (IncompressibleLaw if incompressible else SolidLaw)(law.material(), fibres)


def small_strain_constants(law: Law) -> tuple[float, float]:
    """Young's modulus (MPa) and Poisson's ratio of a law without its fibres, undeformed."""
    mu, k = law.shear_modulus, law.initial_bulk_modulus
    return 9 * k * mu / (3 * k + mu), (3 * k - 2 * mu) / (2 * (3 * k + mu))

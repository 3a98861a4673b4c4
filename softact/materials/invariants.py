"""Laws written in isochoric invariants: Ī1, Ī2 and, for fibres, Ī4 and Ī6.

The law gives one pure formula; its first and second derivatives in the invariants come from jets
and are turned here into stress and tangent (Holzapfel, Nonlinear Solid Mechanics, 2000, ch. 6).
"""

from typing import Any

import numpy as np

from softact.materials.base import Law, Material
from softact.materials.jets import Jet, Number, variables
from softact.materials.kernel import (
    PAIRS,
    Tangent,
    Tensor,
    by_chunks,
    components,
    contract,
    determinant,
    inverse,
    structure_tensors,
    sum_of_products,
    symmetric_square,
)


class InvariantLaw(Law):
    """A law with one formula ``strain_energy(k, i1, i2, *fibre invariants)``."""

    @staticmethod
    def strain_energy(k: Any, i1: Number, i2: Number, *fibre_invariants: Number) -> Number:
        """Return W̄ in MPa at the isochoric invariants; k holds the constants by name.

        The invariants are floats, arrays, jets or series alike.
        """
        raise NotImplementedError

    @property
    def shear_modulus(self) -> float:
        """2 (∂W/∂I1 + ∂W/∂I2) in the undeformed state, in MPa (fibres left out)."""
        with np.errstate(all="ignore"):
            energy = self.strain_energy(self, *variables(np.array([3.0]), np.array([3.0])))
        return float(2.0 * sum(np.sum(g) for g in energy.gradient if g is not None))

    def material(self) -> "InvariantMaterial":
        """Return what the solver evaluates."""
        return InvariantMaterial(self)


class InvariantMaterial(Material):
    """Stress and tangent of an invariant law."""

    law: InvariantLaw

    def __init__(self, law: InvariantLaw):
        super().__init__(law)

    def energy(self, C: np.ndarray, fibres: np.ndarray | None = None) -> np.ndarray:
        """See ``Material.energy``."""
        self.check_fibres(fibres)
        with np.errstate(all="ignore"):
            entries = components(np.asarray(C, dtype=float))
            families = structure_tensors(fibres, slice(None))
            scale = determinant(entries) ** (-1.0 / 3.0)
            trace = entries[0] + entries[1] + entries[2]
            second = _second_invariant(entries)
            linear = [scale * contract(M, entries) for M in families]
            result = self.law.strain_energy(
                self.law, scale * trace, scale * scale * second, *linear
            )
        return np.broadcast_to(result, trace.shape).copy()

    def stress_tangent(
        self, C: np.ndarray, fibres: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """See ``Material.stress_tangent``."""
        self.check_fibres(fibres)
        return by_chunks(C, fibres, self._points)

    def _points(self, C: Tensor, families: list[Tensor]) -> tuple[Tensor, Tangent]:
        det = determinant(C)
        B = np.stack(inverse(C, det))
        scale = det ** (-1.0 / 3.0)
        trace = C[0] + C[1] + C[2]
        values = [scale * trace, scale * scale * _second_invariant(C)]
        values += [scale * contract(M, C) for M in families]
        energy = self.law.strain_energy(self.law, *variables(*values))
        gradients = {
            k: _gradient(k, values[k], C, B, scale, trace, families)
            for k, first in enumerate(energy.gradient)
            if first is not None
        }
        return _assemble(energy, gradients, values, B, scale)


def _second_invariant(C: Tensor) -> np.ndarray:
    xx, yy, zz, xy, xz, yz = C
    return xx * yy + yy * zz + xx * zz - xy * xy - xz * xz - yz * yz


def _gradient(
    k: int,
    value: np.ndarray,
    C: Tensor,
    B: np.ndarray,
    scale: np.ndarray,
    trace: np.ndarray,
    families: list[Tensor],
) -> np.ndarray:
    """Derivative (6, m) of isochoric invariant k (0: Ī1, 1: Ī2, 2 and on: fibres) in C."""
    if k == 1:
        square = scale * scale
        result = (-2.0 / 3.0) * value * B
        whole = square * trace
        for a in range(6):
            result[a] -= square * C[a]
            if a < 3:
                result[a] += whole
        return result
    result = (-1.0 / 3.0) * value * B
    for a in range(6):
        if k:
            result[a] += scale * families[k - 2][a]
        elif a < 3:
            result[a] += scale
    return result


def _assemble(
    energy: Jet,
    gradients: dict[int, np.ndarray],
    values: list[np.ndarray],
    B: np.ndarray,
    scale: np.ndarray,
) -> tuple[Tensor, Tangent]:
    """Return S and D from the derivatives of W̄ and the gradients of the invariants.

    With m = 1 for invariants linear in C and m = 2 for Ī2, the Hessian of an isochoric invariant is
    −m/3 (g⊗B + B⊗g) − m²/9 Ī B⊗B + m/3 Ī B⊙B, for Ī2 also J^(−4/3) (1⊗1 − 𝟙); B = C⁻¹.
    """
    first = {k: 2.0 * g for k, g in enumerate(energy.gradient) if g is not None}
    order = {k: 2.0 if k == 1 else 1.0 for k in gradients}
    S = np.add.reduce([first[k] * g for k, g in gradients.items()])
    spherical = sum((2.0 / 3.0) * order[k] * first[k] * values[k] for k in gradients)
    half = sum((1.0 / 9.0) * order[k] ** 2 * first[k] * values[k] for k in gradients)
    P = half * B
    for k, g in gradients.items():
        P += (2.0 / 3.0) * order[k] * first[k] * g
    left, right = [-P, B], [B, -P]
    for (k, m), second in energy.hessian.items():
        weight = 4.0 * second
        left.append(weight * gradients[k])
        right.append(gradients[m])
        if k != m:
            left.append(weight * gradients[m])
            right.append(gradients[k])
    D = sum_of_products(np.stack(left), np.stack(right))
    for a, b in PAIRS:
        D[a, b] += spherical * symmetric_square(B, a, b)
    if first.get(1) is not None:
        w = 2.0 * first[1] * scale * scale
        for a, b in ((0, 1), (0, 2), (1, 2)):
            D[a, b] += w
        for a in (3, 4, 5):
            D[a, a] -= 0.5 * w
    return S, D

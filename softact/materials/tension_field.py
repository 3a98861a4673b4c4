"""Wrinkling by tension-field theory: the relaxed energy of a sheet that cannot be compressed.

A sheet without bending stiffness wrinkles finely instead of being compressed. Wrinkles add to the
metric C of its mean surface: what its material feels is C + a ⊗ a, and it chooses the a of least
energy, W_r(C) = min_a W(C + a ⊗ a) (Pipkin, IMA J. Appl. Math. 36 (1986) 85; 52 (1994) 297; for
anisotropic sheets Steigmann, Proc. R. Soc. A 429 (1990) 141). The stress S = 2 ∂W/∂C there has no
compression: a = 0 where both principal stresses are tensile (taut), S a = 0 with uniaxial tension
across a (wrinkled), and W_r = 0 where no stretch exceeds 1 (slack).
"""

from __future__ import annotations

import numpy as np

from softact.materials.plane_stress import IncompressibleLaw, Response, SheetLaw, SolidLaw

# Part of the unrelaxed energy that is kept, so that slack sheets keep a stiffness; of layers bonded
# to solids, where Newton's method does not settle with less (docs/performance.md).
KEPT, KEPT_BONDED = 1e-4, 1e-3
MOST_ITERATIONS = 60
# Of the stress across the folds: part of that along them, part of the moduli. What rounding makes
# of the energy: part of it, part of the moduli (laws of solids subtract numbers of their order).
TOLERANCE, FLOOR, ROUNDING, NOISE = 1e-10, 1e-13, 1e-7, 1e-14
TAUT, WRINKLED, SLACK = 0, 1, 2
# Component (i, j) of a symmetric tensor in the order 11, 22, 12.
PLACE = np.array([[0, 2], [2, 1]])


class TensionField:
    """The relaxed form of a law: (1 − kept) W_r + kept W."""

    def __init__(self, law: SheetLaw, poisson: float, kept: float = KEPT):
        self.law, self._poisson, self._kept = law, poisson, kept

    def evaluate(self, c: np.ndarray) -> Response:
        whole = self.law.evaluate(c)
        state = self._state(c, whole[1])
        energy, stress, moduli = (np.array(part) for part in whole)
        wrinkled, slack = state == WRINKLED, state == SLACK
        if wrinkled.any():
            relaxed = self._wrinkled(c, wrinkled)
            for part, values in zip((energy, stress, moduli), relaxed, strict=True):
                part[wrinkled] = values
        for part in (energy, stress, moduli):
            part[slack] = 0.0
        kept = self._kept
        energy, stress, moduli = (
            (1 - kept) * r + kept * w for r, w in zip((energy, stress, moduli), whole, strict=True)
        )
        return energy, stress, moduli

    def state(self, c: np.ndarray) -> np.ndarray:
        """TAUT, WRINKLED or SLACK (n,)."""
        return self._state(c, self.law.evaluate(c)[1])

    def _state(self, c: np.ndarray, stress: np.ndarray) -> np.ndarray:
        low, _ = _principal(stress)
        _, high = _principal(_components(c))
        return np.where(low >= 0, TAUT, np.where(high <= 1, SLACK, WRINKLED))

    def _wrinkled(self, c: np.ndarray, chosen: np.ndarray) -> Response:
        """W, S and condensed D at the a of least energy, by Newton's method; a point is evaluated
        until it has converged."""
        c, law = c[chosen], _part(self.law, chosen)
        a, count = self._first_guess(c), len(c)
        best, step = np.full(count, np.inf), np.zeros((count, 2))
        energy, stress, moduli = np.empty(count), np.empty((count, 3)), np.empty((count, 3, 3))
        left = np.arange(count)
        with np.errstate(all="ignore"):
            for _ in range(MOST_ITERATIONS):
                here = a[left]
                w, s, d = _part(law, left).evaluate(c[left] + here[:, :, None] * here[:, None])
                energy[left], stress[left], moduli[left] = w, s, d
                out, curvature, _ = _balance(here, s, d)
                across = np.hypot(*out.T) / np.hypot(*here.T)  # stress across the folds
                allowed = TOLERANCE * np.abs(s).max(axis=1) + FLOOR * d[:, 0, 0]
                worse = ~(w <= best[left] * (1 + ROUNDING) + NOISE * d[:, 0, 0])
                # Half of the last step back where the energy rose; along the gradient where the
                # energy is not convex, as it is not near a = 0.
                inverse, determinant = _inverse(curvature)
                newton = -(inverse @ out[:, :, None])[:, :, 0]
                down = -out / np.maximum(across, 1e-300)[:, None]
                ahead = np.where((determinant > 0)[:, None], newton, down)
                best[left] = np.where(worse, best[left], w)
                step[left] = np.where(worse[:, None], step[left] / 2, ahead)
                # Without an energy at its first guess a point has none anywhere.
                going = ~(across <= allowed) & np.isfinite(best[left])
                left, worse = left[going], worse[going]
                if not len(left):
                    break
                a[left] += np.where(worse[:, None], -step[left], step[left])
        _, curvature, coupling = _balance(a, stress, moduli)
        condensed = moduli - coupling @ _inverse(curvature)[0] @ coupling.transpose(0, 2, 1)
        return energy, stress, condensed

    def _first_guess(self, c: np.ndarray) -> np.ndarray:
        """Wrinkles along the smaller principal stretch that take up to its natural width."""
        values, vectors = np.linalg.eigh(c)
        natural = values[:, 1] ** -self._poisson
        lacking = np.maximum(natural - values[:, 0], 1e-8)
        return vectors[:, :, 0] * np.sqrt(lacking)[:, None]


def _components(c: np.ndarray) -> np.ndarray:
    """11, 22, 12 (n, 3) of symmetric tensors (n, 2, 2)."""
    return c[:, [0, 1, 0], [0, 1, 1]]


def _part(law: SheetLaw, chosen: np.ndarray) -> SheetLaw:
    """The law at some of its points: fibres belong to points."""
    if isinstance(law, SolidLaw | IncompressibleLaw) and law.fibres is not None:
        return type(law)(law.material, law.fibres[chosen])
    return law


def _balance(
    a: np.ndarray, stress: np.ndarray, moduli: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gradient S a (n, 2) and Hessian S + a·D·a (n, 2, 2) of the energy with respect to a; dS/da at
    constant C (n, 3, 2)."""
    tensor = stress[:, PLACE]
    rate = np.zeros((len(a), 3, 2))  # of a ⊗ a with respect to a, halved
    rate[:, 0, 0] = rate[:, 2, 1] = a[:, 0]
    rate[:, 1, 1] = rate[:, 2, 0] = a[:, 1]
    coupling = moduli @ rate
    out = (tensor @ a[:, :, None])[:, :, 0]
    return out, tensor + rate.transpose(0, 2, 1) @ coupling, coupling


def _inverse(h: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of symmetric (n, 2, 2), 0 where it is singular: there a = 0, and nothing is coupled; and the
    determinant."""
    a, b, d = h[:, 0, 0], h[:, 0, 1], h[:, 1, 1]
    det = a * d - b * b
    adjugate = np.stack([d, -b, -b, a], axis=1).reshape(-1, 2, 2)
    factor = np.where(det == 0.0, 0.0, 1 / np.where(det == 0.0, 1.0, det))
    return factor[:, None, None] * adjugate, det


def _principal(s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Smaller and larger principal value of symmetric tensors (n, 3)."""
    mean, half = (s[:, 0] + s[:, 1]) / 2, (s[:, 0] - s[:, 1]) / 2
    radius = np.hypot(half, s[:, 2])
    return mean - radius, mean + radius

"""Many rigid motions at once: a turn and a shift as one vector, and their exponential.

A motion is (R, x): it takes a place y to R y + x. A screw ξ = (ω, v), shape (..., 6), gives the
motion exp ξ = (exp [ω]×, V(ω) v): what a rod does that is bent and stretched alike all along.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softact.system.rotation import cross_with

Array = NDArray[np.float64]
#: B₂ₖ / (2k)! of the series of the inverse of the exponential's derivative, k = 1 to 6: exact to
#: 1e-11 for turns of up to 1 rad.
EVEN = (1 / 12, -1 / 720, 1 / 30240, -1 / 1209600, 1 / 47900160, -691 / 1307674368000)
SMALL = 1e-4  # rad
TERMS = 3  # of EVEN in the tangent: 1e-8 at 0.5 rad


def exponential(screws: Array) -> tuple[Array, Array]:
    """R (..., 3, 3) and x (..., 3)."""
    turn = cross_with(screws[..., :3])
    square = turn @ turn
    angle = np.linalg.norm(screws[..., :3], axis=-1)[..., None, None]
    safe = np.maximum(angle, SMALL)
    small = angle < SMALL
    one = np.where(small, 1 - angle**2 / 6, np.sin(safe) / safe)
    two = np.where(small, 0.5 - angle**2 / 24, (1 - np.cos(safe)) / safe**2)
    three = np.where(small, 1 / 6 - angle**2 / 120, (safe - np.sin(safe)) / safe**3)
    mean = np.eye(3) + two * turn + three * square
    return np.eye(3) + one * turn + two * square, np.einsum("...ij,...j", mean, screws[..., 3:])


def logarithm(turns: Array, shifts: Array) -> Array:
    """The screw (..., 6) of a motion that turns by less than half a turn."""
    skew = np.stack(
        [
            turns[..., 2, 1] - turns[..., 1, 2],
            turns[..., 0, 2] - turns[..., 2, 0],
            turns[..., 1, 0] - turns[..., 0, 1],
        ],
        axis=-1,
    )
    sine = np.linalg.norm(skew, axis=-1) / 2
    angle = np.arctan2(sine, (np.trace(turns, axis1=-2, axis2=-1) - 1) / 2)
    small = sine < SMALL
    factor = np.where(small, 1 + angle**2 / 6, angle / np.where(small, 1.0, sine))
    vector = skew / 2 * factor[..., None]
    safe = np.where(small, 1.0, angle)
    lacking = np.where(small, 1 / 12 + angle**2 / 720, (1 - safe / 2 / np.tan(safe / 2)) / safe**2)
    turn = cross_with(vector)
    inverse = np.eye(3) - turn / 2 + lacking[..., None, None] * (turn @ turn)
    return np.concatenate([vector, np.einsum("...ij,...j", inverse, shifts)], axis=-1)


def adjoints(screws: Array) -> Array:
    """Matrices (..., 6, 6) of the bracket with a screw: η -> (ω × θ, ω × u + v × θ)."""
    out = np.zeros((*screws.shape, 6))
    turn = cross_with(screws[..., :3])
    out[..., :3, :3] = out[..., 3:, 3:] = turn
    out[..., 3:, :3] = cross_with(screws[..., 3:])
    return out


def pulled(wrenches: Array) -> Array:
    """Matrices (..., 6, 6) of ξ -> ad(ξ)ᵀ f, of wrenches (moment, force) (..., 6)."""
    out = np.zeros((*wrenches.shape, 6))
    moment, force = cross_with(wrenches[..., :3]), cross_with(wrenches[..., 3:])
    out[..., :3, :3], out[..., :3, 3:], out[..., 3:, :3] = moment, force, force
    return out


class Between:
    """What the screws (n, 6) between pairs of frames change with these frames.

    Each frame moves by a screw in its own axes: η₁ at the start, η₂ at the end. To first order the
    screw changes by ``at_start`` η₁ + ``at_end`` η₂, matrices (n, 6, 6): the inverse of the
    exponential's derivative, ±½ ad + 1 + ad²/12 − ad⁴/720 + ...
    """

    def __init__(self, screws: Array):
        self._bracket = adjoints(screws)
        square = self._bracket @ self._bracket
        even, power = np.eye(6), np.eye(6)
        for factor in EVEN:
            power = power @ square
            even = even + factor * power
        self.at_start = -even + self._bracket / 2
        self.at_end = even + self._bracket / 2

    def second(self, wrenches: Array) -> tuple[Array, Array]:
        """Derivatives (n, 6, 6) of at_startᵀ f and at_endᵀ f by the screws, with f held."""
        back = np.swapaxes(self._bracket, -1, -2)
        powers = [wrenches[..., None]]
        for _ in range(2 * TERMS - 1):
            powers.append(back @ powers[-1])
        first, *rest = pulled(np.array(powers)[..., 0])
        half, part, even = first / 2, first, np.zeros_like(first)
        # The derivative of backᵐ f: each of its factors in turn.
        for m, next_one in enumerate(rest, 2):
            part = next_one + back @ part
            if m % 2 == 0:
                even = even + EVEN[m // 2 - 1] * part
        return half - even, half + even

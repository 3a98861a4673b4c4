"""Closed-form nominal stress of a law in the homogeneous incompressible modes of a test.

A mode is a path λ -> (λ^a, λ^b, λ^c); the stress is the derivative of the law's own energy along
it. Fibre laws are evaluated in the plane of the sheet, with the stretch across a uniaxial test
solved for.
"""

import operator
from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce

import numpy as np
from scipy.optimize import brentq

from softact.fit.candidates import Constants
from softact.materials import Law
from softact.materials.invariants import InvariantLaw
from softact.materials.jets import Exponential, Jet, Series, variables
from softact.materials.stretches import StretchLaw


@dataclass(frozen=True)
class Mode:
    """A homogeneous incompressible deformation.

    powers: exponents of the three principal stretches λ^exponent. pairs: how many principal
    directions carry the stress. across: exponent of the in-plane stretch normal to λ, None where
    it is free.
    """

    name: str
    powers: tuple[float, float, float]
    pairs: int
    across: float | None


MODES = {
    mode.name: mode
    for mode in (
        Mode("uniaxial", (1.0, -0.5, -0.5), 1, None),
        Mode("equibiaxial", (1.0, 1.0, -2.0), 2, 1.0),
        Mode("planar", (1.0, 0.0, -1.0), 1, 0.0),
    )
}
DIRECTIONS = ("course", "wale")


def nominal_stress(
    law: type[Law] | Law, k: Constants, mode: str, stretch: np.ndarray
) -> np.ndarray:
    """Return the nominal stress (n,) in MPa of an isotropic law.

    law: the law or its class. k: the constants by name. stretch: (n,). A stretch beyond a locking
    law's limit gives a value that is not finite.
    """
    path = MODES[mode]
    powers = np.array(path.powers)[:, None]
    return path_stress(law, k, powers, path.pairs, np.asarray(stretch, dtype=float))


def path_stress(
    law: type[Law] | Law,
    k: Constants,
    powers: np.ndarray,
    pairs: np.ndarray | int,
    stretch: np.ndarray,
) -> np.ndarray:
    """Return the nominal stress (n,) in MPa along paths λ -> λ^powers.

    powers: (3, n) or (3, 1). pairs: (n,) or a number. Points of several modes go in one call.
    """
    kind = _class_of(law)
    with np.errstate(all="ignore"):
        log = np.log(stretch)
        principal = Exponential(log, powers + 0.0 * log)
        if issubclass(kind, StretchLaw):
            slope = kind.stretch_energy(k, principal).terms[1].sum(axis=0)
        else:
            first, second = (_trace(principal**power) for power in (2.0, -2.0))
            slope = kind.strain_energy(k, first, second).terms[1]
        return slope / (pairs * stretch)


def _trace(squares: Series) -> Series:
    return Series(*(term.sum(axis=0) for term in squares.terms))


def first_invariant(mode: str, stretch: np.ndarray | float) -> np.ndarray:
    """Return Ī1 (n,) along a mode."""
    s = np.asarray(stretch, dtype=float)
    a, b, c = (2 * power for power in MODES[mode].powers)
    return s**a + s**b + s**c


def stretch_reaching(mode: str, invariant: float, side: float) -> float:
    """Return the stretch with Ī1 = ``invariant`` on the side of 1 where ``side`` lies."""
    end = 1e3 if side > 1.0 else 1e-3
    return float(brentq(lambda s: first_invariant(mode, s) - invariant, 1.0, end))


def _class_of(law: type[Law] | Law) -> type[StretchLaw] | type[InvariantLaw]:
    """The class that has the law's formula."""
    kind = law if isinstance(law, type) else type(law)
    if issubclass(kind, StretchLaw) or issubclass(kind, InvariantLaw):
        return kind
    raise TypeError(f"{kind.__name__}: a formula in stretches or in invariants is wanted")


def _fibres(k: Constants) -> tuple[float, int]:
    """Angle (degrees) and number of the fibre families of a law that has some."""
    by_name = vars(k)
    return by_name["angle"], by_name["families"]


def sheet_energy(
    law: type[Law] | Law, k: Constants, logarithms: tuple[np.ndarray, np.ndarray]
) -> Jet:
    """Return W̄ of an incompressible sheet as a jet in the logarithmic stretches ε1, ε2 (n,) each.

    The gradient holds the Cauchy stresses σ1, σ2 in plane stress, in MPa; the Hessian is Drucker's
    matrix. Fibres lie in the sheet at ± the constant ``angle`` to direction 1.
    """
    kind = _class_of(law)
    x, y = variables(*(np.asarray(e, dtype=float) for e in logarithms))
    a, b, c = np.exp(x), np.exp(y), np.exp(-x - y)
    if issubclass(kind, StretchLaw):
        return reduce(operator.add, (kind.stretch_energy(k, stretch) for stretch in (a, b, c)))
    squares = [stretch * stretch for stretch in (a, b, c)]
    fibres = []
    if kind.anisotropic:
        angle, families = _fibres(k)
        cosine, sine = np.cos(np.radians(angle)) ** 2, np.sin(np.radians(angle)) ** 2
        fibres = [cosine * squares[0] + sine * squares[1]] * families
    i1, i2 = reduce(operator.add, squares), reduce(operator.add, (1.0 / s for s in squares))
    return kind.strain_energy(k, i1, i2, *fibres)


def sheet_stress(
    law: type[Law] | Law,
    k: Constants,
    mode: str,
    direction: str,
    stretch: np.ndarray,
    other: np.ndarray | None = None,
) -> np.ndarray:
    """Return the nominal stress (n,) in MPa along ``direction`` of a sheet with fibres.

    direction: 'course' is direction 1, from which the fibre angle counts, 'wale' is direction 2.
    stretch: along ``direction``. other: stretch across it, for the mode 'biaxial' only.
    """
    log = np.log(np.asarray(stretch, dtype=float))
    along = DIRECTIONS.index(direction)

    def energy(across: np.ndarray) -> Jet:
        pair = (log, across) if along == 0 else (across, log)
        return sheet_energy(law, k, pair)

    with np.errstate(all="ignore"):
        if mode == "biaxial":
            across = np.log(np.asarray(other, dtype=float))
        elif (power := MODES[mode].across) is not None:
            across = power * log
        else:
            across = _free_stretch(energy, log, 1 - along)
        return np.broadcast_to(energy(across).gradient[along] / np.exp(log), log.shape).copy()


def _free_stretch(energy: Callable[[np.ndarray], Jet], log: np.ndarray, normal: int) -> np.ndarray:
    """Logarithmic stretch across a uniaxial test, where the stress across is zero (Newton)."""
    across = -0.5 * log
    for _ in range(60):
        state = energy(across)
        step = state.gradient[normal] / np.maximum(state.hessian[normal, normal], 1e-300)
        across = across - np.clip(step, -0.2, 0.2)
        if not np.any(np.abs(step) > 1e-13):
            break
    return across

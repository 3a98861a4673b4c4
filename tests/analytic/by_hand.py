"""Derivatives of every law's energy, written by hand from its formula.

Principal stretches λi have the product 1. The tests derive their closed forms from these and
compare them with the library, which differentiates the formula by itself.
"""

from types import SimpleNamespace

import numpy as np


def _arruda_boyce(k, i1, i2):
    factors = (1 / 2, 1 / 20, 11 / 1050, 19 / 7000, 519 / 673750)
    terms = [
        c * n * i1 ** (n - 1) / k.lambda_m ** (2 * n - 2) for n, c in enumerate(factors, start=1)
    ]
    return k.mu * sum(terms), 0.0


def _van_der_waals(k, i1, i2):
    locking = k.lambda_m**2 - 3
    mixed = (1 - k.beta) * i1 + k.beta * i2
    eta = np.sqrt((mixed - 3) / locking)
    # ∂/∂Ĩ of μ (−L (ln(1 − η) + η) − ⅔ a ((Ĩ − 3)/2)^(3/2)) with L η² = Ĩ − 3
    slope = k.mu * (0.5 / (1 - eta) - k.a * 0.5 * np.sqrt((mixed - 3) / 2))
    return (1 - k.beta) * slope, k.beta * slope


# law -> (∂W/∂I1, ∂W/∂I2) in MPa with the constants k at I1, I2
INVARIANT_LAWS = {
    "neo_hookean": lambda k, i1, i2: (k.c10, 0.0),
    "mooney_rivlin": lambda k, i1, i2: (k.c10, k.c01),
    "yeoh": lambda k, i1, i2: (k.c10 + 2 * k.c20 * (i1 - 3), 0.0),
    "reduced_polynomial": lambda k, i1, i2: (
        k.c10 + 2 * k.c20 * (i1 - 3) + 4 * k.c40 * (i1 - 3) ** 3,
        0.0,
    ),
    "arruda_boyce": _arruda_boyce,
    "van_der_waals": _van_der_waals,
    "gent": lambda k, i1, i2: (k.mu / 2 / (1 - (i1 - 3) / k.jm), 0.0),
    "fung": lambda k, i1, i2: (k.mu / 2 * np.exp(k.b * (i1 - 3)), 0.0),
}
# law -> λ f'(λ) in MPa of W = Σ f(λi)
STRETCH_LAWS = {
    "ogden": lambda k, s: sum(2 * m / a * s**a for m, a in zip(k.mu, k.alpha, strict=True)),
    "linear": lambda k, s: 2 * k.youngs_modulus / 3 * np.log(s),  # 2 μ ln λ with μ = E/3
}


def _holzapfel(k, stretches):
    """Fibres at ± the angle to direction 1 in the plane of 1 and 2, which they must not turn.

    Ī4 = λ1² cos² + λ2² sin²; a family carries 2 ψ' where E > 0, with ψ' = k1 E exp(k2 E²).
    """
    squares = np.array(stretches) ** 2
    shares = np.array([np.cos(np.radians(k.angle)) ** 2, np.sin(np.radians(k.angle)) ** 2, 0.0])
    strain = k.kappa * (squares.sum() - 3) + (1 - 3 * k.kappa) * (shares @ squares - 1)
    slope = k.families * k.k1 * max(strain, 0.0) * np.exp(k.k2 * strain**2)
    return list(2 * squares * (k.c10 + slope * (k.kappa + (1 - 3 * k.kappa) * shares)))


def principal_slopes(law: str, constants: dict, stretches) -> list:
    """λi ∂W/∂λi in MPa at three principal stretches whose product is 1.

    For a law of the invariants 2 (λi² ∂W/∂I1 − λi⁻² ∂W/∂I2) (Rivlin 1948): the derivatives of
    I2 = Σ λi⁻². Their differences are those of the Cauchy stresses.
    """
    k = SimpleNamespace(**constants)
    if law == "holzapfel":
        return _holzapfel(k, stretches)
    if law in STRETCH_LAWS:
        return [STRETCH_LAWS[law](k, s) for s in stretches]
    squares = [s**2 for s in stretches]
    w1, w2 = INVARIANT_LAWS[law](k, sum(squares), sum(1 / c for c in squares))
    return [2 * (c * w1 - w2 / c) for c in squares]

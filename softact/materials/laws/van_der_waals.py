"""Van der Waals (Kilian) law."""

from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from softact.materials.invariants import InvariantLaw
from softact.materials.jets import Number, at_least
from softact.units import Dimensionless, Pressure

# The second derivative grows like 1/sqrt(Ĩ − 3) while the stress stays finite: evaluate the
# undeformed state at a stretch of 1 + 6e-7.
LOWEST = 1e-12


class VanDerWaals(InvariantLaw):
    """W̄ = μ (−(λm² − 3)(ln(1 − η) + η) − ⅔ a ((Ĩ − 3)/2)^(3/2)), Ĩ = (1 − β) Ī1 + β Ī2."""

    formula: ClassVar[str] = (
        "W̄ = μ (−(λm² − 3)(ln(1 − η) + η) − ⅔ a ((Ĩ − 3)/2)^(3/2)) with "
        "Ĩ = (1 − β) Ī1 + β Ī2, η = √((Ĩ − 3)/(λm² − 3))"
    )
    reference: ClassVar[str] = (
        "Kilian 1981, Polymer 22:209; Kilian, Enderle, Unseld 1986, Colloid Polym. Sci. 264:866; "
        "as in Abaqus"
    )
    use: ClassVar[str] = (
        "Four constants with a meaning: locking stretch, interaction of the chains, mixture of the "
        "invariants. Needs β = 0 where only one mode was tested. No value beyond λm. "
        "Volumetric energy K/2 ((J² − 1)/2 − ln J)."
    )
    logarithmic_volume: ClassVar[bool] = True

    law: Literal["van_der_waals"] = "van_der_waals"
    mu: Pressure = Field(gt=0, description="initial shear modulus")
    lambda_m: Dimensionless = Field(gt=3**0.5, description="locking stretch, above √3")
    a: Dimensionless = Field(default=0.0, description="global interaction of the chains")
    beta: Dimensionless = Field(default=0.0, ge=0, le=1, description="share of Ī2 in Ĩ")

    @staticmethod
    def strain_energy(k: Any, i1: Number, i2: Number) -> Number:
        """See ``InvariantLaw.strain_energy``."""
        mixed = i1 if k.beta == 0.0 else (1.0 - k.beta) * i1 + k.beta * i2
        x = at_least(mixed - 3.0, LOWEST)
        locking = k.lambda_m**2 - 3.0
        eta = np.sqrt(x / locking)
        chain = -locking * (np.log(1.0 - eta) + eta)
        return k.mu * (chain - (2.0 / 3.0) * k.a * (0.5 * x) ** 1.5)

"""Fung's exponential law in its isotropic form."""

from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from softact.materials.invariants import InvariantLaw
from softact.materials.jets import Number
from softact.units import Dimensionless, Pressure


class Fung(InvariantLaw):
    """W̄ = μ/(2b) (exp(b (Ī1 − 3)) − 1)."""

    formula: ClassVar[str] = "W̄ = μ/(2b) (exp(b (Ī1 − 3)) − 1)"
    reference: ClassVar[str] = (
        "Fung 1967, Am. J. Physiol. 213:1532; isotropic: Demiray 1972, J. Biomech. 5:309"
    )
    use: ClassVar[str] = (
        "Two constants, stable at any stretch: tissue, and silicones that stiffen exponentially "
        "without a locking stretch. b near 0 is neo-Hookean; μ/(2b) is also written C1 or a/(2b), "
        "b also C2."
    )

    law: Literal["fung"] = "fung"
    mu: Pressure = Field(gt=0, description="initial shear modulus")
    b: Dimensionless = Field(gt=0, description="rate of the stiffening")

    @staticmethod
    def strain_energy(k: Any, i1: Number, i2: Number) -> Number:
        """See ``InvariantLaw.strain_energy``."""
        # expm1 keeps the digits where b (Ī1 − 3) is small.
        return (0.5 * k.mu / k.b) * np.expm1(k.b * (i1 - 3.0))

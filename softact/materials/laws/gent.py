"""Gent law."""

from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from softact.materials.invariants import InvariantLaw
from softact.materials.jets import Number
from softact.units import Dimensionless, Pressure


class Gent(InvariantLaw):
    """W̄ = −μ Jm/2 ln(1 − (Ī1 − 3)/Jm)."""

    formula: ClassVar[str] = "W̄ = −μ Jm/2 ln(1 − (Ī1 − 3)/Jm)"
    reference: ClassVar[str] = "Gent 1996, Rubber Chem. Technol. 69:59"
    use: ClassVar[str] = (
        "Two constants, stable, with a sharp locking stretch where Ī1 = 3 + Jm; the law has no "
        "value beyond it and the solver cuts the step back there."
    )

    law: Literal["gent"] = "gent"
    mu: Pressure = Field(gt=0, description="initial shear modulus")
    jm: Dimensionless = Field(gt=0, description="largest value of Ī1 − 3")

    @staticmethod
    def strain_energy(k: Any, i1: Number, i2: Number) -> Number:
        """See ``InvariantLaw.strain_energy``."""
        return (-0.5 * k.mu * k.jm) * np.log(1.0 - (i1 - 3.0) / k.jm)

"""Yeoh law."""

from typing import Any, ClassVar, Literal

from pydantic import Field

from softact.materials.invariants import InvariantLaw
from softact.materials.jets import Number
from softact.units import Pressure


class Yeoh(InvariantLaw):
    """W̄ = C10 (Ī1 − 3) + C20 (Ī1 − 3)² + C30 (Ī1 − 3)³."""

    formula: ClassVar[str] = "W̄ = C10 (Ī1 − 3) + C20 (Ī1 − 3)² + C30 (Ī1 − 3)³"
    reference: ClassVar[str] = "Yeoh 1993, Rubber Chem. Technol. 66:754"
    use: ClassVar[str] = (
        "The first choice with a uniaxial test only: it needs no Ī2, predicts the other modes "
        "fairly and follows stiffening. Do not use it beyond the test where C30 < 0."
    )

    law: Literal["yeoh"] = "yeoh"
    c10: Pressure = Field(description="half the initial shear modulus")
    c20: Pressure = Field(default=0.0, description="factor of (Ī1 − 3)²; negative: softening")
    c30: Pressure = Field(default=0.0, description="factor of (Ī1 − 3)³; positive: stiffening")

    @staticmethod
    def strain_energy(k: Any, i1: Number, i2: Number) -> Number:
        """See ``InvariantLaw.strain_energy``."""
        x = i1 - 3.0
        return x * (k.c10 + x * (k.c20 + x * k.c30))

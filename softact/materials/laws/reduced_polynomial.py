"""Reduced polynomial law of order 1 to 6."""

from typing import Any, ClassVar, Literal

from pydantic import Field

from softact.materials.invariants import InvariantLaw
from softact.materials.jets import Number
from softact.units import Pressure

ORDER = 6


class ReducedPolynomial(InvariantLaw):
    """W̄ = Σ Ci0 (Ī1 − 3)^i with i <= 6. Order 1 is neo-Hookean, order 3 is Yeoh."""

    formula: ClassVar[str] = "W̄ = Σ Ci0 (Ī1 − 3)^i, 1 ≤ i ≤ 6"
    reference: ClassVar[str] = "Yeoh 1993; Abaqus Theory Guide, Hyperelastic material behavior"
    use: ClassVar[str] = (
        "Where Yeoh's three terms do not follow the curve. Orders above 3 tend to oscillate and "
        "lose stability just outside the test."
    )

    law: Literal["reduced_polynomial"] = "reduced_polynomial"
    c10: Pressure = Field(description="half the initial shear modulus")
    c20: Pressure = Field(default=0.0, description="factor of (Ī1 − 3)²")
    c30: Pressure = Field(default=0.0, description="factor of (Ī1 − 3)³")
    c40: Pressure = Field(default=0.0, description="factor of (Ī1 − 3)⁴")
    c50: Pressure = Field(default=0.0, description="factor of (Ī1 − 3)⁵")
    c60: Pressure = Field(default=0.0, description="factor of (Ī1 − 3)⁶")

    @staticmethod
    def strain_energy(k: Any, i1: Number, i2: Number) -> Number:
        """See ``InvariantLaw.strain_energy``."""
        x = i1 - 3.0
        factors = [getattr(k, f"c{i}0") for i in range(1, ORDER + 1)]
        while len(factors) > 1 and factors[-1] == 0.0:
            factors.pop()
        energy = factors.pop() * x
        while factors:
            energy = x * (energy + factors.pop())
        return energy

"""Mooney-Rivlin law: the polynomial form with 2, 3, 5 or 9 constants."""

from typing import Any, ClassVar, Literal

from pydantic import Field

from softact.materials.invariants import InvariantLaw
from softact.materials.jets import Number
from softact.units import Pressure

POWERS = {
    "c10": (1, 0), "c01": (0, 1),
    "c20": (2, 0), "c11": (1, 1), "c02": (0, 2),
    "c30": (3, 0), "c21": (2, 1), "c12": (1, 2), "c03": (0, 3),
}  # fmt: skip


class MooneyRivlin(InvariantLaw):
    """W̄ = Σ Cij (Ī1 − 3)^i (Ī2 − 3)^j with i + j <= 3."""

    formula: ClassVar[str] = "W̄ = Σ Cij (Ī1 − 3)^i (Ī2 − 3)^j, 1 ≤ i + j ≤ 3"
    reference: ClassVar[str] = "Mooney 1940; Rivlin and Saunders 1951"
    use: ClassVar[str] = (
        "Two constants where tests in two modes exist: one mode tells C10 from C01 poorly, planar "
        "tension not at all. "
        "Five and nine constants follow S-shaped curves but are often unstable outside the test."
    )

    law: Literal["mooney_rivlin"] = "mooney_rivlin"
    c10: Pressure = Field(description="factor of (Ī1 − 3)")
    c01: Pressure = Field(default=0.0, description="factor of (Ī2 − 3)")
    c20: Pressure = Field(default=0.0, description="factor of (Ī1 − 3)²")
    c11: Pressure = Field(default=0.0, description="factor of (Ī1 − 3)(Ī2 − 3)")
    c02: Pressure = Field(default=0.0, description="factor of (Ī2 − 3)²")
    c30: Pressure = Field(default=0.0, description="factor of (Ī1 − 3)³")
    c21: Pressure = Field(default=0.0, description="factor of (Ī1 − 3)²(Ī2 − 3)")
    c12: Pressure = Field(default=0.0, description="factor of (Ī1 − 3)(Ī2 − 3)²")
    c03: Pressure = Field(default=0.0, description="factor of (Ī2 − 3)³")

    @staticmethod
    def strain_energy(k: Any, i1: Number, i2: Number) -> Number:
        """See ``InvariantLaw.strain_energy``."""
        x, y = i1 - 3.0, i2 - 3.0
        energy = k.c10 * x
        for name, (i, j) in POWERS.items():
            factor = getattr(k, name)
            if name == "c10" or factor == 0.0:
                continue
            term = x**i if j == 0 else y**j if i == 0 else x**i * y**j
            energy = energy + factor * term
        return energy

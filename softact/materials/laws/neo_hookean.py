"""Neo-Hookean law."""

from typing import Any, ClassVar, Literal

from pydantic import Field

from softact.materials.invariants import InvariantLaw
from softact.materials.jets import Number
from softact.units import Pressure


class NeoHookean(InvariantLaw):
    """W̄ = C10 (Ī1 − 3)."""

    formula: ClassVar[str] = "W̄ = C10 (Ī1 − 3)"
    reference: ClassVar[str] = "Rivlin 1948; Treloar 1943 (Gaussian chain network)"
    use: ClassVar[str] = (
        "One constant from a modulus alone (C10 = E/6). Good to a stretch of about 1.4; misses "
        "the stiffening of elastomers beyond it."
    )

    law: Literal["neo_hookean"] = "neo_hookean"
    c10: Pressure = Field(description="half the shear modulus")

    @staticmethod
    def strain_energy(k: Any, i1: Number, i2: Number) -> Number:
        """See ``InvariantLaw.strain_energy``."""
        return k.c10 * (i1 - 3.0)

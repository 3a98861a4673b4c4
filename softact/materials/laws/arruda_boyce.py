"""Arruda-Boyce law (eight-chain network), in its series form."""

from typing import Any, ClassVar, Literal

from pydantic import Field

from softact.materials.invariants import InvariantLaw
from softact.materials.jets import Number
from softact.units import Dimensionless, Pressure

# Of the inverse Langevin function (Arruda and Boyce 1993, eq. 12).
SERIES = (1 / 2, 1 / 20, 11 / 1050, 19 / 7000, 519 / 673750)


class ArrudaBoyce(InvariantLaw):
    """W̄ = μ Σ Ci / λm^(2i−2) (Ī1^i − 3^i)."""

    formula: ClassVar[str] = (
        "W̄ = μ Σ Ci / λm^(2i−2) (Ī1^i − 3^i), C = 1/2, 1/20, 11/1050, 19/7000, 519/673750"
    )
    reference: ClassVar[str] = "Arruda and Boyce 1993, J. Mech. Phys. Solids 41:389; as in Abaqus"
    use: ClassVar[str] = (
        "Two constants with a physical meaning, stable everywhere, fair in all modes from a "
        "uniaxial test. Does not follow the early softening of filled rubber. "
        "Volumetric energy K/2 ((J² − 1)/2 − ln J)."
    )
    logarithmic_volume: ClassVar[bool] = True

    law: Literal["arruda_boyce"] = "arruda_boyce"
    mu: Pressure = Field(gt=0, description="modulus; the initial shear modulus is a little larger")
    lambda_m: Dimensionless = Field(gt=1, description="locking stretch of the chains")

    @staticmethod
    def strain_energy(k: Any, i1: Number, i2: Number) -> Number:
        """See ``InvariantLaw.strain_energy``."""
        energy = 0.0
        for factor in reversed(SERIES):
            i = SERIES.index(factor) + 1
            energy = energy + factor / k.lambda_m ** (2 * i - 2) * (i1**i - 3.0**i)
        return k.mu * energy

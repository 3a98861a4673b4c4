"""Linear elasticity for stiff parts, made safe under large rotation."""

from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from softact.materials.jets import Number
from softact.materials.stretches import StretchLaw
from softact.units import Dimensionless, Pressure


class Linear(StretchLaw):
    """Hencky's law: the isotropic linear law with the logarithmic strain. W̄ = μ Σ (ln λ̄i)²."""

    formula: ClassVar[str] = "W̄ = μ Σ (ln λ̄i)² with μ = E / (2 (1 + ν)), K = E / (3 (1 − 2ν))"
    reference: ClassVar[str] = "Hencky 1928; Anand 1979"
    use: ClassVar[str] = (
        "Stiff parts and films: fabric, paper, PET, fittings. In a solid it is Hencky's law "
        "(logarithmic strain: safe under any rotation and stable in compression, unlike "
        "St. Venant-Kirchhoff); in a thin layer it is the plane-stress law of the Green strain. "
        "Meant for strains to about 0.1."
    )

    law: Literal["linear"] = "linear"
    youngs_modulus: Pressure = Field(gt=0, description="E")
    poissons_ratio: Dimensionless = Field(gt=-1, lt=0.5, description="ν; sets K together with E")

    @staticmethod
    def stretch_energy(k: Any, stretch: Number) -> Number:
        """See ``StretchLaw.stretch_energy``."""
        return k.shear_modulus * np.log(stretch) ** 2

    @property
    def shear_modulus(self) -> float:
        """μ = E / (2 (1 + ν)) in MPa."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poissons_ratio))

"""Holzapfel-Gasser-Ogden law with dispersion, for fabrics and fibre-reinforced walls."""

from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Discriminator, Field, Tag, field_validator, model_validator

from softact.materials.base import DEFAULT_POISSONS_RATIO, VOLUMETRIC, FibreLaw, bulk_modulus
from softact.materials.invariants import InvariantLaw
from softact.materials.jets import Number, positive
from softact.units import Angle, Dimensionless, Pressure


def _written_as(value: Any) -> str:
    return "word" if isinstance(value, str) else "vector"


Vector = tuple[Dimensionless, Dimensionless, Dimensionless]
Normal = Annotated[
    Annotated[Vector, Tag("vector")] | Annotated[Literal["radial"], Tag("word")],
    Discriminator(_written_as),
]
# Default ratio of K to k1, see ``Holzapfel._fill_bulk_modulus``.
BULK_TO_FIBRES = 10.0


class Holzapfel(InvariantLaw, FibreLaw):
    """W̄ = C10 (Ī1 − 3) + k1/(2 k2) Σα (exp(k2 ⟨Eα⟩²) − 1), Eα = κ(Ī1 − 3) + (1 − 3κ)(Ī4α − 1)."""

    formula: ClassVar[str] = (
        "W̄ = C10 (Ī1 − 3) + k1/(2 k2) Σα (exp(k2 ⟨Eα⟩²) − 1) with "
        "Eα = κ (Ī1 − 3) + (1 − 3κ)(Ī4α − 1); k1/2 Σα ⟨Eα⟩² where k2 = 0"
    )
    reference: ClassVar[str] = (
        "Gasser, Ogden and Holzapfel 2006, J. R. Soc. Interface 3:15; as in Abaqus"
    )
    use: ClassVar[str] = (
        "Knitted and coated fabrics, walls with windings. One fibre family along the angle to the "
        "region's axis, or two at plus and minus the angle. Fibres carry nothing in compression "
        "(Eα < 0). Volumetric energy K/2 ((J² − 1)/2 − ln J)."
    )
    logarithmic_volume: ClassVar[bool] = True

    law: Literal["holzapfel"] = "holzapfel"
    c10: Pressure = Field(gt=0, description="half the shear modulus of the matrix")
    k1: Pressure = Field(ge=0, description="stiffness of a fibre family")
    k2: Dimensionless = Field(default=0.0, ge=0, description="stiffening of the fibres")
    kappa: Dimensionless = Field(
        default=0.0, ge=0, le=1 / 3, description="dispersion: 0 aligned, 1/3 isotropic"
    )
    angle: Angle = Field(default=0.0, description="of the fibres to the actuator's axis, degrees")
    families: Literal[1, 2] = Field(default=2, description="1: at the angle; 2: at ± the angle")
    normal: Normal | None = Field(
        default=None,
        description="of the plane of the fibres, or radial: away from the actuator's axis; "
        "default: of the region's wall, which of parts from a file is z",
    )

    @classmethod
    def states_poissons_ratio(cls) -> bool:
        """No: the default follows what the fibres ask for, once their stiffness is known."""
        return False

    @model_validator(mode="after")
    def _fill_bulk_modulus(self) -> Self:
        """Where nothing else is said, K of usual elastomers or of the fibres, whichever is more.

        The invariants of the fibres are isochoric, as in Abaqus: where K is small beside the
        fibres' stiffness, volume grows instead of fibres (Helfenstein et al. 2010, Int. J. Solids
        Struct. 47:2056; Nolan et al. 2014, J. Mech. Behav. Biomed. Mater. 39:48).
        """
        if all(getattr(self, key) is None for key in VOLUMETRIC):
            usual = bulk_modulus(self.shear_modulus, DEFAULT_POISSONS_RATIO)
            self.__dict__["bulk_modulus"] = max(usual, BULK_TO_FIBRES * self.k1)
            self.__pydantic_fields_set__.add("bulk_modulus")
        return self

    @field_validator("normal", mode="before")
    @classmethod
    def _has_three_components(cls, value: Any) -> Any:
        three = isinstance(value, list | tuple) and len(value) == 3
        if value not in (None, "radial") and not three:
            raise ValueError("write a list of three for x, y, z, for example [0, 0, 1], or radial")
        return value

    @field_validator("normal")
    @classmethod
    def _has_a_direction(cls, value: Vector | str | None) -> Vector | str | None:
        if value is not None and not any(value):
            raise ValueError("[0, 0, 0] has no direction; write for example [0, 0, 1]")
        return value

    @staticmethod
    def strain_energy(k: Any, i1: Number, i2: Number, *fibre_invariants: Number) -> Number:
        """See ``InvariantLaw.strain_energy``."""
        energy = k.c10 * (i1 - 3.0)
        for i4 in fibre_invariants:
            strain = (1.0 - 3.0 * k.kappa) * (i4 - 1.0)
            if k.kappa:
                strain = strain + k.kappa * (i1 - 3.0)
            square = positive(strain) ** 2
            if k.k2 == 0.0:
                energy = energy + (0.5 * k.k1) * square
            else:
                energy = energy + (0.5 * k.k1 / k.k2) * np.expm1(k.k2 * square)
        return energy

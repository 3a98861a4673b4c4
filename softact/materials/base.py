"""What every law has: constants with units, the volumetric part, density, where it comes from."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic.fields import FieldInfo

from softact.errors import SpecError
from softact.materials.mullins import Mullins
from softact.materials.viscoelastic import Viscoelastic
from softact.units import Compliance, Density, Dimensionless, Pressure, dimension_of

# Nearly incompressible, K of about 500 shear moduli: elastomers have 1e3 to 1e4, and P2/P1
# elements stay accurate and well conditioned here, with a volume change under 1 % at a
# hydrostatic stress of 5 shear moduli.
DEFAULT_POISSONS_RATIO = 0.499
MAX_VOLUMETRIC_ORDER = 6
VOLUMETRIC = ("bulk_modulus", "poissons_ratio", "d1")


def bulk_modulus(shear_modulus: float, poissons_ratio: float) -> float:
    """K in MPa of the undeformed state."""
    nu = poissons_ratio
    return shear_modulus * 2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))


@dataclass(frozen=True)
class CardInfo:
    """Where a material comes from and how far it was tested.

    name: of the card, None for a material written in the spec. strength: tensile strength in MPa or
    None; strength_is: by which area it is, "nominal" (undeformed) or "true". elongation: at break,
    1.6 for 160 %, or None. stretch_range: smallest and largest stretch of the test or None.
    """

    name: str | None
    source: str | None
    test: str | None
    strength: float | None
    stretch_range: tuple[float, float] | None
    strength_is: Literal["nominal", "true"] = "nominal"
    elongation: float | None = None


@dataclass(frozen=True)
class Constant:
    """One constant of a law: its field, its unit (MPa, 1/MPa or empty) and what it means."""

    name: str
    unit: str
    meaning: str
    default: float | None


#: Stress (n, k), moduli (n, k, k) and energy (n,) of a law alone; the energy is None where it is
#: not wanted.
Elastic = tuple[np.ndarray, np.ndarray, np.ndarray | None]


class Law(BaseModel):
    """Base of the laws: an isochoric energy of its own and a volumetric part that all share.

    Volumetric energy K/2 (J−1)² + Σ_{i≥2} (J−1)^{2i}/D_i with K from one of ``bulk_modulus``,
    ``poissons_ratio`` (with the initial shear modulus) or ``d1`` (K = 2/D1). Units: MPa, mm, tonne.
    """

    # Built when it is used first, see ``Geometry``.
    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=False, defer_build=True)

    if TYPE_CHECKING:  # Each law has its own name as the only value.
        law: str

    formula: ClassVar[str]
    reference: ClassVar[str]
    use: ClassVar[str]
    anisotropic: ClassVar[bool] = False
    logarithmic_volume: ClassVar[bool] = False

    density: Density = Field(
        default=1.07e-9, gt=0, description="mass per volume; default: a usual platinum silicone"
    )
    bulk_modulus: Pressure | None = Field(default=None, gt=0, description="K")
    poissons_ratio: Dimensionless | None = Field(
        default=None, gt=-1, lt=0.5, description="ν of the undeformed state; sets K"
    )
    d1: Compliance | None = Field(default=None, gt=0, description="D1 = 2/K")
    d2: Compliance | None = Field(default=None, gt=0, description="D2 of (J−1)⁴/D2")
    d3: Compliance | None = Field(default=None, gt=0, description="D3 of (J−1)⁶/D3")
    d4: Compliance | None = Field(default=None, gt=0, description="D4 of (J−1)⁸/D4")
    d5: Compliance | None = Field(default=None, gt=0, description="D5 of (J−1)¹⁰/D5")
    d6: Compliance | None = Field(default=None, gt=0, description="D6 of (J−1)¹²/D6")
    name: str | None = Field(default=None, description="name of the card")
    source: str | None = Field(default=None, description="paper or data sheet")
    test: str | None = Field(default=None, description="mode and extent of the test")
    stretch_range: tuple[Dimensionless, Dimensionless] | None = Field(
        default=None, description="smallest and largest stretch of the test"
    )
    strength: Pressure | None = Field(default=None, gt=0, description="tensile strength")
    strength_is: Literal["nominal", "true"] = Field(
        default="nominal",
        description="nominal: force per undeformed area; true: per area at break (Cauchy stress)",
    )
    elongation: Dimensionless | None = Field(
        default=None, gt=0, description="at break, 1.6 for 160 %"
    )
    strength_source: str | None = Field(
        default=None, description="where strength and elongation come from"
    )
    notes: str | None = None
    viscoelastic: Viscoelastic | None = Field(
        default=None, description="how it creeps and relaxes: {g, tau, constants, wlf}"
    )
    mullins: Mullins | None = Field(
        default=None, description="how it softens once it has been stretched: {r, m, beta}"
    )

    @classmethod
    def states_poissons_ratio(cls) -> bool:
        """Whether a law of which no compressibility is given has the usual Poisson's ratio."""
        return not cls.model_fields["poissons_ratio"].is_required()

    @model_validator(mode="before")
    @classmethod
    def _fill_volumetric(cls, data: Any) -> Any:
        """State the default compressibility, so that the resolved spec shows it."""
        if isinstance(data, dict):
            given = [key for key in VOLUMETRIC if data.get(key) is not None]
            if len(given) > 1:
                raise ValueError(f"{' and '.join(given)} both set the bulk modulus; give one")
            if not given and cls.states_poissons_ratio():
                return {**data, "poissons_ratio": DEFAULT_POISSONS_RATIO}
        return data

    @model_validator(mode="after")
    def _check(self) -> Self:
        modulus = self.shear_modulus
        if not (math.isfinite(modulus) and modulus > 0):
            raise ValueError(
                f"the initial shear modulus is {modulus:.6g} MPa with these constants; "
                "it must be positive"
            )
        if self.stretch_range and not 0 < self.stretch_range[0] <= 1 <= self.stretch_range[1]:
            raise ValueError("stretch_range must enclose 1, for example [1, 2.6]")
        return self

    @classmethod
    def of(cls, **values: Any) -> Self:
        """Make a law from floats in internal units (MPa, 1/MPa, tonne/mm³); text has its unit."""
        fields = cls.model_fields
        return cls(
            **{k: _with_unit(fields.get(k) or fields.get(f"{k}1"), v) for k, v in values.items()}
        )

    @classmethod
    def constants(cls) -> list[Constant]:
        """Return the law's own constants, without the volumetric part and the card's fields."""
        return [
            Constant(name, _unit(entry), entry.description or "", _default(entry))
            for name, entry in cls.model_fields.items()
            if name not in Law.model_fields and name != "law"
        ]

    @property
    def card(self) -> CardInfo:
        """Where the material comes from and how far it was tested."""
        return CardInfo(
            self.name,
            self.source,
            self.test,
            self.strength,
            self.stretch_range,
            self.strength_is,
            self.elongation,
        )

    @property
    def shear_modulus(self) -> float:
        """Shear modulus of the undeformed state, MPa."""
        raise NotImplementedError

    @property
    def initial_bulk_modulus(self) -> float:
        """K in MPa, from whichever of bulk_modulus, d1 and poissons_ratio is given."""
        if self.bulk_modulus is not None:
            return self.bulk_modulus
        if self.d1 is not None:
            return 2.0 / self.d1
        nu = DEFAULT_POISSONS_RATIO if self.poissons_ratio is None else self.poissons_ratio
        return bulk_modulus(self.shear_modulus, nu)

    @property
    def remembers(self) -> bool:
        """Whether its stress depends on what has been."""
        creeps = self.viscoelastic is not None and self.viscoelastic.prony is not None
        return creeps or self.mullins is not None

    def material(self) -> "Material":
        """Return what the solver evaluates."""
        raise NotImplementedError


class FibreLaw(Law):
    """Base of the laws with fibres: one family at an angle to an axis, or two at ± the angle."""

    anisotropic: ClassVar[bool] = True

    if TYPE_CHECKING:  # Fields of each law: they stand where its page shows them.
        k1: float
        angle: float
        families: Literal[1, 2]
        normal: tuple[float, float, float] | Literal["radial"] | None

    def fibre_directions(self, axis: np.ndarray, normal: np.ndarray) -> np.ndarray:
        """Return unit vectors (n, families, 3) in the plane normal to ``normal``.

        axis: direction (n,3) from which the angle counts, towards normal × axis; only its part in
        the plane counts. normal: of the wall (n,3), of any length. Raises ValueError where the two
        are parallel.
        """
        normal = normal / np.linalg.norm(normal, axis=1)[:, None]
        across = np.cross(normal, axis)
        length = np.linalg.norm(across, axis=1)[:, None]
        if np.any(length < 1e-9 * np.linalg.norm(axis, axis=1)[:, None]):
            raise ValueError("the wall's normal is parallel to the axis of the fibre angle")
        across = across / length
        axis = np.cross(across, normal)
        angles = np.radians([self.angle, -self.angle][: self.families])
        return np.stack([np.cos(a) * axis + np.sin(a) * across for a in angles], axis=1)


class Material(ABC):
    """A law as the solver sees it: numpy functions of C, MPa, vectorised over n points.

    law: the constants. bulk_modulus: K in MPa of the volumetric energy K/2 (J−1)². shear_modulus:
    of the undeformed state in MPa. density: tonne/mm³. logarithmic_volume: whether the volumetric
    energy is K/2 ((J² − 1)/2 − ln J) instead. card: strength and tested range.
    """

    def __init__(self, law: Law):
        self.law = law
        self.bulk_modulus = law.initial_bulk_modulus
        self.shear_modulus = law.shear_modulus
        self.density = law.density
        self.logarithmic_volume = law.logarithmic_volume
        self.card = law.card

    @abstractmethod
    def energy(self, C: np.ndarray, fibres: np.ndarray | None = None) -> np.ndarray:
        """Return the isochoric energy W̄ (n,) in MPa at the right Cauchy-Green tensors C (n,3,3)."""

    @abstractmethod
    def stress_tangent(
        self, C: np.ndarray, fibres: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return S = 2 dW̄/dC (n,6) and D = 4 d²W̄/dCdC (n,6,6) in MPa at C (n,3,3).

        Voigt order 11, 22, 33, 12, 13, 23, tensor components without factors; C is not isochoric,
        the function takes C̄ = J^(−2/3) C. fibres: unit vectors (n, families, 3) in the undeformed
        state, for fibre laws only. Where the law has no value (beyond a locking stretch, C not
        positive definite) the result is not finite.
        """

    def check_fibres(self, fibres: np.ndarray | None) -> None:
        """Raise SpecError where a law does not get the fibres that it has: without them it would
        silently be its matrix alone."""
        wanted = self.law.families if isinstance(self.law, FibreLaw) else None
        given = None if fibres is None else np.shape(fibres)[1]
        if given != wanted:
            raise SpecError(
                f"the law {self.law.law} wants {wanted or 'no'} fibre directions per point, "
                f"not {given or 'none'}"
            )

    def extra_volumetric(self, J: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return U, dU/dJ, d²U/dJ² (n,) in MPa of what the volumetric energy has beyond K/2 (J−1)².

        The sum of ``higher_volumetric`` and ``logarithmic_excess``. Zeros if there is nothing.
        """
        parts = zip(self.higher_volumetric(J), self.logarithmic_excess(J), strict=True)
        energy, first, second = (higher + excess for higher, excess in parts)
        return energy, first, second

    def higher_volumetric(self, J: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return U, dU/dJ, d²U/dJ² (n,) in MPa of the terms of D2 to D6."""
        J = np.asarray(J, dtype=float)
        energy, first, second = np.zeros_like(J), np.zeros_like(J), np.zeros_like(J)
        x = J - 1.0
        for i in range(2, MAX_VOLUMETRIC_ORDER + 1):
            if (d := getattr(self.law, f"d{i}")) is not None:
                energy += x ** (2 * i) / d
                first += 2 * i * x ** (2 * i - 1) / d
                second += 2 * i * (2 * i - 1) * x ** (2 * i - 2) / d
        return energy, first, second

    def logarithmic_excess(self, J: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return U, dU/dJ, d²U/dJ² (n,) in MPa of K/2 ((J²−1)/2 − ln J) − K/2 (J−1)².

        Zeros for laws whose source does not write the volumetric energy in the first form.
        """
        J = np.asarray(J, dtype=float)
        if not self.logarithmic_volume:
            return np.zeros_like(J), np.zeros_like(J), np.zeros_like(J)
        half, x = 0.5 * self.bulk_modulus, J - 1.0
        with np.errstate(divide="ignore", invalid="ignore"):
            return (
                half * (0.5 * (J * J - 1.0) - np.log(J) - x * x),
                half * (J - 1.0 / J - 2.0 * x),
                half * (1.0 / (J * J) - 1.0),
            )


def _default(entry: FieldInfo) -> float | None:
    return entry.default if isinstance(entry.default, int | float) else None


def _unit(entry: FieldInfo) -> str:
    dimension = dimension_of(entry)
    return dimension.internal if dimension else ""


def _with_unit(entry: FieldInfo | None, value: Any) -> Any:
    dimension = dimension_of(entry) if entry is not None else None
    if isinstance(value, list):
        return [_with_unit(entry, part) for part in value]
    if dimension is None or isinstance(value, str) or value is None:
        return value
    return f"{float(value)!r} {dimension.internal}"

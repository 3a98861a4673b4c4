"""Ogden law of order 1 to 6."""

from typing import Any, ClassVar, Literal

from pydantic import Field, model_validator

from softact.materials.jets import Number
from softact.materials.stretches import StretchLaw
from softact.units import Dimensionless, Pressure

ORDER = 6


class Ogden(StretchLaw):
    """W̄ = Σ 2 μi/αi² (λ̄1^αi + λ̄2^αi + λ̄3^αi − 3)."""

    formula: ClassVar[str] = "W̄ = Σ 2 μi/αi² (λ̄1^αi + λ̄2^αi + λ̄3^αi − 3)"
    reference: ClassVar[str] = "Ogden 1972, Proc. R. Soc. A 326:565; Abaqus's convention"
    use: ClassVar[str] = (
        "Large stretch with tests in two or more modes; order 3 follows rubber to its S-shape. "
        "From one mode it extrapolates badly. Constants of Ogden's own convention "
        "Σ μi/αi (λ^αi − …) are given with convention: classic."
    )

    law: Literal["ogden"] = "ogden"
    convention: Literal["abaqus", "classic"] = Field(
        default="abaqus",
        description="abaqus: 2μ/α² (λ^α − …), shear modulus Σμi; classic: μ/α (λ^α − …), ½Σμiαi",
    )
    mu1: Pressure = Field(description="modulus of the first term")
    alpha1: Dimensionless = Field(description="exponent of the first term, not 0")
    mu2: Pressure | None = Field(default=None, description="modulus of the second term")
    alpha2: Dimensionless | None = Field(default=None, description="exponent of the second term")
    mu3: Pressure | None = Field(default=None, description="modulus of the third term")
    alpha3: Dimensionless | None = Field(default=None, description="exponent of the third term")
    mu4: Pressure | None = Field(default=None, description="modulus of the fourth term")
    alpha4: Dimensionless | None = Field(default=None, description="exponent of the fourth term")
    mu5: Pressure | None = Field(default=None, description="modulus of the fifth term")
    alpha5: Dimensionless | None = Field(default=None, description="exponent of the fifth term")
    mu6: Pressure | None = Field(default=None, description="modulus of the sixth term")
    alpha6: Dimensionless | None = Field(default=None, description="exponent of the sixth term")

    @model_validator(mode="before")
    @classmethod
    def _read_terms(cls, data: Any) -> Any:
        """Accept lists ``mu`` and ``alpha`` for mu1.. and alpha1..; check that terms are whole."""
        if not isinstance(data, dict):
            return data
        data = dict(data)
        for key in ("mu", "alpha"):
            if key not in data:
                continue
            values = data.pop(key)
            if not isinstance(values, list | tuple) or not 1 <= len(values) <= ORDER:
                raise ValueError(f"{key} must be a list of 1 to {ORDER} values")
            for i, value in enumerate(values, start=1):
                if f"{key}{i}" in data:
                    raise ValueError(f"{key}{i} is given twice, by itself and in the list {key}")
                data[f"{key}{i}"] = value
        for i in range(1, ORDER + 1):
            mu, alpha = data.get(f"mu{i}"), data.get(f"alpha{i}")
            if (mu is None) != (alpha is None):
                have, lack = ("mu", "alpha") if alpha is None else ("alpha", "mu")
                raise ValueError(f"{have}{i} is given without {lack}{i}")
            if alpha == 0.0:
                raise ValueError(f"alpha{i} must not be 0")
        return data

    @staticmethod
    def stretch_energy(k: Any, stretch: Number) -> Number:
        """See ``StretchLaw.stretch_energy``."""
        classic = k.convention == "classic"
        energy = 0.0
        for i in range(1, ORDER + 1):
            mu, alpha = getattr(k, f"mu{i}", None), getattr(k, f"alpha{i}", None)
            if mu is not None and alpha is not None:
                factor = mu / alpha if classic else 2.0 * mu / alpha**2
                energy = energy + factor * (stretch**alpha - 1.0)
        return energy

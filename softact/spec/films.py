"""Layers and sheets as a spec has them: thin, and of plies."""

from collections.abc import Iterable
from typing import Literal, Self

from pydantic import Field, model_validator

from softact.fields import Part, fault
from softact.materials import Law
from softact.spec.fields import AnyMaterial, LayerMaterial
from softact.units import Angle, Dimensionless, Length


def refuse_wrinkles(materials: Iterable[Law], wrinkling: str | None) -> None:
    """Raise a fault where what creeps or softens is to wrinkle finely."""
    if wrinkling == "tension_field" and any(material.remembers for material in materials):
        raise fault(
            "fine wrinkles remember nothing: write wrinkling: resolved, or leave viscoelastic and "
            "mullins out"
        )


class LayerSpec(Part, title="Layer"):
    """A thin layer bonded to a surface: membrane stiffness, bending stiffness where it is flat, no
    mesh. Where it does not bend, it wrinkles finely instead of being compressed."""

    surface: str = Field(description="surface of the geometry, outer or embedded")
    thickness: Length = Field(gt=0, description="thickness of the layer")
    material: LayerMaterial = Field(description="a card or {law: linear, ...}")
    bending: Dimensionless = Field(
        1.0,
        ge=0,
        le=1,
        description="part of a plate's bending stiffness E t³/12(1 − ν²) that it has; a woven "
        "fabric has little",
    )
    wrinkling: Literal["tension_field", "resolved"] | None = Field(
        None,
        description="tension_field: fine wrinkles take its compression; resolved: it carries it; "
        "default: tension_field where it has no bending stiffness (on curved surfaces)",
    )

    @model_validator(mode="after")
    def _remembers_without_wrinkles(self) -> Self:
        refuse_wrinkles([self.material], self.wrinkling)
        return self


class PlySpec(Part, title="Ply"):
    """One layer of a sheet of the geometry."""

    material: AnyMaterial = Field(description="a card or {law: ...}; any law, in plane stress")
    thickness: Length = Field(gt=0, description="its own thickness")
    angle: Angle = Field(
        0.0, description="of the axis of its fibres to the sheet's axis, about the sheet's normal"
    )
    incompressible: bool = Field(
        False,
        description="its volume is constant, and the compressibility of its material does not "
        "count; not for law linear, which has a Poisson's ratio",
    )

    @model_validator(mode="after")
    def _can_keep_its_volume(self) -> Self:
        if self.material.remembers and not (self.incompressible or self.material.law == "linear"):
            raise fault(
                "a ply that creeps or softens keeps its volume, or is linear: incompressible: true"
            )
        if self.incompressible and self.material.law == "linear":
            raise ValueError("law linear has a Poisson's ratio: leave incompressible out")
        return self


class SheetOfLayers(Part):
    """What a sheet of the geometry is made of; plies are bonded to each other and add up."""

    plies: tuple[PlySpec, ...] = Field(strict=False, min_length=1, description="its layers")
    wrinkling: Literal["tension_field", "resolved"] = Field(
        "tension_field",
        description="tension_field: compression is relaxed by wrinkles finer than the mesh; "
        "resolved: it is carried, and the mesh buckles as far as it can",
    )
    bending: Dimensionless = Field(
        0.0, ge=0, le=1, description="part of the plies' bending stiffness E t³/12(1 − ν²)"
    )
    axis: tuple[Dimensionless, Dimensionless, Dimensionless] = Field(
        (1.0, 0.0, 0.0), strict=False, description="direction from which fibre angles count"
    )

    @model_validator(mode="after")
    def _remembers_without_wrinkles(self) -> Self:
        refuse_wrinkles([ply.material for ply in self.plies], self.wrinkling)
        return self

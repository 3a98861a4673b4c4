"""Rigid obstacles and contact of surfaces, as a spec writes them."""

from collections.abc import Sequence
from typing import Annotated, Any

from pydantic import (
    BaseModel,
    BeforeValidator,
    Field,
    GetJsonSchemaHandler,
    WithJsonSchema,
    model_validator,
)
from pydantic_core import CoreSchema

from softact.contact.obstacles import OBSTACLES, SpecObstacle
from softact.contact.obstacles.base import Friction
from softact.fields import (
    NAMES_SCHEMA,
    Name,
    Part,
    fault,
    fault_at,
    given,
    one_or_more,
)
from softact.mesh.layout import Layout
from softact.nearest import nearest
from softact.spec.choice import Choice
from softact.units import Length, show


class ObstacleChoice(Choice):
    """An obstacle: the key ``type`` says which."""

    def model_for(self, data: Any) -> type[SpecObstacle] | None:
        """See ``Choice.model_for``."""
        kind = data.get("type") if isinstance(data, dict) else None
        return OBSTACLES.get(kind) if isinstance(kind, str) else None

    def validate(self, data: Any) -> SpecObstacle:
        """See ``Choice.validate``."""
        names = ", ".join(OBSTACLES)
        if isinstance(data, SpecObstacle):
            return data
        if not isinstance(data, dict):
            raise fault(f"{given(data)}; write a mapping with 'type' (one of {names}) and its keys")
        if "type" not in data:
            raise fault_at(("type",), f"missing; write one of: {names}")
        if (model := self.model_for(data)) is None:
            kind = data["type"]
            known = nearest(kind, OBSTACLES)
            raise fault_at(("type",), f"there is no obstacle {show(kind)}; {known}")
        return model.model_validate(data)

    def options(self) -> list[type[BaseModel]]:
        """See ``Choice.options``."""
        return list(OBSTACLES.values())

    def also(self) -> tuple[str, ...]:
        """See ``Choice.also``."""
        return ("type",)


AnyObstacle = Annotated[SpecObstacle, ObstacleChoice()]


Surfaces = Annotated[
    tuple[str, ...],
    BeforeValidator(one_or_more),
    Field(strict=False, min_length=1),
    WithJsonSchema(NAMES_SCHEMA),
]


class SurfaceContactSpec(Part, title="SurfaceContact"):
    """Surfaces of bodies that may touch: themselves, or each other."""

    name: Name = Field("", description="default: contact_1, contact_2, ...")
    self: Surfaces | None = Field(
        None, description="a surface or sheet, or several, that may touch itself: outer"
    )
    between: tuple[Surfaces, Surfaces] | None = Field(
        None, strict=False, description="two surfaces or sheets that may touch: [upper, lower]"
    )
    friction: Friction = Field(0.0, description="Coulomb coefficient")
    distance: Length = Field(0.0, ge=0, description="gap below which they press on each other")

    @model_validator(mode="after")
    def _has_surfaces(here: "SurfaceContactSpec") -> "SurfaceContactSpec":  # noqa: N805 (``self`` is a field)
        if (here.__dict__["self"] is None) == (here.between is None):
            raise fault("write either self: outer, or between: [one, other]")
        return here

    @property
    def groups(here: "SurfaceContactSpec") -> tuple[tuple[str, ...], ...]:  # noqa: N805
        """One group of surfaces that touch themselves, or two that touch each other."""
        return (here.__dict__["self"],) if here.between is None else here.between


#: What ``contact: auto`` is until the geometry says which surfaces are its outside: nobody can
#: write this name of a surface.
AUTO = (SurfaceContactSpec(name="outside", self=("*",)),)


_WORDS: dict[str, tuple] = {"auto": AUTO, "none": ()}


def _contacts(value: Any) -> Any:
    if isinstance(value, str):
        if value not in _WORDS:
            raise fault(f"{given(value)}; write auto, none, or a list such as [{{self: outer}}]")
        return _WORDS[value]
    return value


class _OrWord:
    """Has the JSON schema take the words, too."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {"anyOf": [handler(schema), {"enum": list(_WORDS)}]}


Contacts = Annotated[tuple[SurfaceContactSpec, ...], BeforeValidator(_contacts), _OrWord()]


def outside(layout: Layout) -> tuple[str, ...]:
    """The surfaces and sheets that ``contact: auto`` keeps from passing through each other."""
    if not layout.regions:
        return tuple(layout.sheets)
    return (*layout.outside, *(name for name in layout.sheets if name not in layout.bonded))


def resolved_contact(
    written: tuple[SurfaceContactSpec, ...] | None,
    steps: Sequence[Any],
    layout: Layout,
    meets_itself: bool,
) -> tuple[SurfaceContactSpec, ...]:
    """The contacts of a spec: those written, or of the outside where nothing was (None) and its
    walls can meet (meets_itself); and, unless it says none, those of the walls of cavities that a
    step evacuates, which would pass through each other.

    Sheets have an outer side only, so that their walls never meet from inside.
    """
    if written == ():
        return ()
    contacts = written or ()
    if written == AUTO or (written is None and meets_itself):
        names = outside(layout)
        contacts = (SurfaceContactSpec(name="outside", self=names),) if names else ()
    for cavity, walls in layout.cavities.items():
        evacuated = any(
            (change or {}).get(cavity, 0.0) < 0.0
            for step in steps
            for change in (step.pressure, step.inject)
        )
        known = any(set(walls) <= set(group) for c in contacts for group in c.groups[:1])
        if evacuated and not known and not set(walls) & set(layout.sheets):
            contacts = (*contacts, SurfaceContactSpec(name=f"{cavity}_walls", self=tuple(walls)))
    return contacts

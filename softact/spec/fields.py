"""The types of a spec's fields that are more than one value with a unit."""

from typing import Annotated, Any, Literal

from pydantic import (
    PlainSerializer,
    PlainValidator,
    WithJsonSchema,
)

from softact.fields import fault, fault_at, given
from softact.geometry.base import Geometry
from softact.materials import Law
from softact.materials.laws.linear import Linear
from softact.spec.choice import GeometryChoice, MaterialChoice
from softact.units import show


def _geometries() -> dict[str, type[Geometry]]:
    from softact.geometries import GEOMETRIES

    return GEOMETRIES


def _measures(value: Any) -> Any:
    if value == "all":
        return value
    if not isinstance(value, list | tuple) or not value:
        raise fault(f"{given(value)}; write 'all' or a list of names (softact list measures)")
    for index, name in enumerate(value):
        if not isinstance(name, str):
            raise fault_at((index,), f"{show(name)} is not the name of a measure", name)
    return tuple(value)


MEASURES_SCHEMA = {"anyOf": [{"const": "all"}, {"type": "array", "items": {"type": "string"}}]}

Measures = Annotated[
    Literal["all"] | tuple[str, ...],
    PlainValidator(_measures),
    PlainSerializer(lambda v: v if v == "all" else list(v), when_used="json"),
    WithJsonSchema(MEASURES_SCHEMA),
]
GEOMETRY = GeometryChoice(_geometries)
AnyGeometry = Annotated[Geometry, GEOMETRY]
AnyMaterial = Annotated[Law, MaterialChoice()]
LayerMaterial = Annotated[Linear, MaterialChoice(layer=True)]

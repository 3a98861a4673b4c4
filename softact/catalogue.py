"""What there is to write in a spec: laws, materials, geometries, measures, loads, as plain data.

Read from the models themselves, so that it cannot say anything else than they accept.
"""

import types
from collections.abc import Callable, Iterable, Iterator
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from softact.geometries import GEOMETRIES
from softact.geometry.base import Geometry
from softact.loads import LOADS
from softact.materials import CARDS, LAWS, Law, card_data
from softact.measures import MEASURES
from softact.spec import Step, SupportSpec
from softact.spec.checks import made_of_sheets
from softact.units import dimension_of

CARD_TEXTS = (
    "name", "source", "test", "stretch_range", "strength", "strength_is", "elongation",
    "strength_source", "notes",
)  # fmt: skip
NAMES = ("regions", "cavities", "surfaces", "sheets", "curves")  # of a layout, for a spec
NO_LOADS = ("name", "max_increment", "duration", "amplitude", "dynamics")  # of a step


def kind(annotation: Any) -> str:
    """Return in words what to write for a value of a type."""
    if dimension := dimension_of(annotation):
        name = dimension.name
        if tuple in (get_origin(part) for part in (annotation, *get_args(annotation))):
            return f"list of {name}s"
        return f"{name} of each" if get_origin(annotation) is dict else name
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return kind(arguments[0])
    if origin is Literal:
        return ", ".join(str(choice) for choice in arguments)
    if origin in (Union, types.UnionType):
        return " or ".join(kind(part) for part in arguments if part is not type(None))
    if origin in (tuple, list):
        inner = dict.fromkeys(kind(part) for part in arguments if part is not Ellipsis)
        return "list of " + ", ".join(inner)
    if origin is dict:
        return "mapping to " + kind(arguments[1])
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        bases = {Geometry: "geometry", Law: "material"}
        named = (word for base, word in bases.items() if issubclass(annotation, base))
        return next(named, (annotation.model_config.get("title") or annotation.__name__).lower())
    names = {str: "text", float: "number", int: "whole number", bool: "true or false"}
    return names.get(annotation, str(annotation))


def parameters(model: type[BaseModel], leave_out: Iterable[str] = ()) -> list[dict[str, Any]]:
    """Return a record for each field of a model: what it takes, unit, default and meaning.

    Keys: name, value, unit (empty where there is none), default (as written in a spec, None where
    nothing is set), needed, meaning.
    """
    left_out = set(leave_out)
    return [
        {
            "name": name,
            "value": _value(entry),
            "unit": dimension.shown[0] if (dimension := dimension_of(entry)) else "",
            "default": _default(entry),
            "needed": entry.is_required(),
            "meaning": entry.description or "",
        }
        for name, entry in model.model_fields.items()
        if name not in left_out
    ]


def _value(entry: FieldInfo) -> str:
    # pydantic keeps the dimension of a plain field beside the annotation.
    dimension = dimension_of(entry)
    bare = entry.annotation in (float, float | None)
    return dimension.name if dimension and bare else kind(entry.annotation)


def _default(entry: FieldInfo) -> Any:
    value = None if entry.is_required() else entry.get_default(call_default_factory=False)
    if isinstance(value, BaseModel) or value in ((), {}, ""):
        return None
    dimension = dimension_of(entry)
    if isinstance(value, tuple):
        return f"[{', '.join(f'{v:g}' if isinstance(v, float) else str(v) for v in value)}]"
    return dimension.format(value) if dimension and isinstance(value, float) else value


_TOLD_OF_CARDS = (
    "density", "strength", "strength_is", "elongation", "strength_source", "stretch_range", "source"
)  # fmt: skip


def laws() -> list[dict[str, Any]]:
    """Return every law: its energy, when to use it, its source and its constants."""
    return [
        {
            "name": name,
            "formula": law.formula,
            "use": law.use,
            "source": law.reference,
            "parameters": parameters(law, leave_out=("law", *Law.model_fields)),
        }
        for name, law in LAWS.items()
    ]


def shared_constants() -> list[dict[str, Any]]:
    """Return what every law takes beside its own constants: density and compressibility."""
    return parameters(Law, leave_out=CARD_TEXTS)


def materials() -> list[dict[str, Any]]:
    """Return every material card: its law, constants with units, density and source."""
    records = []
    for name in CARDS:
        data = card_data(name)
        other = ("law", "density", *CARD_TEXTS)
        constants = {key: value for key, value in data.items() if key not in other}
        texts = {key: data.get(key) for key in _TOLD_OF_CARDS}
        records.append({"name": name, "law": data["law"], "constants": constants, **texts})
    return records


def geometries() -> list[dict[str, Any]]:
    """Return every geometry: its parameters and the names that a spec may use with it.

    Keys: name, use, parameters, ``NAMES`` (those of the defaults), others (a record for each choice
    that brings further names: with, and what of ``NAMES`` it brings), example (of the section
    ``sheets``, "" where the geometry has none).
    """
    return [_geometry(name, geometry) for name, geometry in GEOMETRIES.items()]


def _geometry(name: str, geometry: type[Geometry]) -> dict[str, Any]:
    usual = _names(geometry)
    return {
        "name": name,
        "use": " ".join((geometry.__doc__ or "").split("\n\n")[0].split()),
        **usual,
        "others": list(_others(geometry, usual)),
        "example": made_of_sheets(usual["sheets"]) if usual["sheets"] else "",
        "parameters": parameters(geometry, leave_out=("type",)),
    }


def _names(geometry: type[Geometry], **choice: Any) -> dict[str, list[str]]:
    layout = geometry.model_construct(**choice).layout()  # a file's name has no default
    return {key: list(getattr(layout, key)) for key in NAMES}


def _others(
    geometry: type[Geometry], usual: dict[str, list[str]]
) -> Iterator[dict[str, str | list[str]]]:
    """What other choices of a geometry's parameters bring that the defaults lack."""
    for name, entry in geometry.model_fields.items():
        choices = get_args(entry.annotation) if get_origin(entry.annotation) is Literal else ()
        for choice in choices if name != "type" else ():
            found = _names(geometry, **{name: choice})
            more = {key: [n for n in found[key] if n not in usual[key]] for key in NAMES}
            if any(more.values()):
                yield {"with": f"{name}: {choice}", **{k: v for k, v in more.items() if v}}


def loads() -> list[dict[str, Any]]:
    """Return every load that a step may change, and its supports."""
    inner = {key: load.annotation for key, load in LOADS.items()} | {"supports": SupportSpec}
    return [
        {
            "name": entry["name"],
            "value": entry["value"],
            "unit": entry["unit"],
            "meaning": entry["meaning"],
            "parameters": parameters(part) if (part := model_in(inner[entry["name"]])) else [],
        }
        for entry in parameters(Step, leave_out=NO_LOADS)
    ]


def model_in(annotation: Any) -> type[BaseModel] | None:
    """The model of pydantic that a type is, maps names to or has in its lists; None where there is
    none."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is dict:
        return model_in(arguments[1])
    if origin is Annotated:
        return model_in(arguments[0])
    if origin in (Union, types.UnionType):
        return next((m for part in arguments if (m := model_in(part))), None)
    is_model = isinstance(annotation, type) and issubclass(annotation, BaseModel)
    return annotation if is_model else None


def measures() -> list[dict[str, Any]]:
    """Return every measure: its columns with their units and what it means."""
    return [
        {"name": name, "use": measure.description, "columns": dict(measure.columns)}
        for name, measure in MEASURES.items()
    ]


KINDS: dict[str, Callable[[], list[dict[str, Any]]]] = {
    "laws": laws,
    "materials": materials,
    "geometries": geometries,
    "measures": measures,
    "loads": loads,
}

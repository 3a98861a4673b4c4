"""pydantic's errors as one plain line each: where, what is wrong, what would be right."""

import types
from collections.abc import Callable
from typing import Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from softact.spec.choice import Choice, given, nearest
from softact.spec.document import Document, Place, dotted
from softact.units import dimension_of, show

MAX_LINES = 60


def fault_lines(error: ValidationError, document: Document, model: type[BaseModel]) -> list[str]:
    """Return a line for each fault in ``error``, in the order of the document's lines."""
    lines = {}
    for entry in error.errors(include_url=False):
        place = _place(entry, document, model)
        for text in _text(entry, place, document, model).splitlines():
            at = f"{dotted(place)}: " if place else ""
            lines[f"{document.where(place)}: {at}{text}"] = _order(place, document)
    ordered = sorted(lines, key=lines.__getitem__)
    if len(ordered) > MAX_LINES:
        more = len(ordered) - MAX_LINES
        return [*ordered[:MAX_LINES], f"{document.name}: and {more} more faults"]
    return ordered


def _order(place: Place, document: Document) -> int:
    for length in range(len(place), -1, -1):
        if place[:length] in document.lines:
            return document.lines[place[:length]]
    return 0


def _place(entry: dict[str, Any], document: Document, model: type[BaseModel]) -> Place:
    """Return where the fault stands in the document, without what only pydantic knows of."""
    place: list[str | int] = []
    for position, key in enumerate(entry["loc"]):
        last = position == len(entry["loc"]) - 1
        # A key that is not there can be at fault: it is missing, or its default does not fit.
        if document.has((*place, key)) or (last and _may_hold(tuple(place), key, document, model)):
            place.append(key)
    return tuple(place)


def _may_hold(place: Place, key: Any, document: Document, model: type[BaseModel]) -> bool:
    known = _known_keys(place, document, model)
    return key in known or place in (("materials",), ("sheets",)) or key in ("type", "law")


def _text(entry: dict[str, Any], place: Place, document: Document, model: type[BaseModel]) -> str:
    if writer := _TEXTS.get(entry["type"]):
        return writer(entry, place, document, model)
    return entry["msg"].removeprefix("Value error, ").removeprefix("Assertion failed, ")


def _missing(entry: dict, place: Place, document: Document, model: type[BaseModel]) -> str:
    field = _field(place, document, model)
    if field is None:
        return "missing"
    if dimension := dimension_of(field):
        return f"missing; {dimension.hint}"
    return f"missing; {field.description}" if field.description else "missing"


def _extra(entry: dict, place: Place, document: Document, model: type[BaseModel]) -> str:
    known = _known_keys(place[:-1], document, model)
    return f"unknown key; {nearest(place[-1], known)}"


def _literal(entry: dict, place: Place, document: Document, model: type[BaseModel]) -> str:
    expected = entry["ctx"]["expected"].replace(" or ", ", ").replace("'", "")
    value = place[-1] if entry["loc"][-1] == "[key]" else entry["input"]
    return f"{show(value)} is not one of: {expected}"


def _bound(relation: str, limit: str) -> Callable[..., str]:
    def text(entry: dict, place: Place, document: Document, model: type[BaseModel]) -> str:
        field = _field(place, document, model)
        dimension = dimension_of(field) if field is not None else None
        bound = entry["ctx"][limit]
        bound = dimension.format(float(bound)) if dimension and bound else f"{bound:g}"
        return f"{show(_value(place, document))} must be {relation} {bound}"

    return text


def _wanted(kind: str) -> Callable[..., str]:
    def text(entry: dict, place: Place, document: Document, model: type[BaseModel]) -> str:
        field = _field(place, document, model)
        describes = field is not None and field.description and isinstance(place[-1], str)
        means = f" ({field.description})" if describes else ""
        return f"{given(_value(place, document))}; {kind} is wanted{means}"

    return text


def _pattern(entry: dict, place: Place, document: Document, model: type[BaseModel]) -> str:
    return (
        f"{show(entry['input'])} is no name here; use small letters, digits, '_' and '-', "
        "at most 64, for example 'finger_1'"
    )


_TEXTS: dict[str, Callable[..., str]] = {
    "missing": _missing,
    "extra_forbidden": _extra,
    "literal_error": _literal,
    "greater_than": _bound("greater than", "gt"),
    "greater_than_equal": _bound("at least", "ge"),
    "less_than": _bound("less than", "lt"),
    "less_than_equal": _bound("at most", "le"),
    "string_type": _wanted("text"),
    "string_pattern_mismatch": _pattern,
    "int_type": _wanted("a whole number"),
    "int_from_float": _wanted("a whole number"),
    "int_parsing": _wanted("a whole number"),
    "bool_type": _wanted("true or false"),
    "bool_parsing": _wanted("true or false"),
    "dict_type": _wanted("a mapping 'key: value'"),
    "model_type": _wanted("a mapping 'key: value'"),
    "list_type": _wanted("a list"),
    "tuple_type": _wanted("a list"),
}


def _value(place: Place, document: Document) -> Any:
    value = document.data
    for key in place:
        value = value[key]
    return value


def _field(place: Place, document: Document, model: type[BaseModel]) -> FieldInfo | None:
    """Return the field that a place fills; for an item of a list or mapping the field of that."""
    found: FieldInfo | None = None
    current: type[BaseModel] | None = model
    for position, key in enumerate(place):
        if current is not None and key in current.model_fields:
            found = current.model_fields[key]
            current = None
        elif current is not None:
            return None
        current = _model_of(found, place[: position + 1], document) or current
    return found


def _known_keys(place: Place, document: Document, model: type[BaseModel]) -> list[str]:
    field = _field(place, document, model)
    inner = _model_of(field, place, document) if field is not None else model
    if inner is None:
        return []
    choice = _choice(field) if field is not None else None
    return [*inner.model_fields, *(choice.also() if choice else ())]


def _model_of(field: FieldInfo | None, place: Place, document: Document) -> type[BaseModel] | None:
    """Return the model of the mapping at ``place``, which lies in ``field``."""
    if field is None or not document.has(place):
        return None
    data = _value(place, document)
    if choice := _choice(field):
        return choice.model_for(data)
    return _inner_model(field.annotation) if isinstance(data, dict) else None


def _choice(field: FieldInfo) -> Choice | None:
    return _find(field.annotation, Choice) or next(
        (entry for entry in field.metadata if isinstance(entry, Choice)), None
    )


def _find(annotation: Any, kind: type) -> Any:
    for entry in getattr(annotation, "__metadata__", ()):
        if isinstance(entry, kind):
            return entry
    for part in get_args(annotation):
        if found := _find(part, kind):
            return found
    return None


def _inner_model(annotation: Any) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    if get_origin(annotation) in (Union, types.UnionType, tuple, dict, list):
        for part in get_args(annotation):
            if found := _inner_model(part):
                return found
    return None

"""pydantic's errors as one plain line each: where, what is wrong, what would be right."""

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from softact.errors import SpecError
from softact.fields import given
from softact.files.document import Document, Place, dotted
from softact.nearest import nearest
from softact.spec.slots import slot_at
from softact.units import dimension_of, show

MAX_LINES = 60

AnyModel = TypeVar("AnyModel", bound=BaseModel)


def validated(document: Document, model: type[AnyModel]) -> AnyModel:
    """Return what a document holds as a model. Raises SpecError with a line for each fault."""
    try:
        return model.model_validate(document.data)
    except ValidationError as error:
        raise SpecError(*fault_lines(error, document, model)) from None


def fault_lines(error: ValidationError, document: Document, model: type[BaseModel]) -> list[str]:
    """Return a line for each fault in ``error``, in the order of the document's lines."""
    lines = {}
    for entry in error.errors(include_url=False):
        place = _place(entry, document, model)
        if _follows(entry, place, document):
            continue
        for text in _text(entry, place, document, model).splitlines():
            at = f"{dotted(place)}: " if place else ""
            lines[f"{document.where(place)}: {at}{text}"] = _order(place, document)
    ordered = sorted(lines, key=lines.__getitem__)
    if len(ordered) > MAX_LINES:
        more = len(ordered) - MAX_LINES
        return [*ordered[:MAX_LINES], f"{document.name}: and {more} more faults"]
    return ordered


def _follows(entry: Mapping[str, Any], place: Place, document: Document) -> bool:
    """Whether a list is called too short only because its entries have faults, told already."""
    short = entry["type"] == "too_short"
    return short and len(_given(place, document)) >= entry["ctx"]["min_length"]


def _order(place: Place, document: Document) -> int:
    for length in range(len(place), -1, -1):
        if place[:length] in document.lines:
            return document.lines[place[:length]]
    return 0


def _place(entry: Mapping[str, Any], document: Document, model: type[BaseModel]) -> Place:
    """Return where the fault stands in the document, without what only pydantic knows of."""
    place: Place = ()
    for key in entry["loc"]:
        # What is not there can be at fault: it is missing, or its default does not fit.
        if document.has((*place, key)) or _may_hold(place, key, document, model):
            place = (*place, key)
    return place


def _may_hold(place: Place, key: Any, document: Document, model: type[BaseModel]) -> bool:
    """Whether a place that the document lacks is one of a spec, and no word of pydantic's."""
    slot, there = slot_at(model, document, place), _given(place, document)
    if slot is None or not isinstance(there, dict) or not isinstance(key, str):
        return False
    return slot.is_a(dict) or key in slot.keys(there)


def _text(
    entry: Mapping[str, Any], place: Place, document: Document, model: type[BaseModel]
) -> str:
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
    slot = slot_at(model, document, place[:-1])
    known = slot.keys(_given(place[:-1], document)) if slot else []
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
        return f"{show(_given(place, document))} must be {relation} {bound}"

    return text


def _wanted(kind: str) -> Callable[..., str]:
    def text(entry: dict, place: Place, document: Document, model: type[BaseModel]) -> str:
        field = _field(place, document, model)
        means = ""
        if field is not None and field.description and isinstance(place[-1], str):
            means = f" ({field.description})"
        return f"{given(_given(place, document))}; {kind} is wanted{means}"

    return text


def _pattern(entry: dict, place: Place, document: Document, model: type[BaseModel]) -> str:
    return (
        f"{show(entry['input'])} is no name here; use small letters, digits, '_' and '-', "
        "at most 64, for example 'finger_1'"
    )


def _short(entry: dict, place: Place, document: Document, model: type[BaseModel]) -> str:
    field, least = _field(place, document, model), entry["ctx"]["min_length"]
    means = f" ({field.description})" if field is not None and field.description else ""
    count = f"{len(_given(place, document))} entries" if _given(place, document) else "empty"
    return f"{count}; {least} or more are wanted{means}"


_TEXTS: dict[str, Callable[..., str]] = {
    "missing": _missing,
    "extra_forbidden": _extra,
    "literal_error": _literal,
    "greater_than": _bound("greater than", "gt"),
    "greater_than_equal": _bound("at least", "ge"),
    "less_than": _bound("less than", "lt"),
    "less_than_equal": _bound("at most", "le"),
    "string_type": _wanted("text"),
    "path_type": _wanted("the name of a file"),
    "string_pattern_mismatch": _pattern,
    "too_short": _short,
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


def _given(place: Place, document: Document) -> Any:
    """What the document has at a place; what it lacks counts as empty."""
    return document.value(place) if document.has(place) else {}


def _field(place: Place, document: Document, model: type[BaseModel]) -> FieldInfo | None:
    """Return the field that a place fills; for an item of a list or mapping the field of that."""
    slot = slot_at(model, document, place)
    return slot.field if slot else None

"""What the models say of the places of a document: which field stands there, with which keys."""

import types
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel, TypeAdapter
from pydantic.fields import FieldInfo

from softact.files.document import Document, Place, item
from softact.spec.choice import Choice


@dataclass(frozen=True)
class Slot:
    """What may stand at a place.

    annotation: its type. metadata: what stands beside the type in ``Annotated``. field: the one
    that it fills, or of whose list or mapping it is an entry; None at the top.
    """

    annotation: Any
    metadata: tuple[Any, ...] = ()
    field: FieldInfo | None = None

    @cached_property
    def types(self) -> tuple[Any, ...]:
        """Each type that may stand here, without what stands beside it in ``Annotated``."""
        return tuple(kind for kind, _ in _alternatives(self.annotation, self.metadata))

    @cached_property
    def marks(self) -> tuple[Any, ...]:
        """What stands beside the types that may stand here in ``Annotated``."""
        kinds = _alternatives(self.annotation, self.metadata)
        return tuple(mark for _, metadata in kinds for mark in metadata)

    @cached_property
    def choice(self) -> Choice | None:
        """What looks up the model of a value here, None where the type itself says it."""
        return next((mark for mark in self.marks if isinstance(mark, Choice)), None)

    def model(self, data: Any) -> type[BaseModel] | None:
        """Return the model of the value ``data`` that stands here, None where it has none."""
        if self.choice:
            return self.choice.model_for(data)
        if not isinstance(data, dict):
            return None
        return next((kind for kind in self.types if _is_model(kind)), None)

    def keys(self, data: Any) -> list[str]:
        """Return the keys that the model of the value ``data`` knows."""
        model, choice = self.model(data), self.choice
        fields = () if model is None else _slots(model)
        return list(dict.fromkeys((*fields, *(choice.also() if choice else ()))))

    def inside(self, key: str | int, data: Any) -> "Slot | None":
        """Return the slot of ``key`` in the value ``data`` that stands here, None where there is
        none. Any word is a key of a mapping, and any number a place of a list."""
        if isinstance(data, dict):
            if model := self.model(data):
                return _slots(model).get(str(key))
            entry = self._entries.get(dict)
            return entry[0] if entry and isinstance(key, str) else None
        if not isinstance(data, list) or not isinstance(key, int):
            return None
        entries = self._entries.get(list, ())
        number = 0 if len(entries) == 1 else key
        return entries[number] if number < len(entries) else None

    @cached_property
    def _entries(self) -> dict[type, tuple["Slot", ...]]:
        """dict, list -> the slots of what may stand in it: one where all entries are alike."""
        found: dict[type, tuple[Slot, ...]] = {}
        for kind in self.types:
            origin, arguments = get_origin(kind), get_args(kind)
            if origin is dict:
                found[dict] = (Slot(arguments[1], (), self.field),)
            elif origin in (tuple, list):
                each = arguments[:1] if origin is list or arguments[-1] is Ellipsis else arguments
                found[list] = tuple(Slot(one, (), self.field) for one in each)
        return found

    def is_a(self, kind: type) -> bool:
        """Whether a ``list`` or a ``dict`` may stand here."""
        return kind in self._entries

    def default(self) -> Any:
        """Return what a file that is silent means by the field here, as plain data."""
        if self.field is None or self.field.is_required():
            return None
        value = self.field.get_default()
        kind: Any = (
            Annotated[(self.annotation, *self.metadata)] if self.metadata else self.annotation
        )
        return None if value is None else TypeAdapter(kind).dump_python(value, mode="json")


def _alternatives(kind: Any, metadata: tuple[Any, ...]) -> Iterator[tuple[Any, tuple[Any, ...]]]:
    """Each type of a union, with what stands beside it in ``Annotated``."""
    if get_origin(kind) is Annotated:
        yield from _alternatives(kind.__origin__, (*metadata, *kind.__metadata__))
    elif get_origin(kind) in (Union, types.UnionType):
        for part in get_args(kind):
            yield from _alternatives(part, metadata)
    else:
        yield kind, metadata


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


@cache
def _slots(model: type[BaseModel]) -> dict[str, Slot]:
    """Key -> slot of the fields of a model."""
    return {
        field.alias or name: Slot(field.annotation, tuple(field.metadata), field)
        for name, field in model.model_fields.items()
    }


@cache
def _top(model: type[BaseModel]) -> Slot:
    return Slot(model)


def slot_at(model: type[BaseModel], document: Document, place: Place) -> Slot | None:
    """Return what may stand at ``place``, None where the model has no such place.

    What the document lacks on the way counts as empty, so a slot may be found all the same.
    """
    slot, value = _top(model), document.data
    for key in place:
        inner = slot.inside(key, value)
        if inner is None:
            return None
        slot = inner
        try:
            value = item(value, key)
        except LookupError:
            value = [] if slot.is_a(list) else {}
    return slot


def walk(model: type[BaseModel], data: Any) -> Iterator[tuple[Place, Slot, Any]]:
    """Yield (place, slot, value) of every value that has a place in the model, outer ones first."""
    todo: list[tuple[Place, Slot, Any]] = [((), _top(model), data)]
    while todo:
        place, slot, value = todo.pop()
        yield place, slot, value
        pairs: Iterable[tuple[Any, Any]] = ()
        if isinstance(value, dict | list):
            pairs = value.items() if isinstance(value, dict) else enumerate(value)
        inner = [
            ((*place, key), entry_slot, entry)
            for key, entry in pairs
            if (entry_slot := slot.inside(key, value)) is not None
        ]
        todo += reversed(inner)

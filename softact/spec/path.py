"""Dotted paths into a spec, such as ``steps.1.pressure`` or ``sheets.pouches.plies.0.thickness``.

Entries of a list are named by their place, counted from 0, or by their ``name``. A path is one for
``--set``, the axes of a sweep, the parameters of an optimisation, ``--vary`` and the columns of
``summary.csv`` alike; whatever walks along a path does it here.
"""

import copy
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from softact.errors import SpecError
from softact.files.document import Document, Place, dotted, item
from softact.nearest import nearest
from softact.spec.slots import Slot, slot_at
from softact.units import one_line, show

#: Lists of a spec whose entries are called by a word and their number where they have no name.
UNNAMED = {"steps": "step", "contact": "contact"}


def parts(path: str) -> list[str]:
    """Return the keys of a path. Raises SpecError where one of them is empty."""
    keys = [key.strip() for key in path.split(".")]
    if not all(keys):
        raise SpecError(f"{show(path)} is no path; write for example steps.0.pressure")
    return keys


def joined(place: Place) -> str:
    """Return the path of a place."""
    return ".".join(map(str, place))


def locate(data: Any, path: str) -> Place:
    """Return the place in plain data that a path names.

    Raises SpecError that says where the path leaves the data, and what is there.
    """
    place: Place = ()
    rest, value = parts(path), data
    while rest:
        key, rest = _next(value, rest, place)
        if isinstance(value, dict) and key not in value:
            here = dotted(place) or "the spec"
            raise SpecError(f"{here} has no value {show(key)}; {nearest(key, value)}")
        value, place = item(value, key), (*place, key)
    return place


def get(data: Any, path: str) -> Any:
    """Return the value at a path of plain data. Raises SpecError as ``locate`` does."""
    return Document("", data).value(locate(data, path))


def single(data: Any, path: str) -> tuple[Place, Any]:
    """Return place and value of the one value that a path stands for.

    A mapping with one entry, such as ``pressure: {cavity: 30 kPa}``, stands for its value. Raises
    SpecError where there is no value, or there are several.
    """
    place = locate(data, path)
    found = [(inner, value) for inner, value in leaves(Document("", data).value(place))]
    if len(found) != 1 or len(found[0][0]) > 1:
        inside = dict.fromkeys(str(inner[0]) for inner, _ in found if inner)
        raise SpecError(f"stands for several values; name one of {', '.join(inside)}")
    ((inner, value),) = found
    return (*place, *inner), value


def leaves(data: Any) -> Iterator[tuple[Place, Any]]:
    """Yield (place, value) of every single value in plain data; an empty list or mapping is one."""
    todo: list[tuple[Place, Any]] = [((), data)]
    while todo:
        place, value = todo.pop()
        if isinstance(value, dict | list) and value:
            pairs = value.items() if isinstance(value, dict) else enumerate(value)
            todo += reversed([((*place, key), entry) for key, entry in pairs])
        else:
            yield place, value


def assign(document: Document, path: str, value: Any, where: str, model: type[BaseModel]) -> Place:
    """Set plain data at a path of a spec's document; ``where``: how a message about it begins;
    ``model``: of the whole document.

    Mappings on the way that the document lacks are made, and a short form on the way, such as the
    name of a material card, is written out. Raises SpecError where the path leads nowhere.
    """
    place: Place = ()
    rest, target = parts(path), document.data
    slot: Slot | None = Slot(model)
    while True:
        key, rest = _next(target, rest, place)
        slot = slot.inside(key, target) if slot else None
        if not rest:
            break
        place = (*place, key)
        if isinstance(target, dict) and target.get(key) is None:
            target[key] = _made(slot, place)
            document.overridden[place] = where
        if slot and slot.choice:
            target[key] = slot.choice.written_out(target[key])
        target = target[key]
    target[key] = copy.deepcopy(value)
    place = (*place, key)
    for known in (document.lines, document.overridden):
        for inner in [inner for inner in known if inner[: len(place)] == place]:
            del known[inner]
    document.overridden[place] = where
    return place


def _made(slot: Slot | None, place: Place) -> Any:
    """What is put on the way to a value where a document has nothing: a mapping, or a list with
    the entries that it has by default."""
    if slot is None or not slot.is_a(list):
        return {}
    if entries := slot.default():
        return entries
    raise SpecError(f"{show(dotted(place))} is not in the file; set the whole list")


def replaced(path: str, value: Any) -> str:
    """How a message begins about a value that the command line, or a program, sets at a path."""
    return f"--set {one_line(path)}={show(value)[1:-1]}"


def check(document: Document, place: Place, model: type[BaseModel]) -> None:
    """Raise SpecError where a spec has no such place, as far as the document tells its kind."""
    for length, key in enumerate(place):
        slot = slot_at(model, document, place[:length])
        if slot is None:
            return
        data = document.value(place[:length]) if document.has(place[:length]) else {}
        known = slot.keys(data)
        if slot.model(data) is not None and key not in known:
            here = dotted(place[:length]) or "a spec"
            raise SpecError(f"{here} has no {show(key)}; {nearest(key, known)}")


def _next(value: Any, keys: list[str], place: Place) -> tuple[str | int, list[str]]:
    """Return the first key of a path, as ``value`` at ``place`` has it, and the keys after it."""
    if isinstance(value, dict):
        # Names out of a CAD program may hold dots themselves.
        for count in range(len(keys), 1, -1):
            if ".".join(keys[:count]) in value:
                return ".".join(keys[:count]), keys[count:]
        return keys[0], keys[1:]
    if not isinstance(value, list):
        raise SpecError(f"'{dotted(place)}' is a single value and has no {show(keys[0])}")
    return _entry(value, keys[0], place), keys[1:]


def _entry(entries: list[Any], key: str, place: Place) -> int:
    """Return the place of the entry of a list that ``key`` names."""
    if key.isdecimal() and len(key) < 9 and int(key) < len(entries):
        return int(key)
    word = UNNAMED.get(str(place[0])) if len(place) == 1 else None
    names: dict[str, int] = {}
    for number, entry in enumerate(entries):
        name = entry.get("name") if isinstance(entry, dict) else None
        name = name or (word and f"{word}_{number + 1}")
        if isinstance(name, str):
            names.setdefault(name, number)
    if key in names:
        return names[key]
    count = f"{len(entries)} entries, counted from 0" if entries else "no entries"
    hint = f"; {nearest(key, names)}" if names else ""
    raise SpecError(f"'{dotted(place)}' has no entry {show(key)} (it has {count}){hint}")

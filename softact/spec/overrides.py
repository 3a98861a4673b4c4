"""``--set path=value``: values of a spec replaced from outside its file."""

from typing import Any

from softact.errors import SpecError
from softact.spec.choice import nearest
from softact.spec.document import Document, Place, scalar
from softact.units import show


def apply(document: Document, overrides: tuple[str, ...] | list[str]) -> None:
    """Set each ``path=value`` in the document. A path is dotted: ``steps.1.pressure=30 kPa``.

    Items of a list are named by their place, counted from 0, or by their ``name``. Mappings on
    the way that the file lacks are made. Raises SpecError, one line per override that cannot be.
    """
    faults = []
    for text in overrides:
        try:
            _set(document, text)
        except SpecError as error:
            faults += [f"--set {show(text)[1:-1]}: {line}" for line in error.lines]
    if faults:
        raise SpecError(*faults)


def _set(document: Document, text: str) -> None:
    path, equals, written = text.partition("=")
    if not equals or not all(key.strip() for key in path.split(".")):
        raise SpecError("write a dotted path, '=' and a value, for example steps.0.pressure=30 kPa")
    assign(document, path, scalar(written), text)


def assign(document: Document, path: str, value: Any, text: str) -> None:
    """Set the plain data ``value`` at a dotted path; ``text`` stands for it in messages.

    Raises SpecError where the path leads nowhere.
    """
    keys = [key.strip() for key in path.split(".")]
    place: Place = ()
    target: Any = document.data
    for key in keys[:-1]:
        step = _key(target, key, place)
        if isinstance(target, dict) and target.get(step) is None:
            target[step] = {}
            document.overridden[(*place, step)] = show(text)[1:-1]
        if isinstance(target[step], str) and _is_material((*place, step)):
            target[step] = {"card": target[step]}  # so that a constant of the card can be set
        target, place = target[step], (*place, step)
    last = _key(target, keys[-1], place)
    target[last] = value
    place = (*place, last)
    for known in [known for known in document.lines if known[: len(place)] == place]:
        del document.lines[known]
    for known in [known for known in document.overridden if known[: len(place)] == place]:
        del document.overridden[known]
    document.overridden[place] = show(text)[1:-1]


def _key(target: Any, key: str, place: Place) -> str | int:
    at = ".".join(map(str, place))
    if isinstance(target, dict):
        return key
    if not isinstance(target, list):
        raise SpecError(f"'{at}' is a single value and has no '{show(key)[1:-1]}'")
    if key.isdecimal() and int(key) < len(target):
        return int(key)
    names = [entry.get("name") for entry in target if isinstance(entry, dict)]
    if key in names:
        return names.index(key)
    count = f"{len(target)} entries, counted from 0" if target else "no entries"
    known = [name for name in names if isinstance(name, str)]
    hint = f"; {nearest(key, known)}" if known else ""
    raise SpecError(f"'{at}' has no entry {show(key)} (it has {count}){hint}")


def _is_material(place: Place) -> bool:
    one_of_regions = len(place) == 2 and place[0] == "materials"
    return one_of_regions or (len(place) == 3 and place[0] == "layers" and place[2] == "material")

"""How a spec is read: the one way that every command goes.

A file becomes a document, in which overrides are set and every file that it names is found from
where it is named; a document becomes a spec, with cards of the user's own read in. Between the two
a sweep sets the values of its points.
"""

import contextlib
import os
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from softact.errors import SpecError
from softact.files import document
from softact.files.document import Document, Place
from softact.files.text import NAMES_A_FILE
from softact.spec import card_files, overrides
from softact.spec.choice import MaterialChoice
from softact.spec.faults import validated
from softact.spec.kinds import expect, read_as
from softact.spec.models import Spec
from softact.spec.path import assign, replaced
from softact.spec.slots import walk


def load(path: str | Path, overrides: Sequence[str] = ()) -> Spec:
    """Read the spec in a YAML file; ``overrides`` are ``path=value`` and win over the file.

    Raises SpecError with one line per fault, ``file:line: path: what is wrong; what is right``.
    """
    return spec_at(opened(path, overrides))


def loads(text: str, name: str = "spec", overrides: Sequence[str] = ()) -> Spec:
    """Return the spec in YAML text; ``name`` stands for the file in messages. See ``load``.

    Files that it names count from the working folder.
    """
    source = document.parse(text, name)
    expect(source, "spec")
    return spec_at(_with(source, overrides))


def opened(path: str | Path, overrides: Sequence[str] = ()) -> Document:
    """Return the spec in a YAML file as plain data, see ``load``; its values are not checked yet.

    Raises SpecError where there is no such file, or one of another kind.
    """
    return _with(read_as(Path(path), "spec"), overrides)


def part(source: Document, key: str, name: str) -> Document:
    """Return the spec that a file names, or holds itself, under ``key``, as plain data.

    name: of the spec where it has none. What is set in it later counts from the folder of
    ``source``. Raises SpecError where there is no such file.
    """
    there = source.data[key]
    if isinstance(there, str):
        try:
            found = opened(source.folder / os.path.expanduser(there))
        except SpecError as error:
            raise SpecError(*(f"{source.where((key,))}: {key}: {e}" for e in error.lines)) from None
    else:
        found = source.within(key)
        find_files(found)
    found.data.setdefault("name", name)
    found.folder = source.folder
    return found


def spec_at(source: Document, changes: Iterable[tuple[str, Any]] = ()) -> Spec:
    """Return the spec that a document holds, with values at paths replaced; it stays as it is.

    Raises SpecError with one line per fault.
    """
    here = source.copy()
    for path, value in changes:
        assign(here, path, value, replaced(path, value))
    here.data.setdefault("name", name_of(here.name))
    faults = card_files.insert(here, find_files(here))
    try:
        spec = validated(here, Spec)
    except SpecError as error:
        faults += error.lines
    if faults:
        raise SpecError(*faults)
    return spec


def find_files(source: Document) -> list[Place]:
    """Make the name of each file in a spec, which counts from where it is named, an absolute one.

    Such are the cards of the user's own, whose places are returned, and the files of imported
    geometries.
    """
    cards, files = [], []
    for place, slot, value in walk(Spec, source.data):
        if isinstance(slot.choice, MaterialChoice):
            if isinstance(value, dict):
                place, value = (*place, "card"), value.get("card")
            if isinstance(value, str) and card_files.is_file(value):
                cards.append(place)
        elif NAMES_A_FILE in slot.metadata and isinstance(value, str):
            files.append(place)
    for place in (*cards, *files):
        path = source.folder / os.path.expanduser(source.value(place))
        with contextlib.suppress(ValueError):  # a name that no file can have, which is told later
            source.value(place[:-1])[place[-1]] = os.path.realpath(path)
    return cards


def _with(source: Document, changes: Sequence[str]) -> Document:
    overrides.apply(source, changes)
    find_files(source)
    return source


def name_of(file: str) -> str:
    """Return the name of a spec, or of a study, that has none of its own: that of its file."""
    return re.sub(r"[^a-z0-9_-]+", "_", Path(file).stem.lower()).strip("_-")[:64] or "actuator"

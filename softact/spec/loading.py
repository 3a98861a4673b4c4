"""How a spec is read: the one way that every command goes.

A file becomes a document, in which overrides are set and every file that it names is found from
where it is named; a document becomes a spec, with cards of the user's own read in. Between the two
a sweep sets the values of its points.
"""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from softact.errors import SpecError
from softact.files import document
from softact.files.document import Document
from softact.spec import overrides
from softact.spec.building import built, find_files
from softact.spec.kinds import expect, read_as
from softact.spec.models import Spec


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
        find_files(found, Spec)
    found.data.setdefault("name", name)
    found.folder = source.folder
    return found


def spec_at(source: Document, changes: Iterable[tuple[str, Any]] = ()) -> Spec:
    """Return the spec that a document holds, with values at paths replaced; it stays as it is.

    Raises SpecError with one line per fault.
    """
    return built(source, changes, Spec)


def _with(source: Document, changes: Sequence[str]) -> Document:
    overrides.apply(source, changes)
    find_files(source, Spec)
    return source

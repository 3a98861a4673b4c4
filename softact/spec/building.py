"""From a document to a model of the spec: values are set, files found, cards read in.

Of whatever model: a spec has a method that makes another, and stands above this.
"""

import contextlib
import os
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel

from softact.errors import SpecError
from softact.files.document import Document, Place
from softact.files.text import NAMES_A_FILE
from softact.spec import card_files
from softact.spec.choice import MaterialChoice
from softact.spec.faults import validated
from softact.spec.path import assign, replaced
from softact.spec.slots import walk

Kind = TypeVar("Kind", bound=BaseModel)


def built(source: Document, changes: Iterable[tuple[str, Any]], model: type[Kind]) -> Kind:
    """Return what a document holds, with values at paths replaced; it stays as it is.

    Raises SpecError with one line per fault.
    """
    here = source.copy()
    for path, value in changes:
        assign(here, path, value, replaced(path, value), model)
    here.data.setdefault("name", name_of(here.name))
    faults = card_files.insert(here, find_files(here, model))
    try:
        made = validated(here, model)
    except SpecError as error:
        faults += error.lines
    if faults:
        raise SpecError(*faults)
    return made


def changed(made: Kind, changes: Iterable[tuple[str, Any]]) -> Kind:
    """Return a copy of a spec with values at paths replaced, validated anew; files that they name
    count from the working folder. Raises SpecError."""
    data = made.model_dump(mode="json", exclude_none=True)
    return built(Document("spec", data), changes, type(made))


def find_files(source: Document, model: type[BaseModel]) -> list[Place]:
    """Make the name of each file in a spec, which counts from where it is named, an absolute one.

    Such are the cards of the user's own, whose places are returned, and the files of imported
    geometries.
    """
    cards, files = [], []
    for place, slot, value in walk(model, source.data):
        if isinstance(slot.choice, MaterialChoice):
            if isinstance(value, dict):
                place, value = (*place, "card"), value.get("card")
            if isinstance(value, str) and card_files.is_file(value):
                cards.append(place)
        elif NAMES_A_FILE in slot.marks and isinstance(value, str):
            files.append(place)
    for place in (*cards, *files):
        path = source.folder / os.path.expanduser(source.value(place))
        with contextlib.suppress(ValueError):  # a name that no file can have, which is told later
            source.value(place[:-1])[place[-1]] = os.path.realpath(path)
    return cards


def name_of(file: str) -> str:
    """Return the name of a spec, or of a study, that has none of its own: that of its file."""
    return re.sub(r"[^a-z0-9_-]+", "_", Path(file).stem.lower()).strip("_-")[:64] or "actuator"

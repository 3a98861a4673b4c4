"""Loads of which a step may have one or several: a mapping, or a list of mappings."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from types import GenericAlias
from typing import Annotated, Any

import numpy as np
from pydantic import Discriminator, Field, Tag

from softact.fields import Part, Place
from softact.system.term import Value


def _how_many(value: Any) -> str:
    return "several" if isinstance(value, list | tuple) else "one"


def one_or_several(part: type[Part]) -> Any:
    """The type of a step's value: a part, or a list of one or more of them."""
    parts: Any = GenericAlias(tuple, (part, ...))
    several: Any = Annotated[parts, Field(strict=False, min_length=1), Tag("several")]
    one: Any = Annotated[part, Tag("one")]
    return Annotated[one | several, Discriminator(_how_many)]


def entries(value: Any) -> tuple[Any, ...]:
    """All parts of a value of a step; none where the step leaves the load alone."""
    if value is None:
        return ()
    return tuple(value) if isinstance(value, list | tuple) else (value,)


def placed(written: Any, place: Place) -> Iterator[tuple[Any, Place]]:
    """Each part of a step's value, or of the plain data of it, with its place."""
    if isinstance(written, list | tuple):
        yield from ((entry, (*place, index)) for index, entry in enumerate(written))
    elif written is not None:
        yield written, place


def added_up(loads: Iterable[tuple[str, np.ndarray]]) -> dict[str, Value]:
    """{surface: sum of the loads on it}."""
    found: dict[str, Value] = {}
    for surface, load in loads:
        found[surface] = found.get(surface, 0.0) + load
    return found

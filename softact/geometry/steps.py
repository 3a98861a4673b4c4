"""Into how many steps a mesh divides a length."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from math import ceil
from typing import Any

#: A step may be longer than was asked for by this part. Lengths that are a whole number of steps,
#: as those of most specs are, then keep their number when they change a little or are rounded.
SLACK = 0.002


class OtherCountsError(Exception):
    """A mesh is divided otherwise than the one whose numbers of steps it was to have."""


#: What a mesh is repeated from: numbers of steps, and sections, in the order in which it asked.
Tape = list[Any]


@dataclass
class _Numbers:
    """The tape of a mesh, and how far it has been read."""

    known: Tape = field(default_factory=list)
    fixed: bool = False
    used: int = 0

    def take(self, number: Any) -> Any:
        """What to use where a mesh would have ``number``. Raises OtherCountsError."""
        if not self.fixed:
            self.known.append(number)
        elif self.used == len(self.known):
            raise OtherCountsError
        self.used += 1
        return self.known[self.used - 1]


_NUMBERS: ContextVar[_Numbers | None] = ContextVar("numbers", default=None)


def steps(length: float, size: float, least: int = 1) -> int:
    """Number of equal steps along a length so that none is longer than ``size``, but for SLACK;
    at least ``least``. Within ``repeated``, that of the mesh which is repeated."""
    number = max(least, ceil(length / size / (1 + SLACK)))
    kept = _NUMBERS.get()
    return number if kept is None else kept.take(number)


def repeatable(
    make: Callable[[], None], keep: Callable[[], Any], put: Callable[[Any], None]
) -> None:
    """Make a part of a mesh. keep: what of it, once it is made; put: what is done instead, with
    what was kept of the mesh that is repeated, within ``repeated``."""
    kept = _NUMBERS.get()
    if kept is not None and kept.fixed:
        put(kept.take(None))
        return
    with _as_present(None):  # its own steps are part of it
        make()
    if kept is not None:
        kept.take(keep())


@contextmanager
def recorded() -> Iterator[Tape]:
    """A list of the numbers of steps that a mesh asks for meanwhile, in their order."""
    numbers = _Numbers()
    with _as_present(numbers):
        yield numbers.known


@contextmanager
def repeated(known: Tape) -> Iterator[None]:
    """Meanwhile a mesh has the numbers of steps of another one, as ``recorded`` gave them: a solid
    whose lengths have changed a little keeps its cells. Raises OtherCountsError where it asks for
    more or fewer of them."""
    numbers = _Numbers(known, fixed=True)
    with _as_present(numbers):
        yield
    if numbers.used != len(known):
        raise OtherCountsError


@contextmanager
def _as_present(numbers: _Numbers | None) -> Iterator[None]:
    token = _NUMBERS.set(numbers)
    try:
        yield
    finally:
        _NUMBERS.reset(token)

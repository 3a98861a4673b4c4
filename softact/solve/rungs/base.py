"""What a rung of the ladder is: one way to go on where the next equilibrium is not found."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from softact.solve.walk import Walk


@dataclass
class Trouble:
    """Why the ladder is asked.

    begins: the step is about to begin. ahead: a limit point is so near that load control would
    fail. failed: why an attempt has failed, "" where none has. limit: why the load cannot be
    reached, as a rung has found out, and snap: the same, where a later rung gets past. apart: see
    ``NewtonOutcome``.
    """

    begins: bool = False
    ahead: bool = False
    failed: str = ""
    limit: str | None = None
    snap: str | None = None
    apart: float = 1.0


class Went(enum.Enum):
    """How a rung ended: load control goes on, or the next rung is asked."""

    ON = enum.auto()
    NOT = enum.auto()


@dataclass(frozen=True)
class Stopped:
    """No way on: the step ends here, and why."""

    why: str


class Rung(Protocol):
    """One way to go on. ``RUNGS`` in ``softact.solve.rungs`` holds them in their order."""

    name: str

    def may(self, walk: Walk, trouble: Trouble) -> bool:
        """Whether this rung has something to try now."""

    def climb(self, walk: Walk, trouble: Trouble) -> Went | Stopped:
        """Try it. The walk stands at an accepted state afterwards, however it went."""

"""What became of the runs, in ``results.json``: read by the page, written by ``--compute``."""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pydantic import Field

from published.figures import HERE, Figure, Run, Strict
from softact.files.text import write_atomic

STORE = HERE / "results.json"

COMPLETE, NO_EQUILIBRIUM, STOPPED, FAILED = "complete", "no_equilibrium", "stopped", "failed"


class Outcome(Strict):
    """How a run ended, and what was read off it.

    input: fingerprint of what was computed. status: "complete", "no_equilibrium" (exit code 4),
    "stopped" (by us: it took too long) or "failed" (mesh or solver). cause: why it is not complete.
    seconds: wall time. commit: of the sources that computed it, or of the page from which its
    figures were taken over; then it has no size and no time. readings: id of the figure -> what
    was read (``read``) and what was found (``value``; where the run ended before, ``last``).
    """

    input: str
    status: str
    cause: str = ""
    seconds: float | None = None
    cells: int | None = None
    unknowns: int | None = None
    commit: str
    taken_over: bool = False
    readings: dict[str, dict[str, Any]] = Field(default_factory=dict)

    def is_of(self, run: Run) -> bool:
        """Whether the run is still written as it was when it was computed."""
        return self.input == run.fingerprint()

    def reading(self, figure: Figure) -> dict[str, Any] | None:
        """What was read for a figure; None where it was not, or in another way."""
        found = self.readings.get(figure.id)
        return found if found and found["read"] == asked(figure) else None


def asked(figure: Figure) -> dict[str, Any]:
    """The reading of a figure as plain data."""
    return figure.read.model_dump(mode="json", exclude_defaults=True)


def read(path: Path = STORE) -> dict[str, Outcome]:
    """Run -> how it ended."""
    stored = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    return {name: Outcome.model_validate(data) for name, data in stored.items()}


def store(name: str, outcome: Outcome, path: Path = STORE) -> None:
    """Put one run into the file; others may do the same at the same time."""
    with _alone(path):
        known = read(path) | {name: outcome}
        write_atomic(path, _text(known))


def _text(known: Mapping[str, Outcome]) -> str:
    data = {
        name: known[name].model_dump(mode="json", exclude_defaults=True) for name in sorted(known)
    }
    return json.dumps(data, indent=1, ensure_ascii=False) + "\n"


@contextmanager
def _alone(path: Path) -> Iterator[None]:
    """Hold a lock on the file's folder."""
    handle = os.open(path.parent, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)

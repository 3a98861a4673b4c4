"""The derivatives beside a run: from state to state into the result folder."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from softact.sensitivities.table import Table, kept, pressures

if TYPE_CHECKING:
    from softact.results.writer import ResultsWriter
    from softact.sensitivities.following import Following
    from softact.solve.checkpoint import Checkpoint
    from softact.solve.progress import Attempt
    from softact.system.term import State


class Slopewise:
    """Writes the derivatives at each accepted state. time: seconds spent on them."""

    def __init__(
        self, following: Following, writer: ResultsWriter | None, start: Checkpoint | None = None
    ):
        self.following, self._writer = following, writer
        before = kept(writer.sensitivities_so_far, start.rows) if writer and start else ""
        self.table = Table([twin.parameter for twin in following.twins], before)
        self.time = 0.0
        self.notes: list[str] = []

    def accept(self, state: State, attempt: Attempt, number: int, row: Mapping[str, Any]) -> None:
        """Take down what hangs on what at a state whose row of curve.csv is given. Collective."""
        started = time.perf_counter()
        before = self.following.ended
        slopes = self.following.accept(state, attempt, number, row)
        if slopes is not None and self._writer is not None:
            self.table.add(row, slopes)
            self._writer.sensitivities(self.table.text)
        if self.following.ended and not before:
            self.notes.append(_ended(row, self.following.ended))
        self.time += time.perf_counter() - started


def _ended(row: Mapping[str, Any], why: str) -> str:
    """From where on there are no derivatives."""
    loads = ", ".join(f"{row[name]:.4g} kPa" for name in pressures(row))
    where = loads or f"{row['step_fraction']:.2%}"
    return f"sensitivities: not available from {where} of step '{row['step']}' on: {why}"

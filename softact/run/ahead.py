"""What of a run's report is made before the run has ended."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from queue import SimpleQueue
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    from softact.report.making import Report
    from softact.verdict.judge import Verdict


class Ahead:
    """The report of a run, in a thread of its own as long as the solver is at work: the process
    that starts the solver has nothing else to do then.

    Libraries are loaded once there is a mesh, and what the states alone decide is made while the
    solver judges them. wanted: whether anything is done ahead.
    """

    def __init__(self, directory: Path, wanted: bool = True):
        self._directory = directory
        self._wanted = wanted
        self._report: Report | None = None
        self._tasks: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        self._thread: threading.Thread | None = None
        self._written = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *problem: object) -> None:
        self._tasks.put(None)
        # Where a run is broken off nobody waits for what is loaded, only for what writes.
        if self._report is not None:
            self._wait()
            self._report.__exit__(*problem)

    def meshed(self) -> None:
        """The solver begins to seek states."""
        if self._wanted and self._thread is None:
            self._thread = threading.Thread(target=self._work, daemon=True)
            self._thread.start()
            self._tasks.put(self._prepare)

    def solved(self, status: str) -> None:
        """All states are in the folder."""
        self._tasks.put(lambda: self._begin(status))

    def judged(self, verdict: Verdict | None) -> None:
        """All that the report tells is in the folder; the solver's processes have yet to end."""
        self._tasks.put(lambda: self._complete(verdict))

    def write(self, verdict: Verdict | None) -> None:
        """Write the report, see ``softact.report.write_report``, where that is not done yet."""
        from softact.report import write_report

        self._tasks.put(None)
        self._wait()
        if self._written:
            return
        if self._report is None:
            write_report(self._directory, verdict=verdict)
        else:
            self._report.write((), lambda line: None, verdict)

    def _prepare(self) -> None:
        from softact.report.making import Report

        self._report = Report(self._directory)
        self._report.prepare()

    def _begin(self, status: str) -> None:
        if self._report is not None:
            self._report.begin(status)

    def _complete(self, verdict: Verdict | None) -> None:
        if self._report is not None:
            self._report.write((), lambda line: None, verdict)
            self._written = True

    def _wait(self) -> None:
        if self._thread is not None:
            self._thread.join()

    def _work(self) -> None:
        while task := self._tasks.get():
            with suppress(Exception):  # what is amiss is told when the report is written
                task()

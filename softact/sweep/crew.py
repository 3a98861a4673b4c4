"""Threads that compute a study's runs, each with a process that stays where runs are small."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import nullcontext
from queue import SimpleQueue
from typing import Self

from softact.run.staying import Staying

#: Work of one of the threads, which is handed its process; None: each run has one of its own.
Work = Callable[[Staying | None], None]


class Crew:
    """``count`` threads, which end with the ``with`` block, or with this process: they are daemons.

    stay: whether each keeps one process for all runs. Modules are small: for each of them a process
    would take as long to start as to solve.
    """

    def __init__(self, count: int, stay: bool) -> None:
        self._count, self._stay = count, stay
        self._work: SimpleQueue[Work | None] = SimpleQueue()

    def __enter__(self) -> Self:
        for _ in range(self._count):
            threading.Thread(target=self._wait, daemon=True).start()
        return self

    def __exit__(self, *problem: object) -> None:
        for _ in range(self._count):
            self._work.put(None)

    def begin(self, work: Work) -> None:
        """Let the next thread that is free do some work."""
        self._work.put(work)

    def _wait(self) -> None:
        with Staying() if self._stay else nullcontext() as staying:
            while (work := self._work.get()) is not None:
                work(staying)

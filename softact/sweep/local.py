"""Runs on this machine: so many at a time, each in processes of its own with one thread."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from softact.run.staying import Staying
from softact.spec import Spec
from softact.sweep.cache import BusyError, Cache
from softact.sweep.compute import Answer, compute
from softact.sweep.crew import Crew

_WAIT_S = 0.2  # before a run that somebody else computes is looked at again

#: Runs to be done: key -> function that makes its spec, called when its turn comes.
Jobs = Mapping[str, Callable[[], Spec]]


def run_all(
    jobs: Jobs,
    cache: Cache,
    count: int,
    slopes: Sequence[str] = (),
    end_only: bool = False,
    near: Path | None = None,
    blocked: Sequence[str] | None = None,
    crew: Crew | None = None,
) -> Iterator[Answer]:
    """Compute all jobs, ``count`` at a time; yields each answer when it comes. slopes, end_only,
    near, blocked: see ``compute``. crew: ``count`` threads at least that there are already.

    A run that another sweep computes at the moment is waited for, the others first. Raises
    CannotWriteError where the disk is full; the runs under way then end with this process, and so
    they do at a KeyboardInterrupt: the threads that wait for them are daemons. The next run begins
    when the caller asks for the next answer: none begins after one that the caller stops at.
    """
    waiting = deque(jobs)
    answers: SimpleQueue[Answer | BaseException] = SimpleQueue()
    stop = threading.Event()
    turns = threading.Semaphore(count)

    def work(staying: Staying | None) -> None:
        while turns.acquire() and not stop.is_set():
            if not work_on(staying):
                return

    def work_on(staying: Staying | None) -> bool:
        """Compute the next run; whether there may be another one."""
        try:
            key = waiting.popleft()
        except IndexError:
            return False
        try:
            how: dict[str, Any] = {"slopes": slopes, "end_only": end_only, "near": near}
            how |= {"blocked": blocked, "staying": staying}
            answers.put(compute(jobs[key](), key, cache, wait=False, **how))
        except BusyError:
            waiting.append(key)
            time.sleep(_WAIT_S)
            turns.release()
        except BaseException as error:
            answers.put(error)
            return False
        return True

    threads = min(count, len(jobs))
    with nullcontext(crew) if crew else Crew(threads, blocked is not None) as at_work:
        for _ in range(threads):
            at_work.begin(work)
        try:
            for _ in range(len(jobs)):
                yield _next(answers)
                turns.release()
        finally:
            stop.set()
            turns.release(count)


def _next(answers: SimpleQueue[Answer | BaseException]) -> Answer:
    while True:
        try:
            # With a time limit, so that Ctrl-C is heard at once.
            found = answers.get(timeout=1.0)
        except Empty:
            continue
        if isinstance(found, BaseException):
            raise found
        return found

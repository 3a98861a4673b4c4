"""How far a study of many runs is: a line for each run, and on a terminal a bar."""

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, Self

import click

if TYPE_CHECKING:
    import rich.progress

    from softact.sweep.compute import Answer
    from softact.sweep.points import DesignPoint


class Points:
    """Called with (point, answer) as each run ends.

    total: points of the study. done: those that need no run.
    """

    def __init__(self, total: int, done: int) -> None:
        self._total, self._done, self._first = total, done, done
        self._bar: rich.progress.Progress | None = None
        self._start = time.monotonic()

    def __enter__(self) -> Self:
        if sys.stdout.isatty():
            from rich.progress import (
                BarColumn,
                MofNCompleteColumn,
                Progress,
                TextColumn,
                TimeElapsedColumn,
            )

            left = TextColumn("{task.fields[left]}")
            self._bar = Progress(BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), left)
            self._bar.start()
            self._bar.add_task("", total=self._total, completed=self._done, left="")
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, point: "DesignPoint", answer: "Answer") -> None:
        self._done += 1
        width = len(str(self._total))
        line = f"{self._done:{width}d}/{self._total}  {point.text()}: {outcome(answer)}"
        if self._bar is None:
            click.echo(line)
            return
        self._bar.console.print(line, markup=False, highlight=False)
        self._bar.update(self._bar.task_ids[0], completed=self._done, left=self._left())

    def _left(self) -> str:
        finished = self._done - self._first
        seconds = (time.monotonic() - self._start) / finished * (self._total - self._done)
        return f"{duration(seconds)} left" if self._done < self._total else ""


def outcome(answer: "Answer") -> str:
    """A few words on how a run ended."""
    words = answer.status.replace("_", " ")
    if answer.cached:
        return f"{words}, computed by another sweep"
    if answer.record is not None:
        words += f", {answer.record.seconds:.1f} s"
    return f"{words} ({answer.cause})" if answer.cause else words


def duration(seconds: float) -> str:
    """Seconds as 45 s, 3 min 20 s, 2 h 5 min."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"

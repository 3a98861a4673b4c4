"""How far a run is: a bar on a terminal, plain lines elsewhere."""

import sys
import time
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Any, Self

import click


class Progress:
    """Called with each event of ``softact.run``.

    steps: names of the spec's steps, in order. On a terminal one line with a bar follows the run;
    elsewhere each event is a line of its own with the seconds since the start.
    """

    def __init__(self, steps: Sequence[str]) -> None:
        self._steps = list(steps)
        self._bar: Any = None
        self._task: Any = None
        self._start = time.monotonic()
        self._done = 0.0

    def __enter__(self) -> Self:
        if sys.stdout.isatty():
            from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
            from rich.progress import Progress as Bar

            percent = TextColumn("{task.percentage:>3.0f} %")
            text = TextColumn("{task.description}", markup=False)
            self._bar = Bar(BarColumn(), percent, TimeElapsedColumn(), text)
            self._bar.start()
            self._task = self._bar.add_task("", total=1.0)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, event: Mapping[str, Any]) -> None:
        from softact.run import log_line

        if event["stage"] == "error":
            return  # told at the end, on standard error
        if event["stage"] == "increment":
            self._done = (self._steps.index(event["step"]) + event["fraction"]) / len(self._steps)
        text = log_line(event)
        if self._bar is not None and event["stage"] == "note":
            self._bar.console.print(text, markup=False)  # above the bar, which goes on
        elif self._bar is not None:
            self._bar.update(self._task, completed=self._done, description=text)
        else:
            click.echo(f"{time.monotonic() - self._start:7.1f} s  {text}")

"""How far a run is: a bar on a terminal, plain lines elsewhere."""

import sys
import time
from types import TracebackType
from typing import Any, Self

import click


class Progress:
    """Called with (fraction of the whole run, one line of text) whenever a run gets further.

    On a terminal the text stands beside a bar; elsewhere each text is a line of its own.
    """

    def __init__(self) -> None:
        self._bar: Any = None
        self._task: Any = None
        self._start = time.monotonic()
        self._last = ""

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

    def __call__(self, fraction: float, text: str) -> None:
        if self._bar is not None:
            self._bar.update(self._task, completed=fraction, description=text)
        elif text != self._last:
            elapsed = time.monotonic() - self._start
            click.echo(f"{elapsed:7.1f} s  {fraction:4.0%}  {text}")
        self._last = text

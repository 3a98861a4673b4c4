"""How far a run is: a bar on a terminal, plain lines elsewhere, and never silent for long."""

import sys
import threading
import time
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import click

if TYPE_CHECKING:
    import rich.progress

#: Seconds of silence after which a line says what is still going on.
SILENCE = 9.0


class ProgressLine:
    """Called with each event of ``softact.run.start``.

    steps: names of the spec's steps, in order. On a terminal one line with a bar follows the run;
    elsewhere each event is a line of its own with the seconds since the start, and so is what goes
    on where no event comes for ``silence`` seconds: a large mesh, one long factorisation.
    """

    def __init__(self, steps: Sequence[str], silence: float = SILENCE) -> None:
        self._steps = list(steps)
        self._bar: rich.progress.Progress | None = None
        self._start = self._said_at = time.monotonic()
        self._silence = silence
        self._done = 0.0
        self._last = "start"
        self._lock, self._ended = threading.Lock(), threading.Event()
        self._ticker = threading.Thread(target=self._tick, daemon=True)

    def __enter__(self) -> Self:
        if sys.stdout.isatty():
            from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

            percent = TextColumn("{task.percentage:>3.0f} %")
            text = TextColumn("{task.description}", markup=False)
            self._bar = Progress(BarColumn(), percent, TimeElapsedColumn(), text)
            self._bar.start()
            self._bar.add_task("", total=1.0)
        else:
            self._ticker.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ended.set()
        if self._bar is not None:
            self._bar.stop()
        else:
            self._ticker.join()

    def __call__(self, event: Mapping[str, Any]) -> None:
        from softact.run.start import log_line

        if event["stage"] == "error":
            return  # said at the end, on standard error
        if event["stage"] == "increment":
            self._done = (self._steps.index(event["step"]) + event["fraction"]) / len(self._steps)
        text = log_line(event)
        if self._bar is not None and event["stage"] == "note":
            self._bar.console.print(text, markup=False, highlight=False)  # it stays
        elif self._bar is not None:
            self._bar.update(self._bar.task_ids[0], completed=self._done, description=text)
        else:
            self._say(text)
            self._last = text

    def _say(self, text: str) -> None:
        with self._lock:
            now = self._said_at = time.monotonic()
            click.echo(f"{now - self._start:7.1f} s  {text}")

    def _tick(self) -> None:
        """Say what goes on, as long as it does."""
        while not self._ended.wait(min(1.0, self._silence / 4)):
            if time.monotonic() - self._said_at > self._silence:
                self._say(f"still at: {self._last}")

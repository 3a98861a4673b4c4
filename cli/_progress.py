"""How far a run is: a bar on a terminal, plain lines elsewhere, and never silent for long."""

import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import click

from softact.cli._points import duration

if TYPE_CHECKING:
    import rich.progress

#: Seconds of silence after which a line says what is still going on.
SILENCE = 9.0
#: Seconds before which nothing is said of how long it will take: the first increments tell little.
TOO_EARLY = 5.0
#: Events while states are sought.
SOLVING = ("increment", "cutback", "progress")


class Left:
    """How long a run will take, if it goes on as it did since its first state.

    clock: gives seconds.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._first: tuple[float, float] | None = None
        self._done = 0.0

    def at(self, done: float) -> None:
        """A part of the whole is done."""
        self._done = done
        self._first = self._first or (self._clock(), done)

    def text(self) -> str:
        """In words; "" where nothing can be said. Where nothing moves it grows."""
        if self._first is None or not self._first[1] < self._done < 1.0:
            return ""
        passed = self._clock() - self._first[0]
        if passed < TOO_EARLY:
            return ""
        seconds = passed / (self._done - self._first[1]) * (1.0 - self._done)
        return f"about {duration(seconds)} left at this pace"


class ProgressLine:
    """Called with each event of ``softact.run.start``.

    steps: names of the spec's steps, in order. On a terminal one line with a bar follows the run;
    elsewhere each event is a line of its own with the seconds since the start, and so is what goes
    on where no event comes for ``silence`` seconds: a large mesh, one long factorisation. Both
    say how long it will take, as far as the states so far tell.
    """

    def __init__(self, steps: Sequence[str], silence: float = SILENCE) -> None:
        self._steps = list(steps)
        self._bar: rich.progress.Progress | None = None
        self._start = self._said_at = time.monotonic()
        self._silence = silence
        self._done, self._left = 0.0, Left()
        self._last, self._solves = "start", False
        self._lock, self._ended = threading.Lock(), threading.Event()
        self._ticker = threading.Thread(target=self._tick, daemon=True)

    def __enter__(self) -> Self:
        if sys.stdout.isatty():
            from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

            percent = TextColumn("{task.percentage:>3.0f} %")
            text = TextColumn("{task.description}", markup=False)
            left = TextColumn("{task.fields[left]}", markup=False)
            self._bar = Progress(BarColumn(), percent, TimeElapsedColumn(), left, text)
            self._bar.start()
            self._bar.add_task("", total=1.0, left="")
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
            self._left.at(self._done)
        text = log_line(event)
        if self._bar is not None and event["stage"] == "note":
            self._bar.console.print(text, markup=False, highlight=False)  # it stays
        elif self._bar is not None:
            task, left = self._bar.task_ids[0], self._left.text()
            self._bar.update(task, completed=self._done, description=text, left=left)
        else:
            self._solves = event["stage"] in SOLVING
            self._say(text)
            self._last = text

    def _say(self, text: str) -> None:
        with self._lock:
            now = self._said_at = time.monotonic()
            left = self._left.text() if self._solves else ""
            click.echo(f"{now - self._start:7.1f} s  {text}{f'  ({left})' if left else ''}")

    def _tick(self) -> None:
        """Say what goes on, as long as it does."""
        while not self._ended.wait(min(1.0, self._silence / 4)):
            if time.monotonic() - self._said_at > self._silence:
                self._say(f"still at: {self._last}")

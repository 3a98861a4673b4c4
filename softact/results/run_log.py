"""log.txt of a result folder: what was told, line by line, so that a kill leaves what was told."""

from __future__ import annotations

import time
from pathlib import Path

from softact.errors import CannotWriteError

LOG = "log.txt"


class RunLog:
    """Lines wait until ``begin`` is called: the folder may hold other results until then.

    resumed: they come after those of the run that goes on.
    """

    def __init__(self, directory: Path, resumed: bool):
        self._path, self._resumed = directory / LOG, resumed
        self._started = time.perf_counter()
        self._waiting: list[str] | None = []

    def begin(self) -> None:
        """Write what has been told so far, and from now on everything at once."""
        if self._waiting is None:
            return
        lines, self._waiting = self._waiting, None
        if self._resumed:
            lines.insert(0, "resumed")
        else:
            self._path.unlink(missing_ok=True)
        self.add(*lines)

    def add_now(self, *lines: str) -> None:
        """Add lines with the seconds since the log was made. Raises CannotWriteError."""
        seconds = time.perf_counter() - self._started
        self.add(*(f"{seconds:8.1f} s  {line}" for line in lines))

    def add(self, *lines: str) -> None:
        """Add lines. Raises CannotWriteError."""
        if self._waiting is not None:
            self._waiting += lines
            return
        try:
            with open(self._path, "a", encoding="utf-8") as file:
                file.write("".join(f"{line}\n" for line in lines))
        except OSError as error:
            raise CannotWriteError(f"{self._path}: cannot be written ({error.strerror})") from None

"""A process that solves one run after another: thousands of small runs need not wait thousands of
times for libraries."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Self

from softact.files.streams import UTF8
from softact.run import launch

#: Runs after which a new process takes over, so that nothing that a library keeps can pile up.
MOST_RUNS = 200
#: Stands for the job's file in the command of a process that hears of its jobs later.
LATER = "-"
ENDED = "ended"  # the stage that such a process tells after each run


class Staying:
    """Solves runs of one process and one thread, one at a time. It is used by one thread of the
    caller's, with which its process ends; it is started when the first run comes, and anew where it
    has died."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._runs = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *problem: object) -> None:
        self._end()
        if self._folder is not None:
            self._folder.cleanup()

    @property
    def errors(self) -> Path:
        """The file of what the process writes to standard error during a run."""
        assert self._folder is not None  # there was a run
        return Path(self._folder.name) / "stderr"

    def solve(self, job_file: Path, tell: Callable[[Mapping], None]) -> tuple[Mapping, int]:
        """Solve the job in a file and pass the events on; the last of them, and the exit code that
        a process of its own would have had."""
        if self._runs >= MOST_RUNS:
            self._end()
        process = self._started()
        self._runs += 1
        os.truncate(self.errors, 0)
        assert process.stdin is not None and process.stdout is not None  # they are pipes
        last: Mapping = {}
        try:
            with contextlib.suppress(BrokenPipeError):
                process.stdin.write(f"{job_file}\n")
                process.stdin.flush()
            for line in process.stdout:
                event = event_of(line)
                if event.get("stage") == ENDED:
                    return last, event["code"]
                if event:
                    last = event
                    tell(event)
        except BaseException:
            self._kill()
            raise
        code = process.wait()
        self._process = None
        return last, code

    def _started(self) -> subprocess.Popen[str]:
        if self._process is not None and self._process.poll() is None:
            return self._process
        if self._folder is None:
            self._folder = tempfile.TemporaryDirectory(prefix="softact-")
        folder = Path(self._folder.name)
        variables = launch.variables(1, 1, folder)
        with self.errors.open("ab") as stderr:
            self._process = subprocess.Popen(
                launch.command(1, ["-m", "softact.run.worker", LATER], variables),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=stderr,
                **UTF8,
                cwd=folder,
                env=variables,
                start_new_session=True,
            )
        self._runs = 0
        return self._process

    def _end(self) -> None:
        """Let the process end, which it does when no further job can come."""
        process = self._process
        if process is not None and process.stdin is not None and process.stdout is not None:
            with contextlib.suppress(BrokenPipeError):
                process.stdin.close()
            process.stdout.read()  # what libraries say at their end, which must not wait for us
            process.wait()
        self._process = None

    def _kill(self) -> None:
        if self._process is not None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGTERM)
            self._process.wait()
        self._process = None


def event_of(line: str) -> dict:
    """The event in a line; an empty one where it is something else, such as a library's words."""
    try:
        found = json.loads(line)
    except ValueError:
        return {}
    return found if isinstance(found, dict) and "stage" in found else {}

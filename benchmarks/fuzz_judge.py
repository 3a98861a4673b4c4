"""What is asked of every call of softact, whatever it was given: an exit code that is documented,
an end in time, plain lines on a refusal that say what and where, and nothing written by it."""

from __future__ import annotations

import io
import os
import re
import signal
import subprocess
import tempfile
import threading
import traceback
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

from softact.child_processes import python
from softact.cli import main as cli
from softact.units import one_line, printable

CODES = (0, 1, 2, 3, 4)
#: Those that answer a question, with 1 for no.
ASKING = ("check", "converge", "sweep")
REFUSED = 2
#: What Python says, and no program should.
PYTHON = re.compile(
    r"Traceback \(most recent|\.py:\d+: \w*Warning|fault in softact|<[\w.]+ object at 0x"
    r"|\bNoneType\b|validation errors? for|\w+Error\(|<class '"
)
#: A run that is finished is kept in the cache, whatever comes after.
_KEPT = re.compile(r"/(results/\.runs|runs)/|/results/$")
LONGEST_LINE = 1500
_QUIET = DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning


class HangsError(BaseException):
    """The time is over; no code of softact's shall catch it."""


@dataclass(frozen=True)
class Ended:
    """How a call ended. code: None where it did not in time; where: the traceback of a fault."""

    code: int | None
    out: str
    err: str
    where: str = ""


def listing(folder: Path) -> dict[str, tuple[int, int]]:
    """Every file and folder below a folder: type, and of files size and time of the last change."""
    found = {}
    for parent, _, files in os.walk(folder):
        found[f"{parent}/"] = (0, 0)
        for name in files:
            state = os.lstat(os.path.join(parent, name))
            found[os.path.join(parent, name)] = (state.st_size, state.st_mtime_ns)
    return found


def faults(arguments: Sequence[str], ended: Ended, before: dict, after: dict) -> list[str]:
    """What is wrong with how a call ended. before, after: listings of all that it could reach."""
    if ended.code is None:
        return ["hangs"]
    found = []
    if ended.code not in CODES or (ended.code == 1 and arguments[0] not in ASKING):
        found.append(f"exit code {ended.code}")
    said = PYTHON.search(ended.out + ended.err)
    if said:
        found.append(f"says '{said.group()}'")
    if ended.code != 0 and not ended.err.strip() and not ended.out.strip():
        found.append("says nothing")
    if ended.code == REFUSED:
        found += _of_refusal(arguments, ended.err, before, after)
    return found


def _of_refusal(arguments: Sequence[str], err: str, before: dict, after: dict) -> Iterator[str]:
    changed = sorted(k for k in before.keys() | after.keys() if before.get(k) != after.get(k))
    changed = [path for path in changed if not _KEPT.search(path)]
    if changed:
        yield f"writes {', '.join(changed[:3])}"
    lines = [line for line in err.split("\n") if line.strip()]
    if not lines:
        yield "refuses without a line on stderr"
        return
    if any(not line.isprintable() for line in lines):
        yield "says what cannot be printed"
    if max(map(len, lines)) > LONGEST_LINE:
        yield "says a line that is too long"
    if len(set(lines)) < len(lines) and len(set(arguments)) == len(arguments):
        yield "says a line twice"
    if not any(_says_where(line, arguments) for line in lines):
        yield "does not say where"


def _says_where(line: str, arguments: Sequence[str]) -> bool:
    """Whether a line names a file, an option or a word of the call."""
    if re.search(r"--?[\w-]+\b|\w\.(yaml|csv|json|h5|npz|db)\b|\bcommand\b|\bword \d|'.*'", line):
        return True
    words = [word for whole in arguments for word in (whole, *whole.split("=", 1))]
    return any(said(word) in line for word in words if word for said in (one_line, printable))


@contextmanager
def inside(folder: Path) -> Iterator[None]:
    """Make a folder the current one."""
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


@contextmanager
def _alarm(seconds: float) -> Iterator[None]:
    def over(number: int, frame: object) -> None:
        raise HangsError

    # By the processor's clock, since the machine may be busy; what only waits has longer.
    clocks = (
        (signal.SIGPROF, signal.ITIMER_PROF, seconds),
        (signal.SIGALRM, signal.ITIMER_REAL, 10 * seconds),
    )
    before = [signal.signal(number, over) for number, _, _ in clocks]
    for _, clock, limit in clocks:
        signal.setitimer(clock, limit)
    try:
        yield
    finally:
        for (number, clock, _), handler in zip(clocks, before, strict=True):
            signal.setitimer(clock, 0)
            signal.signal(number, handler)


def in_process(arguments: Sequence[str], folder: Path, limit: float) -> Ended:
    """Call the command line in this process, in a folder."""
    out, err = (io.TextIOWrapper(io.BytesIO(), "utf-8", "backslashreplace") for _ in range(2))
    where = []
    tell = cli._tell

    def heard(error: Exception) -> int:
        code = tell(error)
        if code not in CODES:
            where.append("".join(traceback.format_exception(error)))
        return code

    code: int | None = None
    others = set(threading.enumerate())
    with inside(folder), redirect_stdout(out), redirect_stderr(err), warnings.catch_warnings():
        warnings.simplefilter("always")
        for kind in _QUIET:
            warnings.simplefilter("ignore", kind)
        try:
            with mock.patch.object(cli, "_tell", heard), _alarm(limit):
                code = _code(arguments)
        except HangsError:
            where.append(traceback.format_exc())
        for thread in set(threading.enumerate()) - others:  # as a program they end with it
            thread.join(limit)
    texts = []
    for stream in (out, err):
        stream.flush()
        texts.append(stream.buffer.getvalue().decode("utf-8", "backslashreplace"))
    return Ended(code, *texts, "\n".join(where))


def _code(arguments: Sequence[str]) -> int:
    debug = "--debug" in arguments
    try:
        return cli._run([a for a in arguments if a != "--debug"], debug)
    except SystemExit as left:
        return left.code if isinstance(left.code, int) else int(left.code is not None)


def as_program(arguments: Sequence[str], folder: Path, limit: float) -> Ended:
    """Call the command line as a program of its own, in a folder."""
    process = subprocess.Popen(
        [*python("-m", "softact.cli.main"), *map(os.fsencode, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=folder,
        env=os.environ | {"TMPDIR": tempfile.gettempdir()},
        start_new_session=True,
    )
    try:
        texts = process.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        texts = process.communicate()
        return Ended(None, *(text.decode("utf-8", "replace") for text in texts))
    return Ended(process.returncode, *(text.decode("utf-8", "replace") for text in texts))

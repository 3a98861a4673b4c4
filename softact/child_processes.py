"""Processes that softact starts: they end when the one that started them does, however that ended,
and they take Python's modules from where they are installed, never from the current folder."""

import ctypes
import os
import shutil
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

_PR_SET_PDEATHSIG = 1
_forked = False  # whether this process was forked by a fork server


def python(*arguments: str | Path) -> list[str]:
    """The command of a Python process of softact's: its modules are looked for neither in the
    current folder nor beside its script. Its environment is ``environment``'s."""
    return [sys.executable, "-P", *map(str, arguments)]


def environment(without: Sequence[str] = ()) -> dict[str, str]:
    """The variables of this process for one that it starts.

    without: beginnings of the names of those that are left out. Of PYTHONPATH the absolute folders
    are kept: an empty or relative one is, or counts from, the current folder.
    """
    kept = {k: v for k, v in os.environ.items() if not k.startswith(tuple(without))}
    folders = [path for path in kept.pop("PYTHONPATH", "").split(os.pathsep) if os.path.isabs(path)]
    return kept | ({"PYTHONPATH": os.pathsep.join(folders)} if folders else {})


def leave_current_folder() -> None:
    """Take the current folder off this process's path of modules, unless PYTHONPATH names it."""
    named = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    wanted = {os.path.realpath(path) for path in named if os.path.isabs(path)}
    here = os.path.realpath(os.curdir)
    if here not in wanted:
        sys.path[:] = [path for path in sys.path if os.path.realpath(path) != here]


@contextmanager
def importable(folder: Path) -> Iterator[None]:
    """Let a user's script in this folder import what lies beside it, as Python does."""
    before = list(sys.path)
    sys.path.insert(0, str(folder))
    try:
        yield
    finally:
        sys.path[:] = before


def bound(command: Sequence[str]) -> list[str]:
    """The command such that the kernel kills it (SIGKILL) when the thread that starts it ends.

    By setpriv, which Debian always has; ``end_with`` in the started process does the same, only
    later, and closes the moment before setpriv has acted.
    """
    setpriv = shutil.which("setpriv")
    return [*([setpriv, "--pdeathsig", "KILL", "--"] if setpriv else []), *command]


def end_with(parent: int) -> None:
    """Let the kernel kill this process (SIGKILL) when its parent ends; Linux only.

    parent: process id of whoever started this process; where it has ended already, this process
    ends here. Strictly it is the parent's thread that counts: it has to wait for this process.
    What a fork server forked ends with that, and that with the one that started it.
    """
    if not sys.platform.startswith("linux") or _forked:
        return
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:
        os._exit(128 + signal.SIGKILL)


def be_forked(server: int) -> None:
    """In a process that a fork server has just forked: end with the server.

    server: its process id.
    """
    global _forked
    end_with(server)
    _forked = True

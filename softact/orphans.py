"""Processes that end when the one that started them does, however that ended."""

import ctypes
import os
import shutil
import signal
import sys
from collections.abc import Sequence

_PR_SET_PDEATHSIG = 1


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
    """
    if not sys.platform.startswith("linux"):
        return
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:
        os._exit(128 + signal.SIGKILL)

"""The fork servers that a process has started, one for each kind of process and environment."""

from __future__ import annotations

import atexit
import os
import secrets
import socket
import subprocess
import sys
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path

from softact.child_processes import python
from softact.forkserver.client import SKIPPED, limits

_CLIENT = str(Path(__file__).with_name("client.py"))
# Variables that libraries read when they are used, not when they are loaded, by the beginnings of
# their names: a server takes clients that differ in them.
_READ_LATE = ("TMPDIR", "PWD", "OLDPWD", "PYTEST_", "OMPI_", "PMIX_", "PRTE_", "COLUMNS", "LINES")
# So often a kind of process is started before it gets a server: one that is started once would
# wait for what the others have of it.
_BEFORE = 1
MOST = 8  # servers; each keeps some 100 MB, most of it shared with what it forks


class _Servers:
    """They end with this process, or are ended by ``end``."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._asked: dict[tuple, int] = {}
        self._running: dict[tuple, tuple[str, subprocess.Popen]] = {}

    def name(self, arguments: Sequence[str], variables: Mapping[str, str]) -> str | None:
        """The socket of the server of these arguments, None where there is none yet."""
        kind = tuple(arguments[: 2 if arguments[0] == "-m" else 1])
        kept = {k: v for k, v in variables.items() if not k.startswith(_READ_LATE)}
        key = (kind, *sorted(kept.items()), *limits())
        with self._lock:
            self._asked[key] = self._asked.get(key, 0) + 1
            if self._asked[key] <= _BEFORE:
                return None
            if key not in self._running:
                if len(self._running) == MOST:
                    return None
                self._running[key] = self._start(kind, kept)
            name, process = self._running[key]
        return name if process.poll() is None else None

    def _start(self, kind: tuple[str, ...], kept: dict) -> tuple[str, subprocess.Popen]:
        name = f"softact-{secrets.token_hex(16)}"
        with socket.socket(socket.AF_UNIX) as listening:
            listening.bind("\0" + name)
            listening.listen(64)
            process = subprocess.Popen(
                python("-m", "softact.forkserver.server", str(listening.fileno()), *kind),
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                env=kept,
                pass_fds=(listening.fileno(),),
                start_new_session=True,
            )
        return name, process

    def end(self) -> None:
        """End all servers."""
        for _, process in self._running.values():
            assert process.stdin is not None  # it is a pipe
            process.stdin.close()
        for _, process in self._running.values():
            process.wait()


_servers = _Servers()
atexit.register(_servers.end)


def command(arguments: Sequence[str | Path], variables: Mapping[str, str]) -> list[str]:
    """The command of a Python process of softact's, see ``child_processes.python``; it is forked
    from a server where one like it, with the same variables and limits, was started before.
    Servers are of Linux only.

    arguments: a module after -m, or a script, and its own. variables: the environment that the
    process will be started with; on several processes mpirun adds to it.
    """
    usual = python(*arguments)
    linux = sys.platform.startswith("linux")
    name = _servers.name(usual[SKIPPED:], variables) if linux else None
    if name is None:
        return usual
    return [os.path.realpath(sys.executable), "-I", "-S", _CLIENT, name, *usual]

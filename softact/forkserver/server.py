"""A process that loads the libraries of a kind of process once, and forks one for each client:
``python -P -m softact.forkserver.server SOCKET COMMAND...``.

SOCKET: number of a listening socket. COMMAND: arguments of Python that start such a process, a
module after -m, or a script. Its top level is run, and its function ``preload`` where it has one;
what is forked runs it anew, as the main program. The server ends when its standard input does,
which only the process that started it holds, and kills what it forked.
"""

from __future__ import annotations

import atexit
import contextlib
import fcntl
import gc
import json
import os
import resource
import runpy
import selectors
import signal
import socket
import struct
import sys
import tempfile
import traceback
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

from softact import child_processes

_ABOVE_ALL = 512  # file numbers from here on are no client's
_MOST_FILES = 253  # that one message can hand over


def preload(arguments: Sequence[str]) -> None:
    """Run the top level of a module or script, and its ``preload``."""
    found = _run(arguments, "preloaded")
    if "preload" in found:
        found["preload"]()


def _run(arguments: Sequence[str], name: str) -> Mapping[str, Any]:
    if arguments[0] == "-m":
        return runpy.run_module(arguments[1], run_name=name, alter_sys=name == "__main__")
    return runpy.run_path(arguments[0], run_name=name)


class Server:
    """The loop of a server."""

    def __init__(self, listening: socket.socket):
        self._listening = listening
        self._clients: dict[int, socket.socket] = {}  # by process id of what was forked
        self._selector = selectors.DefaultSelector()
        self._ended, self._woken = socket.socketpair()
        for end in (self._ended, self._woken):
            end.setblocking(False)
        signal.set_wakeup_fd(self._woken.fileno(), warn_on_full_buffer=False)
        signal.signal(signal.SIGCHLD, lambda number, frame: None)
        for file in (listening, self._ended, sys.stdin):
            self._selector.register(file, selectors.EVENT_READ)

    def run(self) -> None:
        """Serve until standard input ends."""
        while True:
            ready = [key.fileobj for key, _ in self._selector.select()]
            if sys.stdin in ready:
                break
            if self._ended in ready:
                with contextlib.suppress(BlockingIOError):
                    self._ended.recv(4096)
                self._tell_ended()
            for file in ready:
                if file is self._listening:
                    self._serve()
                elif file in self._clients.values():
                    self._leave_off(file)
        for process in self._clients:
            os.kill(process, signal.SIGKILL)

    def _tell_ended(self) -> None:
        while self._clients:
            process, status = os.waitpid(-1, os.WNOHANG)
            if process == 0:
                break
            client = self._clients.pop(process)
            with contextlib.suppress(OSError, KeyError):
                self._selector.unregister(client)
            with contextlib.suppress(OSError):
                client.sendall(str(os.waitstatus_to_exitcode(status)).encode())
            client.close()

    def _leave_off(self, client: Any) -> None:
        """Kill what was forked for a client that was killed."""
        self._selector.unregister(client)
        for process, of in self._clients.items():
            if of is client:
                os.kill(process, signal.SIGKILL)

    def _serve(self) -> None:
        client, _ = self._listening.accept()
        peer = client.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i"))
        if struct.unpack("3i", peer)[1] != os.geteuid():
            client.close()
            return
        files: list[int] = []
        try:
            request = _received(client, files)
            server, process = os.getpid(), os.fork()
        except (OSError, ValueError):  # the client was killed in the middle of it, or no memory
            client.close()
        else:
            if process == 0:
                self._become(request, files, client, server)
            self._clients[process] = client
            self._selector.register(client, selectors.EVENT_READ)
        for file in files:
            os.close(file)

    def _become(
        self, request: Mapping, files: Sequence[int], client: socket.socket, server: int
    ) -> NoReturn:
        """In the forked process: be what the client asks for."""
        code = 70
        try:
            signal.set_wakeup_fd(-1)
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            self._selector.close()
            for end in (self._listening, self._ended, self._woken, client, *self._clients.values()):
                end.close()
            child_processes.be_forked(server)
            os.setsid()
            _take(request, files)
            _open_streams()
            arguments = request["arguments"]
            sys.argv = list(arguments[1:] if arguments[0] == "-m" else arguments)
            code = _code_of(arguments)
        except BaseException:
            traceback.print_exc()
        finally:
            with contextlib.suppress(BaseException):
                sys.stdout.flush()
            with contextlib.suppress(BaseException):
                sys.stderr.flush()
            os._exit(code)


def _received(client: socket.socket, files: list[int]) -> dict:
    """What a client asks for, and the files that it hands over. Raises ValueError where it has
    gone."""
    data, handed, _, _ = socket.recv_fds(client, 1 << 16, _MOST_FILES)
    files += handed
    while len(data) < 8 or len(data) < 8 + int.from_bytes(data[:8], "big"):
        more = client.recv(1 << 16)
        if not more:
            raise ValueError("the client has gone")
        data += more
    request: dict = json.loads(data[8:].decode("utf-8", "surrogateescape"))
    return request


def _take(request: Mapping, files: Sequence[int]) -> None:
    """Take over the client's files, folder, variables, limits, umask and cores."""
    high = [fcntl.fcntl(file, fcntl.F_DUPFD_CLOEXEC, _ABOVE_ALL) for file in files]
    for file in files:
        os.close(file)
    for file, number in zip(high, request["files"], strict=True):
        os.dup2(file, number)
        os.close(file)
    os.chdir(request["folder"])
    os.environ.clear()
    os.environ.update(request["variables"])
    tempfile.tempdir = None  # as TMPDIR says now
    os.umask(request["umask"])
    os.sched_setaffinity(0, request["cores"])
    for number, soft, hard in request["limits"]:
        if resource.getrlimit(number) != (soft, hard):
            resource.setrlimit(number, (soft, hard))


def _open_streams() -> None:
    """Standard streams as Python opens them: how they behave depends on what they are."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        before = getattr(sys, name)
        stream = open(
            number,
            "w" if number else "r",
            encoding=before.encoding,
            errors=before.errors,
            closefd=False,
        )
        stream.reconfigure(line_buffering=number == 2 or stream.line_buffering)
        setattr(sys, name, stream)
        setattr(sys, f"__{name}__", stream)


def _code_of(arguments: Sequence[str]) -> int:
    """The exit code of a main program; as Python ends it, but that nothing is taken apart."""
    code: Any = 0
    try:
        _run(arguments, "__main__")
    except SystemExit as end:
        code = end.code
    except BaseException:
        traceback.print_exc()
        code = 1
    if code is not None and not isinstance(code, int):
        print(code, file=sys.stderr)
        code = 1
    atexit._run_exitfuncs()
    return (code or 0) & 0xFF


def main(number: str, *arguments: str) -> None:
    """Load, then serve."""
    child_processes.leave_current_folder()
    listening = socket.socket(fileno=int(number))
    listening.set_inheritable(False)
    os.chdir(Path(os.sep))
    preload(arguments)
    gc.collect()
    gc.freeze()  # pages that are not written to are shared
    Server(listening).run()


if __name__ == "__main__":
    main(*sys.argv[1:])

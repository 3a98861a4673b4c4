"""Stands for a process that a fork server forks: ``python -I -S client.py SOCKET COMMAND...``.

Hands its arguments, variables, limits and open files over to the server on the abstract socket,
waits, and ends as the forked process did. Where there is no server any more it becomes COMMAND,
which does the same. It imports little: starting it must cost next to nothing.
"""

import array
import json
import os
import resource
import signal
import socket
import sys

#: Where a command's arguments begin: ``PYTHON -P ...``.
SKIPPED = 2


def limits() -> list[tuple[int, int, int]]:
    """Number, soft and hard value of this process's limits."""
    names = sorted(name for name in dir(resource) if name.startswith("RLIMIT_"))
    numbers = sorted({getattr(resource, name) for name in names})
    return [(number, *resource.getrlimit(number)) for number in numbers]


def _open_files(but: int) -> list[int]:
    found = []
    for name in os.listdir("/proc/self/fd"):
        number = int(name)
        try:
            # What Python opens for itself, as this folder, does not outlive an exec.
            if number != but and os.get_inheritable(number):
                found.append(number)
        except OSError:
            pass
    return sorted(found)


def _request(arguments: list[str], files: list[int]) -> bytes:
    umask = os.umask(0)
    os.umask(umask)
    text = json.dumps(
        {
            "arguments": arguments,
            "files": files,
            "folder": os.getcwd(),
            "variables": dict(os.environ),
            "limits": limits(),
            "umask": umask,
            "cores": sorted(os.sched_getaffinity(0)),
        }
    ).encode("utf-8", "surrogateescape")
    return len(text).to_bytes(8, "big") + text


def main(name: str, *command: str) -> None:
    """End as the forked process, or become ``command``."""
    server = socket.socket(socket.AF_UNIX)
    try:
        server.connect("\0" + name)
    except OSError:
        os.execv(command[0], command)
    files = _open_files(server.fileno())
    message = _request(list(command[SKIPPED:]), files)
    rights = [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", files))]
    sent = server.sendmsg([message], rights)
    server.sendall(message[sent:])
    answer = server.recv(64)
    # Without an answer the server was killed, and what it forked with it.
    code = int(answer) if answer else -signal.SIGKILL
    if code >= 0:
        os._exit(code)
    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
    if -code != signal.SIGKILL:
        signal.signal(-code, signal.SIG_DFL)
    os.kill(os.getpid(), -code)


if __name__ == "__main__":
    main(*sys.argv[1:])

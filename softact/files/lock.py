"""One writer at a time in a folder: a lock that the kernel takes back from whoever was killed.

The lock is flock(2) on the file ``.lock`` in the folder. The file goes when the lock is given back;
one that a kill has left means nothing.
"""

from __future__ import annotations

import errno
import fcntl
import os
import shutil
import socket
import stat
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from softact.errors import CannotWriteError, FolderBusyError, SpecError

LOCK = ".lock"
_SIGN = b"softact "  # how a lock file of softact begins

# What a file system says that has no locks; then there is none.
_NO_LOCKS = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS)
# Seconds that a folder may still be held: the processes of a run that was killed end with it, but
# not in the same moment.
_PATIENCE, _PAUSE = 1.0, 0.02


@contextmanager
def held(
    directory: Path, command: str, first: Mapping[str, str] | None = None
) -> Iterator[tuple[int, ...]]:
    """Hold a folder, made where it is not there, as long as the block lasts.

    command: what holds it, for the message that others get. first: name -> text of files that a
    folder made here has from its first moment. A folder made here that has no other files at the
    end is removed again, with those above it that were made for it. Gives what a process that
    writes there too has to inherit (``pass_fds=``), so that the folder is held until it has ended,
    however this one ended.

    Raises FolderBusyError where another process holds the folder, SpecError where there is a file
    of its name, CannotWriteError.
    """
    directory, first = Path(directory), dict(first or {})
    try:
        handle, made = _acquired(directory, first)
    except OSError as error:
        raise CannotWriteError(
            f"{directory}: cannot be written ({error.strerror}); name another folder with -o DIR"
        ) from None
    with suppress(OSError):
        _say(handle, command)
    try:
        yield (handle,)
    finally:
        if made and _names(directory) <= {LOCK, *first}:
            _remove(directory)
            _remove_empty(made)
        else:
            (directory / LOCK).unlink(missing_ok=True)
        os.close(handle)


def _acquired(directory: Path, first: Mapping[str, str]) -> tuple[int, list[Path]]:
    """Descriptor of the lock, and the folders that were made, the deepest first."""
    until = time.monotonic() + _PATIENCE
    while True:
        try:
            if not _is_there(directory):
                return _born(directory, first)
            handle = _opened(directory / LOCK)
            if handle is not None:
                return handle, []
        except (FileNotFoundError, FileExistsError):  # made or removed by another in between
            pass
        if time.monotonic() > until:
            raise FolderBusyError(
                f"{directory}: {_holder(directory / LOCK)} writes there at the moment; wait for "
                "its end, or use another folder"
            )
        time.sleep(_PAUSE)


def _is_there(directory: Path) -> bool:
    try:
        mode = os.stat(directory).st_mode
    except FileNotFoundError:
        return False
    if not stat.S_ISDIR(mode):
        raise SpecError(f"{directory}: is a file; a folder needs another name (-o DIR)")
    return True


def _born(directory: Path, first: Mapping[str, str]) -> tuple[int, list[Path]]:
    """Make the folder such that it is held and has its first files from its first moment."""
    made = [path for path in (directory, *directory.parents) if not path.exists()]
    nursery = _beside(directory, "new")
    handle: int | None = None
    try:
        nursery.mkdir(parents=True)
        handle = _opened(nursery / LOCK)
        if handle is None:
            raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN), nursery)
        for name, text in first.items():
            (nursery / name).write_text(text, encoding="utf-8")
        nursery.rename(directory)
    except OSError as error:
        if handle is not None:
            os.close(handle)
        shutil.rmtree(nursery, ignore_errors=True)
        _remove_empty(made)
        if error.errno == errno.ENOTEMPTY:
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), directory) from None
        raise
    # Where it came and went meanwhile, it was there when that was looked at, and is ours now.
    return handle, [directory, *(path for path in made if path != directory)]


def _opened(path: Path) -> int | None:
    """Descriptor of the lock file, locked; None where another process has it."""
    handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o644)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        # Of another program: not to be written, nor removed in the end.
        if not os.pread(handle, len(_SIGN), 0).startswith(_SIGN[: os.fstat(handle).st_size]):
            raise PermissionError(errno.EPERM, "its .lock is not of softact")
        # Who held it before may have removed it since it was opened here.
        if os.path.samestat(os.fstat(handle), os.stat(path, follow_symlinks=False)):
            return handle
    except (BlockingIOError, FileNotFoundError):
        pass
    except OSError as error:
        if error.errno in _NO_LOCKS:
            return handle
        os.close(handle)
        raise
    os.close(handle)
    return None


def _say(handle: int, command: str) -> None:
    """Write into the lock file who holds it."""
    os.ftruncate(handle, 0)
    text = f"softact {command} (process {os.getpid()} on {socket.gethostname()})\n"
    os.pwrite(handle, text.encode(), 0)


def _holder(path: Path) -> str:
    said = ""
    with suppress(OSError), open(path, encoding="utf-8", errors="replace") as file:
        said = file.readline(200).strip()
    return said if said and said.isprintable() else "another softact"


def _names(directory: Path) -> set[str]:
    with suppress(OSError):
        return {path.name for path in directory.iterdir()}
    return set()


def _beside(directory: Path, kind: str) -> Path:
    directory = directory.absolute()
    return directory.with_name(f".{directory.name}.{os.getpid()}.{time.monotonic_ns()}.{kind}")


def _remove(directory: Path) -> None:
    """Remove a folder that is held, at once for all who look for it by its name."""
    gone = _beside(directory, "gone")
    with suppress(OSError):
        directory.rename(gone)
        shutil.rmtree(gone, ignore_errors=True)


def _remove_empty(folders: list[Path]) -> None:
    for folder in folders:
        with suppress(OSError):
            folder.rmdir()

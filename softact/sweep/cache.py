"""Finished runs in one folder, each under its key; shared by any number of sweeps at once.

``<key[:2]>/<key>``: result folders with a record. ``tmp``: runs under way. ``locks``: one file for
each key; who computes a run holds its lock (flock), which the kernel takes back from the dead.
``journal.csv``: a line for each run that was computed.
"""

from __future__ import annotations

import errno
import fcntl
import os
import shutil
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from softact.errors import CannotWriteError, SpecError
from softact.files.text import why_unwritable
from softact.sweep import record
from softact.sweep.record import DamagedError, Record

DEFAULT = Path("results") / ".runs"

_FULL = (os.strerror(errno.ENOSPC), os.strerror(errno.EDQUOT))
_PARTS = ("locks", "tmp")  # the first is there from the first moment


class BusyError(Exception):
    """Somebody else computes this run at the moment."""


class Cache:
    """The folder of the runs; it is made when the first is computed.

    warn: called with one line for each damaged run that was thrown away.
    Raises SpecError where the folder cannot be made or written, or holds other things.
    """

    def __init__(self, directory: Path, warn: Callable[[str], None] = lambda line: None):
        self.directory, self.warn = Path(directory), warn
        try:
            self._check()
        except OSError as error:
            raise SpecError(self._cannot(error, "")) from None

    def _check(self) -> None:
        """Raise OSError, or SpecError, where this is no place for a cache."""
        parts = (self.directory, *self.directory.absolute().parents)
        there = next(path for path in parts if path.exists())
        if not there.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
        if not os.access(there, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        if there != self.directory or (there / _PARTS[0]).is_dir():
            return
        others = [path.name for path in there.iterdir() if not path.name.startswith(".")]
        if others and others != ["lost+found"]:
            raise SpecError(
                f"{self.directory}: the folder holds other files than runs of softact; name "
                "another with --cache"
            )

    def make(self) -> None:
        """Make the folder. Raises CannotWriteError."""
        with self._writing():
            for name in _PARTS:
                (self.directory / name).mkdir(parents=True, exist_ok=True)

    def folder(self, key: str) -> Path:
        """Where the result folder of a run is, or would be."""
        return self.directory / key[:2] / key

    def find(self, key: str) -> Record | None:
        """The run, None where it is not there or damaged."""
        try:
            return record.load(key, self.folder(key))
        except (DamagedError, OSError, ValueError, KeyError, TypeError):
            return None

    @contextmanager
    def lock(self, key: str, wait: bool = True) -> Iterator[None]:
        """Hold the right to compute a run. Raises BusyError where ``wait`` is false, and
        CannotWriteError."""
        self.make()
        with self._writing():
            file = open(self.directory / "locks" / key, "ab")
        with file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
            except BlockingIOError:
                raise BusyError(key) from None
            yield

    @contextmanager
    def workspace(self, key: str) -> Iterator[Path]:
        """A fresh folder to compute a run in; whoever calls holds its lock. Raises
        CannotWriteError."""
        folder = self.directory / "tmp" / f"{key}.{os.getpid()}"
        with self._writing():
            self._clear(key)
            folder.mkdir()
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def _clear(self, key: str) -> None:
        """Remove what a run that was killed has left, and a damaged result."""
        for left in (self.directory / "tmp").glob(f"{key}.*"):
            shutil.rmtree(left, ignore_errors=True)
        folder = self.folder(key)
        if not folder.exists():
            return
        try:
            record.load(key, folder)
            why = "it cannot be read"
        except (DamagedError, OSError, ValueError, KeyError, TypeError) as error:
            why = str(error)
        self.warn(f"{folder}: the kept run is damaged ({why}); it is computed anew")
        shutil.rmtree(folder)

    def keep(self, found: Record, results: Path) -> None:
        """Move a finished result folder into the cache, all at once; its lock is held. Raises
        CannotWriteError."""
        with self._writing():
            record.store(found, results)
            for path in results.iterdir():
                _sync(path)
            target = self.folder(found.key)
            target.parent.mkdir(parents=True, exist_ok=True)
            _sync(results)
            results.rename(target)
            _sync(target.parent)
            self._journal(found)

    @contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise self.cannot_write(error) from None

    def cannot_write(self, error: OSError | CannotWriteError) -> CannotWriteError:
        """What to say of an error, of this process or of its solver's, that ends the sweep."""
        return CannotWriteError(self._cannot(error, "; what was finished is kept"))

    def _cannot(self, error: OSError | CannotWriteError, kept: str) -> str:
        why = why_unwritable(error) or getattr(error, "strerror", None)
        if why in _FULL:
            return f"{self.directory}: the disk is full; what was finished is kept"
        why = why or " ".join(str(error).split())
        return (
            f"{self.directory}: cannot be written ({why}){kept}; name another folder with --cache"
        )

    def _journal(self, found: Record) -> None:
        when = time.strftime("%Y-%m-%dT%H:%M:%S")
        line = f"{when},{found.key},{found.status},{found.seconds:.3f},{socket.gethostname()}\n"
        # One write of a line to a file that is opened for appending is never torn.
        handle = os.open(self.directory / "journal.csv", os.O_WRONLY | os.O_APPEND | os.O_CREAT)
        try:
            os.write(handle, line.encode())
        finally:
            os.close(handle)


def _sync(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)

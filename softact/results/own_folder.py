"""What softact may write: folders and files of its own. One rule for all commands.

A folder that is not there or empty becomes softact's own: ``.softact.json`` in it names the command
and the files that it put there, and these it may replace. Into any other folder, and over any other
file, it writes with ``--force`` only; over a file that the command reads, never. A result folder
has its ``run.json`` in place of the marker. What is refused is refused before anything is written.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from softact.errors import CannotWriteError, SoftactError, SpecError
from softact.files.lock import LOCK, held
from softact.files.text import (
    clear_temporaries,
    is_temporary,
    json_text,
    replacing,
    why_unwritable,
    write_atomic,
)
from softact.results.folder import INCOMPLETE, OWN_FILES, holds_results

MARKER = ".softact.json"
_RUN = "run.json"


class Output:
    """The folder that a command writes its outcome into.

    command: as its user calls it. force: whether it was called with --force. reads: the files that
    the command reads. kept: what stays where the folder can no longer be written, in words.
    """

    def __init__(
        self,
        directory: Path,
        command: str,
        force: bool = False,
        reads: Iterable[Path] = (),
        kept: str = "nothing else was written",
    ):
        self.directory, self.command, self.force = Path(directory), command, force
        self.reads, self.kept = list(reads), kept
        self._own = set(self._marker() or ())

    def check(self, names: Sequence[str] = ()) -> None:
        """Raise SpecError where the folder, or one of these files in it, may not be written."""
        check_writable(self.directory)
        marker = self._marker()
        if marker is None and not self.force and not is_empty(self.directory):
            raise SpecError(
                f"{self.directory}: the folder holds other files than those of 'softact "
                f"{self.command}'; name another with -o DIR, or add --force to write into it all "
                "the same"
            )
        self._own = set(marker or ())
        for name in names:
            check_file(self.directory / name, self.force or name in self._own, self.reads, "-o DIR")

    @contextmanager
    def opened(self, names: Sequence[str] = ()) -> Iterator[None]:
        """Hold the folder, made where it is not there, to write these files into it.

        Raises SpecError as ``check`` does, FolderBusyError where another softact writes into it,
        and CannotWriteError where the disk is full.
        """
        self.check(names)
        with held(self.directory, self.command):
            self.check(names)  # another softact may have written since
            with self._full():
                clear_temporaries(self.directory, (*self._own, MARKER))
                yield

    def file(self, name: str) -> Path:
        """The path of a file that is to be written now; the marker names it from here on."""
        path = self.directory / name
        check_file(path, self.force or name in self._own, self.reads, "-o DIR")
        if name not in self._own:
            self._own.add(name)
            story = {"softact": self.command, "files": sorted(self._own)}
            write_atomic(self.directory / MARKER, json_text(story))
        return path

    def results(self, name: str, source: Path) -> Path:
        """Put a copy of a result folder there, in place of the one that softact put there before;
        other files in it stay. Returns its path."""
        target = self.file(name)
        target.mkdir(exist_ok=True)
        own = (*OWN_FILES, *(path.name for path in source.iterdir()))
        # First it says incomplete, and last what it is: a kill leaves no half that looks whole.
        write_atomic(target / _RUN, json_text({"status": INCOMPLETE}))
        for old in {*own} - {_RUN}:
            (target / old).unlink(missing_ok=True)
        for path in sorted(source.iterdir(), key=lambda path: path.name == _RUN):
            with replacing(target / path.name) as temporary:
                shutil.copyfile(path, temporary)
        return target

    def _marker(self) -> list[str] | None:
        """The files that this command has put there; None where the folder is not its own."""
        with suppress(OSError, ValueError, TypeError, KeyError, RecursionError):
            story = json.loads((self.directory / MARKER).read_text(encoding="utf-8"))
            if story["softact"] == self.command:
                return [str(name) for name in story["files"]]
        return None

    @contextmanager
    def _full(self) -> Iterator[None]:
        try:
            yield
        except SoftactError:
            raise
        except OSError as error:
            why = why_unwritable(error)
            if why is None:
                raise
            raise CannotWriteError(f"{self.directory}: {why}; {self.kept}") from None


def check_file(
    path: Path, may_replace: bool, reads: Iterable[Path] = (), other: str = "-o FILE"
) -> None:
    """Raise SpecError where a file may not be written: it is a folder, one that the command reads,
    or there already and not to be replaced. other: the option that names another."""
    if any(_same(path, read) for read in reads):
        raise SpecError(f"{path}: this file is read by the command; name another with {other}")
    if path.is_dir() and other != "-o DIR":
        raise SpecError(f"{path}: this is a folder; give the name of a file")
    if os.path.lexists(path) and not may_replace:
        raise SpecError(
            f"{path}: is there already; add --force to replace it, or name another with {other}"
        )


def begins_with(path: Path, sign: bytes) -> bool:
    """Whether the first bytes of a file hold the sign by which softact knows its own."""
    try:
        with open(path, "rb") as file:
            return sign in file.read(1000)
    except OSError:
        return False


def _same(path: Path, read: Path) -> bool:
    with suppress(OSError):
        return os.path.samefile(path, read)
    return False


def check_results(directory: Path, force: bool, reads: Iterable[Path] = ()) -> None:
    """Raise SpecError where a run may not write its results into a folder."""
    check_writable(directory)
    for name in (*OWN_FILES, _RUN):
        check_file(directory / name, True, reads, "-o DIR")
    if not (force or is_empty(directory) or holds_results(directory)):
        raise SpecError(
            f"{directory}: the folder holds other files than results of softact; "
            "name another with -o DIR, or add --force to write into it all the same"
        )


def check_writable(directory: Path) -> None:
    """Raise SpecError where a folder can neither be made nor written."""
    there = next(path for path in (directory, *directory.parents) if path.exists())
    if not there.is_dir() or not os.access(there, os.W_OK | os.X_OK):
        why = "may not be written" if there.is_dir() else "is a file"
        what = "" if there == directory else f"{there} "
        raise SpecError(f"{directory}: {what}{why}; name another folder with -o DIR")


def is_empty(directory: Path) -> bool:
    """Whether a folder is not there, or holds nothing but what a killed softact has left."""
    if not directory.is_dir():
        return True
    return all(path.name == LOCK or is_temporary(path.name) for path in directory.iterdir())

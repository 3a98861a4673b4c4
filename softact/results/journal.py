"""Changes of a binary file that happen all or not at all, whenever the process is killed.

As in a database: what is new goes behind the end of the file, where nobody looks for it yet; what
is changed inside goes into a journal beside the file, then into the file, and the journal is
removed. Where there is a journal, the file is read with its changes.
"""

from __future__ import annotations

import hashlib
import io
import os
import struct
from pathlib import Path
from typing import Any

from softact.files.text import write_atomic

_PATCH = struct.Struct("<QQ")  # place and length
_DIGEST = 32


def journal_of(path: Path) -> Path:
    """Where the journal of a file is, while there is one."""
    return path.with_name(f".{path.name}.journal")


class Overlay(io.RawIOBase):
    """A binary file with the changes of its journal and those written to it, which stay in memory
    until ``commit``. Raises OSError, also where the journal is damaged."""

    def __init__(self, path: Path):
        super().__init__()
        self._path, self._file, self._at = Path(path), open(path, "rb"), 0
        self._size = self._end = os.fstat(self._file.fileno()).st_size
        self._patches = _read_journal(self._path)

    def readable(self) -> bool:
        return True

    def writable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def tell(self) -> int:
        return self._at

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        start = {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self._end}[whence]
        self._at = start + offset
        return self._at

    def truncate(self, size: int | None = None) -> int:
        """Set the end; what is cut off stays in the file."""
        self._end = self._at if size is None else size
        return self._end

    def readinto(self, buffer: Any) -> int:
        view = memoryview(buffer).cast("B")
        length = max(0, min(len(view), self._end - self._at))
        view = view[:length]
        self._file.seek(self._at)
        found = self._file.readinto(view)
        view[found:] = bytes(length - found)
        for place, data in self._patches:
            low, high = max(place, self._at), min(place + len(data), self._at + length)
            if low < high:
                view[low - self._at : high - self._at] = data[low - place : high - place]
        self._at += length
        return length

    def write(self, data: Any) -> int:
        raw = bytes(memoryview(data).cast("B"))
        self._patches.append((self._at, raw))
        self._at += len(raw)
        self._end = max(self._end, self._at)
        return len(raw)

    def commit(self) -> None:
        """Put all changes into the file."""
        inside = [(place, data[: self._size - place]) for place, data in self._patches]
        inside = [(place, data) for place, data in inside if place < self._size]
        with open(self._path, "r+b") as file:
            for place, data in self._patches:
                new = max(0, self._size - place)
                if new < len(data):
                    _write(file, place + new, data[new:])
            _sync(file)
            _write_journal(self._path, inside)
            _apply(file, inside)
        journal_of(self._path).unlink(missing_ok=True)
        self._size, self._patches = max(self._size, self._end), []

    def close(self) -> None:
        self._file.close()
        super().close()


def recover(path: Path) -> None:
    """Finish the change that a kill has interrupted. Raises OSError."""
    patches = _read_journal(path)
    if patches:
        with open(path, "r+b") as file:
            _apply(file, patches)
        journal_of(path).unlink(missing_ok=True)


def _write_journal(path: Path, patches: list[tuple[int, bytes]]) -> None:
    raw = b"".join(_PATCH.pack(place, len(data)) + data for place, data in patches)
    write_atomic(journal_of(path), hashlib.sha256(raw).digest() + raw)


def _read_journal(path: Path) -> list[tuple[int, bytes]]:
    try:
        content = journal_of(path).read_bytes()
    except FileNotFoundError:
        return []
    digest, raw = content[:_DIGEST], content[_DIGEST:]
    if hashlib.sha256(raw).digest() != digest:
        raise OSError(f"its journal {journal_of(path).name} is not as it was written")
    patches, at = [], 0
    while at < len(raw):
        place, length = _PATCH.unpack_from(raw, at)
        at += _PATCH.size
        patches.append((place, raw[at : at + length]))
        at += length
    return patches


def _apply(file: io.BufferedRandom, patches: list[tuple[int, bytes]]) -> None:
    for place, data in patches:
        _write(file, place, data)
    _sync(file)


def _write(file: io.BufferedRandom, place: int, data: bytes) -> None:
    file.seek(place)
    file.write(data)


def _sync(file: io.BufferedRandom) -> None:
    file.flush()
    os.fsync(file.fileno())

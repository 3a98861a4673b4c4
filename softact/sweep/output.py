"""The folder of a sweep: its own files, written by one sweep at a time."""

from __future__ import annotations

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from softact.errors import SpecError


@contextmanager
def written_alone(directory: Path) -> Iterator[None]:
    """Make the folder and hold it; another sweep that writes into it waits for its turn.

    Raises SpecError where it cannot be made or written.
    """
    try:
        directory.mkdir(parents=True, exist_ok=True)
        with open(directory / ".lock", "ab") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            yield
    except (PermissionError, FileExistsError, NotADirectoryError) as error:
        raise SpecError(
            f"{directory}: cannot be written ({error.strerror}); name another folder with -o DIR"
        ) from None
    except OSError as error:
        if error.filename is None and error.errno is None:
            raise
        raise SpecError(f"{directory}: {error.strerror}; the runs are kept in the cache") from None

"""Text files of softact: replaced in one step, CSV with all digits, strict JSON."""

import contextlib
import csv
import errno
import hashlib
import io
import json
import math
import os
import re
import secrets
import stat
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

#: What no further try mends: the disk is full or broken, the folder is no longer writable.
UNWRITABLE = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM, errno.EIO)
_LONGEST = 50  # letters of a file's name in that of its temporary one
_TEMPORARY = re.compile(r"\.(.+)\.[0-9a-f]{16}\.\w+", re.DOTALL)
#: Beside the type of a field of a spec: it names a file, which counts from the spec's folder.
NAMES_A_FILE = "names a file"


@contextlib.contextmanager
def replacing(path: Path, suffix: str = ".tmp") -> Iterator[Path]:
    """A new, empty file beside ``path``, which takes its place in one step when the block is done.

    Nobody can have foreseen its name, and no link is followed: what is written goes into a file of
    softact's. It reaches the disk before the name does, so that a reader sees the old file or the
    whole new one after a power cut too. It has the permissions of the old one. Where the block
    raises, ``path`` stays as it was.
    """
    path = Path(path)
    temporary = path.with_name(f".{path.name[:_LONGEST]}.{secrets.token_hex(8)}{suffix}")
    os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY | os.O_CLOEXEC, 0o666))
    try:
        yield temporary
        with contextlib.suppress(FileNotFoundError):
            there = os.lstat(path).st_mode
            if stat.S_ISREG(there):
                os.chmod(temporary, stat.S_IMODE(there))
        with open(temporary, "rb") as file:
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except BaseException:  # of a full disk, what is half written would take the last
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise


def write_atomic(path: Path, data: str | bytes) -> None:
    """Replace ``path`` by ``data`` in one step, see ``replacing``."""
    with replacing(path) as temporary:
        temporary.write_bytes(data.encode() if isinstance(data, str) else data)


def is_temporary(name: str) -> bool:
    """Whether a file of this name is what ``replacing`` left when it was killed."""
    return _TEMPORARY.fullmatch(name) is not None


def clear_temporaries(directory: Path, names: Iterable[str]) -> None:
    """Remove what ``replacing`` has left of files of these names when it was killed."""
    of = {name[:_LONGEST] for name in names}
    for path in list(directory.iterdir()):
        if (match := _TEMPORARY.fullmatch(path.name)) and match[1] in of:
            path.unlink(missing_ok=True)


def why_unwritable(error: Exception) -> str | None:
    """The system's words for a full or broken disk, or a folder that may not be written; None where
    an error is another one."""
    # HDF5 gives no number, but always the system's words.
    words = " ".join(str(error).split())
    return next((said for number in UNWRITABLE if (said := os.strerror(number)) in words), None)


def digest(path: Path) -> str:
    """16 hexadecimal digits that change with the content of a file. Raises OSError."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:16]


def csv_text(rows: Sequence[Mapping[str, float | str]]) -> str:
    """CSV of ``rows``; columns in order of first appearance, numbers with all their digits.

    A column that a row lacks is left empty in it.
    """
    columns = list(dict.fromkeys(name for row in rows for name in row))
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    table.writerow(columns)
    for row in rows:
        table.writerow([_cell(row.get(name, "")) for name in columns])
    return out.getvalue()


def _cell(value) -> str:
    if value is None:
        return ""
    if isinstance(value, bool | np.bool_):
        return str(bool(value)).lower()
    if isinstance(value, int | np.integer):
        return str(int(value))
    if isinstance(value, float | np.floating):
        return repr(float(value))
    return str(value)


def json_text(data: Mapping) -> str:
    """Strict JSON of ``data``: numpy values become plain ones, NaN and infinities null."""
    return json.dumps(_plain(data), indent=2, allow_nan=False) + "\n"


def _plain(value):
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | np.ndarray):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if value is None or isinstance(value, bool | int | float | str):
        return value
    return str(value)

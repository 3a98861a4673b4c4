"""Files: those of the user read within bounds, those of softact replaced in one step."""

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
from typing import Any

import numpy as np

from softact.errors import NOT_IN_LOCALE, SpecError
from softact.units import one_line, show

#: What no further try mends: the disk is full or broken, the folder is no longer writable.
UNWRITABLE = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM, errno.EIO)
_LONGEST = 50  # letters of a file's name in that of its temporary one
_TEMPORARY = re.compile(r"\.(.+)\.[0-9a-f]{16}\.\w+", re.DOTALL)
#: Beside the type of a field of a spec: it names a file, which counts from the spec's folder.
NAMES_A_FILE = "names a file"

# A spreadsheet computes a cell that begins so, and an apostrophe before it says that it is text.
_FORMULA = re.compile(r"'*[=+@\t\n-]")
_SIGNED = re.compile(r"[+-](?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?(?: ?[A-Za-z°%µ][\w°/^]*)?")


def read_file(path: Path, most: int, wanted: str) -> bytes:
    """The content of a file that the user names, of at most ``most`` bytes.

    wanted: what should have been named, for the end of a message: "the YAML file of a spec".
    Raises SpecError with one line where there is no such file, or a folder, a pipe that nobody may
    ever write into, a device without an end, or more bytes.
    """
    name = one_line(str(path))
    try:
        content = _regular(path, most + 1)
    except IsADirectoryError:
        raise SpecError(f"{name}: this is a folder; give {wanted}") from None
    except FileNotFoundError:
        raise SpecError(f"{name}: there is no such file") from None
    except UnicodeEncodeError:
        raise SpecError(f"{show(name)}: {NOT_IN_LOCALE}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise SpecError(f"{show(name)}: the file cannot be read: {reason}") from None
    if content is None:
        raise SpecError(f"{name}: this is a pipe or a device and no file; give {wanted}")
    if len(content) > most:
        size = f"{most // 1000} kB" if most < 10_000_000 else f"{most // 1_000_000} MB"
        raise SpecError(f"{name}: the file is larger than {size}; give {wanted}")
    return content


def _regular(path: Path, most: int) -> bytes | None:
    """The first bytes of a regular file, None of anything else that can be opened."""
    # Without waiting for the writer of a pipe, or for a terminal.
    handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY)
    try:
        kind = os.fstat(handle).st_mode
        if stat.S_ISDIR(kind):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        if not stat.S_ISREG(kind):
            return None
        with open(handle, "rb", closefd=False) as file:
            return file.read(most)
    finally:
        os.close(handle)


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


def write_atomic(path: Path, data: str | bytes | memoryview) -> None:
    """Replace ``path`` by ``data`` in one step, see ``replacing``. An OSError names ``path``."""
    try:
        with replacing(path) as temporary:
            temporary.write_bytes(data.encode() if isinstance(data, str) else data)
    except OSError as error:
        error.filename = os.fspath(path)
        raise


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


def csv_text(rows: Sequence[Mapping[str, float | str | None]]) -> str:
    """CSV of ``rows``; columns in order of first appearance, numbers with all their digits.

    A column that a row lacks, or has as None, is left empty in it. A text that a spreadsheet would
    take for a formula gets an apostrophe, as spreadsheets do it; ``csv_rows`` takes it away.
    """
    columns = list(dict.fromkeys(name for row in rows for name in row))
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    table.writerow([_cell(name) for name in columns])
    for row in rows:
        table.writerow([_cell(row.get(name, "")) for name in columns])
    return out.getvalue()


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool | np.bool_):
        return str(bool(value)).lower()
    if isinstance(value, int | np.integer):
        return str(int(value))
    if isinstance(value, float | np.floating):
        return repr(float(value))
    text = re.sub("\r\n?", "\n", str(value))
    return f"'{text}" if _FORMULA.match(text) and not _SIGNED.fullmatch(text) else text


def csv_rows(path: Path) -> list[list[str]]:
    """The rows of a CSV of ``csv_text``, its headings first, all cells as text.

    Raises OSError as ``open`` does, and ValueError where it is no text in UTF-8.
    """
    with open(path, newline="", encoding="utf-8") as file:
        return csv_cells(file.read())


def csv_cells(text: str) -> list[list[str]]:
    """The rows of a text of ``csv_text``, its headings first, all cells as text."""
    rows = csv.reader(io.StringIO(text, newline=""))
    return [[_unescaped(cell) for cell in row] for row in rows]


def _unescaped(cell: str) -> str:
    return cell[1:] if cell.startswith("'") and _FORMULA.match(cell) else cell


def json_text(data: Mapping | Sequence) -> str:
    """Strict JSON of ``data``: numpy values become plain ones, NaN and infinities null."""
    return json.dumps(_plain(data), indent=2, allow_nan=False) + "\n"


def _plain(value: Any) -> Any:
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

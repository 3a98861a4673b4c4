"""The file from which a run goes on: an .npz archive whose comment is the checksum of the rest."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from softact.errors import DamagedResultError

RESTART = "restart.npz"

#: What helps where a run cannot go on.
ANEW = "the run cannot go on from it; without --resume it is solved anew"

_MARK = b"sha256:"
_COMMENT = len(_MARK) + 64
_NO_COMMENT = b"\0\0"  # the length of an archive's comment, its last two bytes where there is none


def seal(known: Mapping, arrays: Mapping[str, np.ndarray]) -> bytes:
    """The file's content. known: plain data; arrays: name -> array."""
    buffer = io.BytesIO()
    parts: dict[str, Any] = {"known": np.frombuffer(json.dumps(known).encode(), np.uint8), **arrays}
    np.savez(buffer, **parts)
    raw = buffer.getvalue().removesuffix(_NO_COMMENT) + _COMMENT.to_bytes(2, "little")
    return raw + _MARK + hashlib.sha256(raw).hexdigest().encode()


def unseal(path: Path) -> tuple[dict, np.lib.npyio.NpzFile]:
    """What ``seal`` was given. Raises DamagedResultError where the file is not as it was written,
    FileNotFoundError where there is none."""
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        raise
    except OSError as error:
        raise _damaged(path, f"cannot be read ({error.strerror})") from None
    raw, comment = content[:-_COMMENT], content[-_COMMENT:]
    if comment != _MARK + hashlib.sha256(raw).hexdigest().encode():
        raise _damaged(path, "is damaged: it is not as it was written")
    file = np.load(io.BytesIO(content), allow_pickle=False)
    return json.loads(file["known"].tobytes()), file


def of_another_version(path: Path) -> DamagedResultError:
    """What to say of a file that is whole but holds something else than is expected."""
    return _damaged(path, "was written by another version of softact")


def _damaged(path: Path, what: str) -> DamagedResultError:
    return DamagedResultError(f"{path}: {what}; {ANEW}")

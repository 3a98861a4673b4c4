"""The text of a table's file, in whatever encoding a machine wrote it."""

import codecs
from pathlib import Path

from softact.errors import SpecError
from softact.files.text import read_file

MAX_BYTES = 200_000_000
# The marks of UTF-32 begin with those of UTF-16, so they are tried first.
_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_NO_TEXT = (
    (b"PK\x03\x04", "an Excel or OpenDocument file"),
    (b"\xd0\xcf\x11\xe0", "an Excel file of the old kind"),
    (b"%PDF", "a PDF"),
    (b"\x89HDF", "an HDF5 file"),
    (b"\x1f\x8b", "a compressed file"),
)
_SAMPLE = 4096


def read_text(path: Path) -> str:
    """Return the text of a file: UTF-8, UTF-16 or UTF-32 by its mark, else Windows' Latin-1.

    Raises SpecError where the file cannot be read or is no text.
    """
    raw = read_file(path, MAX_BYTES, "a table of test data")
    for begins, what in _NO_TEXT:
        if raw.startswith(begins):
            raise SpecError(f"{path}: is {what}, not a text file; save the table as CSV")
    try:
        text = raw.decode(_encoding(raw))
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    if "\0" in text:
        raise SpecError(f"{path}: is not a text file; save the table as CSV")
    return text


def _encoding(raw: bytes) -> str:
    for mark, name in _MARKS:
        if raw.startswith(mark):
            return name
    sample = raw[:_SAMPLE]
    # Numbers and Latin letters in UTF-16 without a mark: every other byte is zero.
    even, odd = sample[::2].count(0), sample[1::2].count(0)
    if odd > 0.4 * (len(sample) / 2) and even == 0:
        return "utf-16-le"
    if even > 0.4 * (len(sample) / 2) and odd == 0:
        return "utf-16-be"
    try:
        raw.decode("utf-8")
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8"

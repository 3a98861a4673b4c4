"""The three standard streams, made such that no print to them can fail for want of a character."""

import os
import sys
from typing import Any, TextIO

#: Of ``subprocess``: text that other programs print, whatever the locale.
UTF8: dict[str, Any] = {"encoding": "utf-8", "errors": "replace"}


def make_safe(encoding: str | None = None) -> None:
    """Open what is closed, and print '?' for a character that the terminal cannot show.

    encoding: of standard output and error, by default that of the locale. A stream that was closed
    (``softact ... >&-``) leads nowhere: else the next file that is opened would be the one printed
    into.
    """
    for handle in (0, 1, 2):
        try:
            os.fstat(handle)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest that is free
    for name, errors in (("stdout", "replace"), ("stderr", "backslashreplace")):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))
        elif hasattr(stream, "reconfigure"):  # not where something else stands in for it
            stream.reconfigure(errors=errors, **({"encoding": encoding} if encoding else {}))


def abandon_stdout() -> None:
    """Let what is still to be printed go nowhere: its reader has left, or its disk is full."""
    _abandon(sys.stdout)


def abandon_output() -> None:
    """The same for errors, too: Python 3.13 ends with code 120 where it cannot flush them."""
    _abandon(sys.stdout)
    _abandon(sys.stderr)


def _abandon(stream: TextIO) -> None:
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, stream.fileno())
    except (OSError, ValueError):  # something else stands in for it
        pass
    finally:
        os.close(nowhere)

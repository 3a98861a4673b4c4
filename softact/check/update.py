"""Stored values replaced by what was found, with the reason, in the case's own file."""

from __future__ import annotations

import datetime
import re

from softact.check.cases import CaseFile
from softact.check.compare import Outcome
from softact.errors import SpecError
from softact.files import document
from softact.files.text import digest, write_atomic
from softact.spec.faults import validated
from softact.spec.text import to_text


def update(outcome: Outcome, reason: str) -> list[str]:
    """Write the found values of kind 'computed' into the file; returns old and new in words.

    Exact and published values stay: where one of them deviates, the code or the case is wrong.
    Raises SpecError, and leaves the file alone, where it is not written as it should be or was
    edited while the case ran.
    """
    case, changes = outcome.case, []
    path = case.path.resolve()  # a link stays one
    if digest(path) != case.digest:
        raise SpecError(f"{case.path}: was edited while the case ran; nothing is stored, run again")
    raw = path.read_bytes().decode("utf-8-sig")
    lines = raw.splitlines()
    for difference in outcome.differences:
        stored = difference.value
        if stored.kind != "computed" or difference.found != difference.found:
            continue
        number = case.content.values.index(stored)
        line = case.source.lines["values", number, "value"] - 1
        new = float(f"{difference.found:.7g}")
        lines[line], count = re.subn(
            r"(\bvalue:\s*)" + _NUMBER, rf"\g<1>{new!r}", lines[line], count=1
        )
        if not count:
            raise SpecError(f"{case.path}:{line + 1}: the number has to follow 'value:' here")
        changes.append(f"{stored.title}: {stored.value:.7g} -> {new:.7g}")
    if changes:
        entry = {"date": datetime.date.today().isoformat(), "reason": reason, "changes": changes}
        if "history" not in case.source.data:
            lines.append("history:")
        end = "\r\n" if "\r\n" in raw else "\n"
        text = end.join([*lines, *to_text([entry]).splitlines()]) + end
        validated(document.parse(text, str(case.path)), CaseFile)
        write_atomic(path, text)
    return changes


_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"

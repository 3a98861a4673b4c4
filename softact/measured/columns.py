"""Whether a run of a spec can have a column that somebody asks for, told before it is computed."""

from __future__ import annotations

import re

from softact.measured.curve import run_columns
from softact.measures import MEASURES
from softact.nearest import nearest
from softact.results.folder import BOOKKEEPING
from softact.spec import Spec


def known_columns(spec: Spec) -> list[str]:
    """The measures that a run of the spec can have."""
    return [name for name in run_columns(spec) if name not in BOOKKEEPING]


def column_fault(measure: str, spec: Spec) -> str:
    """Why no run of the spec has a measure of this name, with the nearest; "" where it may."""
    known = known_columns(spec)
    if measure in known:
        return ""
    if measure in MEASURES:
        columns = ", ".join(MEASURES[measure].columns)
        return f"is a group of columns; name one of: {columns}"
    shown = [name for name in known if not re.search(r"_[xyz]_mm$", name)]
    return f"the run has no such column; {nearest(measure, shown)}"

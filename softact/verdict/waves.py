"""Whether the chain of a module buckles with a longer period than the module."""

from __future__ import annotations

import numpy as np

from softact.measures.longer_waves import NAME
from softact.results.folder import Results


def first_waves(results: Results) -> tuple[str, int] | None:
    """The period in words and the row of the first state in which the chain buckles so; None where
    it does in none, or nothing was asked."""
    found = {
        name.removeprefix(NAME): np.flatnonzero(np.nan_to_num(values) > 0)
        for name, values in results.curve.items()
        if name.startswith(NAME)
    }
    rows = {word: int(at[0]) for word, at in found.items() if len(at)}
    return min(rows.items(), key=lambda one: one[1]) if rows else None

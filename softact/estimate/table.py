"""What an estimate gives: a table, and words about it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Estimate:
    """Columns as of curve.csv, over the pressure, and how they were got.

    name: of the spec. method: in a line. columns: title with its unit -> (n,) values. notes: what
    is left out or assumed. reservations: where it is known to be poor for this spec, and why.
    """

    name: str
    method: str
    columns: Mapping[str, np.ndarray]
    notes: Sequence[str]
    reservations: Sequence[str]

    @property
    def pressure(self) -> str:
        """Title of the first column."""
        return next(iter(self.columns))

    def at(self, column: str, pressure: float) -> float:
        """A column at a pressure in kPa, between its rows."""
        return float(np.interp(pressure, self.columns[self.pressure], self.columns[column]))

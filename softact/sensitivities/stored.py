"""The table of derivatives of a result folder."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

from softact.results.folder import SENSITIVITIES


@dataclass(frozen=True)
class Slope:
    """A line of the table. row: of curve.csv; derivative: as it is written; elasticity: % per %,
    None where the figure is zero."""

    row: int
    measure: str
    parameter: str
    at: str
    derivative: float
    unit: str
    elasticity: float | None


def read(directory: Path) -> list[Slope]:
    """The table of a result folder; nothing where there is none. Raises ValueError or KeyError
    where it is damaged."""
    path = directory / SENSITIVITIES
    if not path.is_file():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        return [
            Slope(
                int(line["increment"]), line["measure"], line["parameter"], line["at"],
                float(line["derivative"]), line["unit"],
                float(line["elasticity"]) if line["elasticity"] else None,
            )
            for line in csv.DictReader(file)
        ]  # fmt: skip

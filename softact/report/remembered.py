"""Measured curves that stay with a result folder, so that every report of it shows them."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from softact.errors import SpecError
from softact.files.text import json_text, write_atomic
from softact.measured.curve import Measured
from softact.results.folder import MEASURED


def remember(directory: Path, several: Sequence[Measured]) -> None:
    """Copy measured curves into a result folder, in the units of the run's columns; one of the same
    source that is there is replaced, others stay."""
    if not several:
        return
    new = {measured.source for measured in several}
    kept = [measured for measured in remembered(directory) if measured.source not in new]
    curves = [
        {
            "source": measured.source,
            "x": measured.x,
            "columns": {name: values.tolist() for name, values in measured.values.items()},
        }
        for measured in (*kept, *several)
    ]
    write_atomic(directory / MEASURED, json_text({"curves": curves}))


def remembered(directory: Path) -> list[Measured]:
    """The measured curves of a result folder; none where none were given.

    Raises SpecError where the file cannot be read.
    """
    path = directory / MEASURED
    if not path.is_file():
        return []
    try:
        curves = json.loads(path.read_text(encoding="utf-8"))["curves"]
        return [_measured(curve) for curve in curves]
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise SpecError(
            f"{path}: cannot be read; delete it and give the measured files again with --measured"
        ) from None


def _measured(curve: dict) -> Measured:
    values = {str(name): np.array(column, float) for name, column in curve["columns"].items()}
    rows = {column.shape for column in values.values()}
    if curve["x"] not in values or len(rows) != 1 or len(rows.pop()) != 1 or len(values) < 2:
        raise ValueError("no curve")
    return Measured(str(curve["source"]), str(curve["x"]), values)

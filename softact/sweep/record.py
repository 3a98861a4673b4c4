"""What a table or page needs of a run, in one small file that tells when it is damaged."""

from __future__ import annotations

import base64
import hashlib
import json
import math
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from softact.files.lock import LOCK
from softact.files.text import write_atomic
from softact.results.folder import BOOKKEEPING, NO_EQUILIBRIUM, Results
from softact.verdict import efficiency
from softact.verdict.judge import from_data, judge

RECORD = "record.json"


class DamagedError(Exception):
    """A record or one of the files beside it is not as it was written."""


@dataclass(frozen=True)
class Record:
    """A finished run.

    status: "complete" or "no_equilibrium". cause: why it stopped early, "" otherwise. seconds:
    wall time of the run. measures: column of the last state -> value. columns, steps, table: the
    curve: names of its (c,) columns of numbers, (n,) step of each row, (n, c) float64.
    cells, unknowns: size of the mesh. verdict: ``Verdict.cell`` of the run.
    """

    key: str
    status: str
    cause: str
    seconds: float
    measures: Mapping[str, float]
    columns: tuple[str, ...]
    steps: tuple[str, ...]
    table: np.ndarray
    cells: int
    unknowns: int
    verdict: str = ""

    def curve(self, column: str) -> np.ndarray:
        """(n,) the values of a column over the states."""
        return self.table[:, self.columns.index(column)]


def from_results(key: str, results: Results, seconds: float) -> Record:
    """The record of a run that has ended."""
    numbers = [name for name, values in results.curve.items() if values.dtype == float]
    table = np.column_stack([results.curve[name] for name in numbers]) if numbers else None
    table = np.zeros((0, 0)) if table is None else table
    last = dict(zip(numbers, table[-1].tolist(), strict=True)) if len(table) else {}
    mesh = results.run.get("mesh", {})
    return Record(
        key=key,
        status=results.status,
        cause=_cause(results),
        seconds=seconds,
        measures=_measures(results, last),
        columns=tuple(numbers),
        steps=tuple(str(step) for step in results.curve.get("step", ())),
        table=table,
        cells=int(mesh.get("cells", 0)),
        unknowns=int(mesh.get("unknowns", 0)),
        verdict=(from_data(results.run.get("verdict")) or judge(results)).cell,
    )


def _measures(results: Results, last: Mapping[str, float]) -> dict[str, float]:
    """Those of the last state, and what summary.csv says of the whole run beside them."""
    found = {name: value for name, value in last.items() if name not in BOOKKEEPING}
    return found | efficiency.figures(results)


def _cause(results: Results) -> str:
    messages = [str(message) for message in results.run.get("messages", [])]
    return messages[0] if results.status == NO_EQUILIBRIUM and messages else ""


def store(record: Record, directory: Path) -> None:
    """Write the record into a result folder, with the sizes of all files there."""
    data = asdict(record)
    data["measures"] = {k: v if math.isfinite(v) else None for k, v in record.measures.items()}
    data["table"] = base64.b64encode(record.table.astype("<f8").tobytes()).decode()
    _write(data, directory)


def refresh(directory: Path) -> None:
    """Take over the sizes of the files in the folder of a kept run, after they were changed on
    purpose; nothing where the folder is of no kept run."""
    path = directory / RECORD
    if path.is_file():
        _write(json.loads(path.read_bytes().partition(b"\n")[2]), directory)


def _write(data: dict, directory: Path) -> None:
    own = RECORD, LOCK
    files = (p for p in sorted(directory.iterdir()) if p.is_file() and p.name not in own)
    data["files"] = {path.name: path.stat().st_size for path in files}
    text = json.dumps(data, separators=(",", ":"))
    write_atomic(directory / RECORD, f"{hashlib.sha256(text.encode()).hexdigest()}\n{text}\n")


def load(key: str, directory: Path) -> Record | None:
    """The record in a folder, None where there is none. Raises DamagedError."""
    try:
        raw = (directory / RECORD).read_bytes()
    except (FileNotFoundError, NotADirectoryError):
        return None
    digest, _, text = raw.partition(b"\n")
    text = text.removesuffix(b"\n")
    if hashlib.sha256(text).hexdigest().encode() != digest:
        raise DamagedError(f"{RECORD} is not as it was written")
    data = json.loads(text)
    if data["key"] != key:
        raise DamagedError(f"{RECORD} belongs to another run")
    _check_files(directory, data.pop("files"))
    data["table"] = np.frombuffer(base64.b64decode(data["table"]), "<f8")
    data["table"] = data["table"].reshape(len(data["steps"]), len(data["columns"]))
    data["measures"] = {k: math.nan if v is None else v for k, v in data["measures"].items()}
    return Record(**{**data, "columns": tuple(data["columns"]), "steps": tuple(data["steps"])})


def _check_files(directory: Path, sizes: Mapping[str, int]) -> None:
    folder = os.fspath(directory)  # paths as objects would take as long as all the rest
    for name, size in sizes.items():
        try:
            there = os.stat(f"{folder}{os.sep}{name}").st_size
        except OSError:
            raise DamagedError(f"{name} is missing") from None
        # A report that was built anew since, or its pictures, may have another size.
        if there != size and not name.endswith((".html", ".png")):
            raise DamagedError(f"{name} has {there} bytes instead of {size}")

"""The results of a study as files: sweep.csv, sweep.parquet, curves.h5."""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from softact.errors import SpecError
from softact.files.text import csv_text, replacing, write_atomic
from softact.results.own_folder import Output
from softact.spec.path import single
from softact.sweep.axes import Axis
from softact.sweep.study import Study

if TYPE_CHECKING:
    import pyarrow

TABLE, PARQUET, CURVES = FILES = ("sweep.csv", "sweep.parquet", "curves.h5")
Row = dict[str, float | str]
FIRST = ("point", "run", "status", "cause", "verdict", "unbeaten", "seconds")


def rows(study: Study) -> list[Row]:
    """A row for each point: its number, run, status, cause, verdict, parameters and measures.

    Measures are those of the last state; where a run stopped early, of the last that was reached.
    A parameter that the point leaves at the base's value is empty. Where the sweep has objectives,
    ``unbeaten`` says whether no other point beats it in them.
    """
    found = []
    objectives = study.sweep.objectives
    front = study.front() if objectives else set()
    for number, point in enumerate(study.points):
        answer = study.answer(point)
        row: Row = {
            "point": number,
            "run": point.key or "",
            "status": answer.status if answer else "missing",
            "cause": answer.cause if answer else "",
            "verdict": answer.record.verdict if answer and answer.record else "",
        }
        if objectives:
            row["unbeaten"] = "yes" if number in front else "no"
        for axis in study.sweep.axes:
            value = point.coordinates.get(axis.title)
            row[axis.column] = axis.cell(value) if value is not None else base_cell(study, axis)
        if answer and answer.record:
            row["seconds"] = answer.record.seconds
            row |= answer.record.measures
        found.append(row)
    return found


def base_cell(study: Study, axis: Axis) -> float | str:
    """What the base has on an axis, as its cells are written; "" where that is nothing."""
    for data in (study.base.data, study.resolved):
        try:
            _, value = single(data, axis.path[0])
        except SpecError:
            continue
        if value is not None and not isinstance(value, dict | list):
            return axis.number(value) if axis.is_number else str(value)
    return ""


def measure_columns(table: list[Row], study: Study) -> list[str]:
    """Columns of the rows that are measures."""
    known = {*FIRST, *(axis.column for axis in study.sweep.axes)}
    return list(dict.fromkeys(name for row in table for name in row if name not in known))


def write(study: Study, output: Output) -> list[Row]:
    """Write all files of the table; returns the rows."""
    table = rows(study)
    write_atomic(output.file(TABLE), csv_text(table))
    write_atomic(output.file(PARQUET), parquet(table))
    curves(study, output.file(CURVES))
    return table


def parquet(table: list[Row]) -> bytes:
    """The rows as Parquet; a cell that is empty in a column of numbers is null.

    The columns are made from their bytes: ``pyarrow.array`` of a list would import pandas first.
    """
    import pyarrow
    from pyarrow import parquet as files

    columns = {}
    for name in dict.fromkeys(name for row in table for name in row):
        cells = [row.get(name, "") for row in table]
        if any(isinstance(cell, str) and cell for cell in cells) or all(c == "" for c in cells):
            columns[name] = _texts([str(cell).encode() for cell in cells])
        elif name == "point":
            columns[name] = _numbers(pyarrow.int64(), cells, np.int64)
        else:
            columns[name] = _numbers(pyarrow.float64(), cells, np.float64)
    out = io.BytesIO()
    files.write_table(pyarrow.Table.from_arrays([*columns.values()], names=[*columns]), out)
    return out.getvalue()


def _numbers(kind: pyarrow.DataType, cells: list, dtype: type) -> pyarrow.Array:
    """Array of a ``pyarrow.DataType`` whose values have the bytes of ``dtype``; "" is null."""
    import pyarrow

    there = np.array([cell != "" for cell in cells], bool)
    values: np.ndarray = np.array([0 if cell == "" else cell for cell in cells], dtype)
    valid = np.packbits(there, bitorder="little")
    buffers = [pyarrow.py_buffer(part.tobytes()) for part in (valid, values)]
    return pyarrow.Array.from_buffers(kind, len(cells), buffers)


def _texts(cells: list[bytes]) -> pyarrow.Array:
    """Array of UTF-8 strings."""
    import pyarrow

    ends = np.cumsum([0, *map(len, cells)]).astype(np.int32)
    buffers = [None, pyarrow.py_buffer(ends.tobytes()), pyarrow.py_buffer(b"".join(cells))]
    return pyarrow.Array.from_buffers(pyarrow.string(), len(cells), buffers)


def curves(study: Study, path: Path) -> None:
    """All curves in one HDF5 file, one after the other.

    Datasets: ``run`` (r,) keys; ``first`` (r,) and ``count`` (r,) the rows of each run;
    ``step`` (n,); ``columns/<name>`` (n,) float64, NaN where a run lacks the column.
    """
    import h5py

    records = [a.record for a in study.answers.values() if a.record is not None]
    counts = np.array([len(record.table) for record in records], np.int64)
    first = np.concatenate([[0], np.cumsum(counts)[:-1]]) if len(counts) else counts
    names = list(dict.fromkeys(name for record in records for name in record.columns))
    stacked = np.full((int(counts.sum()), len(names)), math.nan)
    places = {r.columns: [names.index(name) for name in r.columns] for r in records}
    for record, start, count in zip(records, first, counts, strict=True):
        stacked[start : start + count, places[record.columns]] = record.table
    with replacing(path) as temporary, h5py.File(temporary, "w") as file:
        text = h5py.string_dtype()
        file.create_dataset("run", data=[r.key for r in records], dtype=text)
        file["first"], file["count"] = first, counts
        steps = [step for record in records for step in record.steps]
        file.create_dataset("step", data=steps, dtype=text)
        for name, values in zip(names, stacked.T, strict=True):
            file.create_dataset(f"columns/{name}", data=values, compression="gzip")

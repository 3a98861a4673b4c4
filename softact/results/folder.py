"""The result folder: what is in it, read back for the report, for tests and for scripts.

Files may be damaged in any way. What cannot be done without raises DamagedResultError with one line
that names the file; what can is left out and told in ``Results.faults``.
"""

from __future__ import annotations

import contextlib
import csv
import functools
import hashlib
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

import numpy as np

from softact.errors import DamagedResultError, SpecError
from softact.files.restart import RESTART
from softact.files.text import csv_rows
from softact.mesh.layout import Layout
from softact.results import fields_file
from softact.results.run_json import (
    COMPLETE,
    INCOMPLETE,
    NO_EQUILIBRIUM,
    RUN,
    SOLVE_AGAIN,
    damaged,
    read_run,
    run_faults,
)
from softact.results.run_log import LOG

__all__ = ["COMPLETE", "INCOMPLETE", "NO_EQUILIBRIUM", "Curve", "Results", "read", "read_run"]

SPEC, CURVE, SUMMARY = "spec.yaml", "curve.csv", "summary.csv"
FIELDS, XDMF = "fields.h5", "fields.xdmf"
MESH_ERROR = "mesh_error.json"
MEASURED = "measured.json"
CURVATURE = "curvature.csv"
SENSITIVITIES, TOLERANCES = "sensitivities.csv", "tolerances.csv"
#: Files whose checksums run.json holds at the end of a run.
SIGNED = (SPEC, CURVE, SUMMARY, MESH_ERROR, SENSITIVITIES)
#: Columns of curve.csv that hold words.
TEXTS = ("step", "control")
#: Columns that say where a row stands or where a largest value lies; not results themselves.
BOOKKEEPING = {
    "step",
    "increment",
    "step_fraction",
    "time_s",
    "newton_iterations",
    "residual",
    "iterations",
    "unstable_modes",
    "control",
    "kinetic_ratio",
}

#: Every file that softact itself puts into a result folder, ``run.json`` excepted.
OWN_FILES = (
    SPEC,
    CURVE,
    SUMMARY,
    SENSITIVITIES,
    TOLERANCES,
    XDMF,
    FIELDS,
    "report.html",
    CURVATURE,
    "curve.png",
    "states.png",
    "shape.png",
    "animation.gif",
    "animation.mp4",
    LOG,
    RESTART,
    MESH_ERROR,
    MEASURED,
)


class Curve(dict):
    """column -> (increments,) of a table; a column that is not there, and has to be, is a damage of
    its file."""

    def __init__(self, path: Path, columns: dict[str, np.ndarray]):
        super().__init__(columns)
        self._path = path

    def __missing__(self, name: str) -> NoReturn:
        raise damaged(self._path, f"it has no column '{name}'")


@dataclass(frozen=True)
class Results:
    """A result folder as read; fields stay on disk until ``field`` asks for one.

    run: run.json. curve: column -> (increments,) floats, or strings where none is a number.
    summary: column -> number or string. points (n, 3) mm, cells (m, 10), region (m,), surfaces:
    name -> (k, 6) or (k, 3); these and layout are empty where the run ended before its mesh, see
    ``has_mesh``. increments: names in fields.h5 of the states, one for each row. faults: files that
    are there but cannot be read, with the reason.
    """

    directory: Path
    run: dict
    spec_yaml: str
    curve: dict[str, np.ndarray]
    summary: dict[str, float | str]
    points: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    cells: np.ndarray = field(default_factory=lambda: np.zeros((0, 10), int))
    region: np.ndarray = field(default_factory=lambda: np.zeros(0, int))
    region_names: tuple[str, ...] = ()
    surfaces: dict[str, np.ndarray] = field(default_factory=dict)
    layout: Layout = field(default_factory=lambda: Layout((), (), {}))
    increments: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()

    @property
    def has_mesh(self) -> bool:
        """Whether there is a mesh that can be read."""
        return len(self.points) > 0

    @property
    def status(self) -> str:
        """ "complete", "no_equilibrium" or "incomplete"."""
        return self.run["status"]

    @property
    def spec(self) -> dict:
        """The resolved spec as plain data; empty where it cannot be read, see ``spec_faults``."""
        return self._parsed[0]

    @property
    def spec_faults(self) -> list[str]:
        """What is wrong with spec.yaml."""
        return self._parsed[1]

    @functools.cached_property
    def _parsed(self) -> tuple[dict, list[str]]:
        from softact.files import document

        if not self.spec_yaml:
            return {}, []
        path = self.directory / SPEC
        try:
            return document.parse(self.spec_yaml, path.name).data, []
        except SpecError as error:
            return {}, damaged(path, error.lines[0]).lines

    def field_names(self, number: int) -> tuple[str, ...]:
        """Names of the fields of state ``number``. Raises DamagedResultError."""
        with fields_file.opened(self.directory / FIELDS) as file:
            return tuple(file["increments"][self.increments[number]])

    def field(self, number: int, name: str) -> np.ndarray:
        """(n,) or (n, 3) field ``name`` of state ``number`` (row of the curve), or (m,) where it is
        one of cells. Raises DamagedResultError, also where it is not there."""
        with fields_file.opened(self.directory / FIELDS) as file:
            item = file["increments"][self.increments[number]][name]
            if self.points is None or self.region is None:
                raise damaged(self.directory / FIELDS, "it holds no mesh")
            counts = len(self.points), len(self.region)
            return fields_file.field(item, counts, vector=name == "displacement")

    def scalar(self, number: int, name: str) -> np.ndarray:
        """(n,) the field, or its magnitude where it is a vector field."""
        values = self.field(number, name)
        return values if values.ndim == 1 else np.linalg.norm(values, axis=1)


def checksums(directory: Path) -> dict[str, str]:
    """Name of a file that can be read -> what changes with its content, for run.json."""
    found = {}
    for name in SIGNED:
        with contextlib.suppress(OSError):
            content = (directory / name).read_bytes()
            found[name] = hashlib.sha256(content).hexdigest()[:16]
    with contextlib.suppress(OSError):  # it holds its checksums itself
        found[FIELDS] = f"{(directory / FIELDS).stat().st_size} bytes"
    return found


def holds_results(directory: Path) -> bool:
    """Whether a folder is a result folder of softact, finished or not, sound or not."""
    try:
        read_run(directory)
    except (FileNotFoundError, NotADirectoryError):
        return False
    except DamagedResultError:
        beside = (SPEC, CURVE, FIELDS)
        return (directory / RESTART).is_file() or all((directory / n).is_file() for n in beside)
    return True


def read(directory: str | Path) -> Results:
    """Read a result folder, finished or not.

    Raises SpecError when the folder is not one of softact's, DamagedResultError where its figures
    cannot be read.
    """
    directory = Path(directory)
    try:
        run = read_run(directory)
    except (FileNotFoundError, NotADirectoryError):
        raise SpecError(
            f"{directory}: no {RUN} in it, so it is not a result folder of softact"
        ) from None
    curve = _read_columns(directory / CURVE, whole=True, wanted=run["status"] != INCOMPLETE)
    summary = _read_columns(directory / SUMMARY)
    spec_yaml, faults = _read_spec(directory / SPEC)
    there = checksums(directory)
    changed = [name for name, sum_ in (run.get("files") or {}).items() if there.get(name) != sum_]
    if CURVE in changed and not any(map(len, curve.values())):
        raise damaged(directory / CURVE, "it has no rows")
    faults += [f"{directory / name}: is not as the run wrote it; {SOLVE_AGAIN}" for name in changed]
    faults += run_faults(directory)
    try:
        mesh = fields_file.read_mesh(directory / FIELDS)
    except DamagedResultError as error:
        mesh, faults = {}, [*faults, *error.lines]
    # A run killed between its two writes has fields whose row is missing.
    rows = len(next(iter(curve.values()), ()))
    mesh["increments"] = mesh.get("increments", ())[:rows]
    return Results(
        directory=directory,
        run=run,
        spec_yaml=spec_yaml,
        curve=curve,
        summary={name: values[0] for name, values in summary.items() if len(values)},
        faults=tuple(faults),
        **mesh,
    )


def is_pressure(name: str) -> bool:
    """Whether a column of the curve holds the pressure of a cavity."""
    return name.startswith("pressure_") and name.endswith("_kPa")


def load_name(results: Results) -> str | None:
    """Column that the curves are drawn against: the pressure that changes most, if any does."""
    best, span = None, 0.0
    for name, values in results.curve.items():
        if is_pressure(name) and values.dtype == float:
            width = np.ptp(values[np.isfinite(values)]) if np.isfinite(values).any() else 0.0
            if width > span:
                best, span = name, width
    return best


def load(results: Results) -> np.ndarray:
    """(rows,) the load of each state: kPa of ``load_name``, else finished steps and fraction."""
    name = load_name(results)
    if name:
        return results.curve[name]
    rows = len(next(iter(results.curve.values()), ()))
    if "step_fraction" not in results.curve:
        return np.arange(rows, dtype=float)
    names = results.curve.get("step", np.zeros(rows))
    begun = np.cumsum([0, *(names[1:] != names[:-1])]) if rows else np.zeros(0)
    return begun + results.curve["step_fraction"]


def load_text(results: Results, row: int) -> str:
    """The load of a state in words: "31.2 kPa", or "40 % of step 'pull'" without a pressure."""
    if load_name(results):
        return f"{load(results)[row]:.4g} kPa"
    curve = results.curve
    if "step" in curve and "step_fraction" in curve:
        return f"{100 * curve['step_fraction'][row]:.4g} % of step '{curve['step'][row]}'"
    return f"state {row}"


def place_text(place: Iterable[float]) -> str:
    """Coordinates in mm: "23.0, 1.7, 0.0"."""
    return ", ".join(f"{round(float(c), 1) + 0.0:.1f}" for c in place)  # no -0.0


def rest_state(results: Results) -> int:
    """Last state before the load begins to grow, -1 where the first row is loaded already."""
    values = load(results)
    unloaded = np.flatnonzero(np.abs(values) > 1e-9 * np.abs(values).max(initial=0))
    return int(unloaded[0]) - 1 if len(unloaded) else len(values) - 1


def read_cells(path: Path) -> tuple[list[str], list[list[str]]]:
    """Heads and rows of a table, as they are written. Raises DamagedResultError."""
    try:
        table = csv_rows(path)
    except (OSError, ValueError, csv.Error) as error:
        raise damaged(path, error) from None
    if not table:  # what softact writes has a line at least
        raise damaged(path, "it is empty")
    heads, rows = table[0], table[1:]
    if len(set(heads)) < len(heads) or "" in heads:
        raise damaged(path, "its columns have no names, or two of them the same")
    for number, row in enumerate(rows, 2):
        if len(row) != len(heads):
            raise damaged(path, f"line {number} has {len(row)} cells, and {len(heads)} columns")
    return heads, rows


def _read_columns(path: Path, whole: bool = False, wanted: bool = False) -> Curve:
    """whole: a column with numbers has nothing else. wanted: the file cannot be missing."""
    if not path.exists() and not wanted:
        return Curve(path, {})
    heads, rows = read_cells(path)
    cells = zip(*rows, strict=True) if rows else [()] * len(heads)
    columns = zip(heads, cells, strict=True)
    return Curve(path, {name: _column(path, name, c, whole) for name, c in columns})


def _column(path: Path, name: str, cells: Sequence[str], whole: bool) -> np.ndarray:
    if name in TEXTS:
        return np.array(cells, dtype=object)
    numbers = [_number(cell) for cell in cells]
    wrong = [line for line, number in enumerate(numbers, 2) if number is None]
    if not wrong:
        return np.array(numbers, dtype=float)
    if whole and len(wrong) < len(cells):
        cell = cells[wrong[0] - 2]
        raise damaged(path, f"line {wrong[0]}, column '{name}': {cell!r} is no number")
    return np.array(cells, dtype=object)


def _number(cell: str) -> float | None:
    try:
        return float(cell) if cell else math.nan
    except ValueError:
        return None


def _read_spec(path: Path) -> tuple[str, list[str]]:
    """Its text and what is wrong with it."""
    try:
        return path.read_text(encoding="utf-8"), []
    except FileNotFoundError:
        return "", []
    except (OSError, ValueError) as error:
        return "", damaged(path, error).lines

"""The result folder: what is in it, read back for the report, for tests and for scripts."""

import json
import math
from collections.abc import Iterable
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from softact.errors import SpecError
from softact.files import csv_rows
from softact.geometry import Layout

INCOMPLETE = "incomplete"
COMPLETE = "complete"
NO_EQUILIBRIUM = "no_equilibrium"

RESTART = "restart.npz"
MESH_ERROR = "mesh_error.json"
MEASURED = "measured.json"

#: Every file that softact itself puts into a result folder, ``run.json`` excepted.
OWN_FILES = (
    "spec.yaml",
    "curve.csv",
    "summary.csv",
    "fields.xdmf",
    "fields.h5",
    "report.html",
    "curve.png",
    "states.png",
    "shape.png",
    "animation.gif",
    "animation.mp4",
    "log.txt",
    RESTART,
    MESH_ERROR,
    MEASURED,
)


@dataclass(frozen=True)
class Results:
    """A result folder as read; fields stay on disk until ``field`` asks for one.

    run: run.json. curve: column -> (increments,) floats, or strings where not all are numbers.
    summary: column -> number or string. points (n, 3) mm, cells (m, 10), region (m,), surfaces:
    name -> (k, 6) or (k, 3); these and layout are None or empty where the run ended before its
    mesh. increments: names in fields.h5 of the states, one for each row. faults: files that are
    there but cannot be read, with the reason (a run killed while it wrote fields.h5).
    """

    directory: Path
    run: dict
    spec_yaml: str
    curve: dict[str, np.ndarray]
    summary: dict[str, float | str]
    points: np.ndarray | None = None
    cells: np.ndarray | None = None
    region: np.ndarray | None = None
    region_names: tuple[str, ...] = ()
    surfaces: dict[str, np.ndarray] | None = None
    layout: Layout | None = None
    increments: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()

    @property
    def status(self) -> str:
        """ "complete", "no_equilibrium" or "incomplete"."""
        return self.run.get("status", INCOMPLETE)

    @cached_property
    def spec(self) -> dict[str, Any]:
        """The resolved spec as plain data; empty where spec.yaml is missing or damaged."""
        from softact.spec import document  # which imports the geometries

        try:
            return document.parse(self.spec_yaml, "spec.yaml").data
        except SpecError:
            return {}

    def field_names(self, number: int) -> tuple[str, ...]:
        """Names of the fields of state ``number``."""
        with h5py.File(self.directory / "fields.h5", "r") as file:
            return tuple(file["increments"][self.increments[number]])

    def field(self, number: int, name: str) -> np.ndarray:
        """Field ``name`` of state ``number`` (row of the curve); KeyError if it is not there.

        Raises SpecError where fields.h5 is damaged."""
        with h5py.File(self.directory / "fields.h5", "r") as file:
            return _whole(file["increments"][self.increments[number]][name])

    def scalar(self, number: int, name: str) -> np.ndarray:
        """(n,) the field, or its magnitude where it is a vector field."""
        values = self.field(number, name)
        return values if values.ndim == 1 else np.linalg.norm(values, axis=1)


def read(directory: str | Path) -> Results:
    """Read a result folder, finished or not.

    Raises SpecError when the folder is not one of softact's.
    """
    directory = Path(directory)
    if not (directory / "run.json").is_file():
        raise SpecError(f"{directory}: no run.json in it, so it is not a result folder of softact")
    try:
        run = json.loads((directory / "run.json").read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise SpecError(f"{directory / 'run.json'}: not JSON: {error}") from error
    spec = directory / "spec.yaml"
    curve = _read_columns(directory / "curve.csv")
    mesh = _read_mesh(directory / "fields.h5")
    # A run killed between its two writes has fields whose row is missing.
    rows = len(next(iter(curve.values()), ()))
    mesh["increments"] = mesh.get("increments", ())[:rows]
    return Results(
        directory=directory,
        run=run,
        spec_yaml=spec.read_text(encoding="utf-8", errors="replace") if spec.is_file() else "",
        curve=curve,
        summary={k: v[0] for k, v in _read_columns(directory / "summary.csv").items() if len(v)},
        **mesh,
    )


def load_name(results: Results) -> str | None:
    """Column that the curves are drawn against: the pressure that changes most, if any does."""
    best, span = None, 0.0
    for name, values in results.curve.items():
        if name.startswith("pressure_") and name.endswith("_kPa") and values.dtype == float:
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


def _read_columns(path: Path) -> dict[str, np.ndarray]:
    if not path.is_file():
        return {}
    table = csv_rows(path)
    if not table:
        return {}
    return {name: _column([row[place] for row in table[1:]]) for place, name in enumerate(table[0])}


def _column(cells: list[str]) -> np.ndarray:
    try:
        return np.array([float(cell) if cell else math.nan for cell in cells])
    except ValueError:
        return np.array(cells, dtype=object)


def sheets_of(mesh: h5py.Group) -> tuple[int, int] | None:
    """Shape of the triangles of the sheets beside a solid, of a mesh in fields.h5; None: there are
    none."""
    layout = _layout(json.loads(_text(mesh["layout"])))
    shapes = [mesh["surfaces"][name].shape for name in layout.covers]
    return (sum(shape[0] for shape in shapes), shapes[0][1]) if shapes else None


def _read_mesh(path: Path) -> dict:
    if not path.is_file():
        return {}
    try:
        with h5py.File(path, "r") as file:
            mesh = file["mesh"]
            return {
                "points": _whole(mesh["points"]),
                "cells": _whole(mesh["cells"]),
                "region": _whole(mesh["region"]),
                "region_names": tuple(json.loads(_text(mesh["region_names"]))),
                "surfaces": {name: _whole(item) for name, item in mesh["surfaces"].items()},
                "layout": _layout(json.loads(_text(mesh["layout"]))),
                "increments": tuple(file["increments"]),
            }
    except (OSError, KeyError, SpecError) as error:
        return {"faults": (f"{path.name} cannot be read: {error}",)}


def _whole(item: h5py.Dataset) -> np.ndarray:
    """All numbers of a dataset. Raises SpecError where there cannot be so many in the file: softact
    compresses nothing, and a damaged size would take all memory."""
    _check_size(item)
    return item[()]


def _text(item: h5py.Dataset) -> str:
    """The text of a dataset. Raises as ``_whole``."""
    _check_size(item)
    return item.asstr()[()]


def _check_size(item: h5py.Dataset) -> None:
    path = Path(item.file.filename)
    if item.nbytes > path.stat().st_size:
        raise SpecError(
            f"{path}: is damaged: {item.name} would take {item.nbytes:.2g} bytes, and the file has "
            f"{path.stat().st_size:.2g}; solve the spec again"
        )


def _layout(data: dict) -> Layout:
    """Layout from its JSON form; keys of a newer or older softact are left out."""
    known = {item.name for item in fields(Layout)}
    tuples = {k: tuple(v) if isinstance(v, list) else v for k, v in data.items() if k in known}
    tuples["cavities"] = {k: tuple(v) for k, v in data["cavities"].items()}
    return Layout(**tuples)

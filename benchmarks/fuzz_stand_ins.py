"""What stands in for gmsh, the solver and the drawing while softact is fuzzed in one process.

All else is the real thing. A run ends as the hash of its spec says: with results of made-up numbers
under the columns that it would have, with results up to a limit point, or with a mesh that fails.
"""

from __future__ import annotations

import inspect
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from unittest import mock

import numpy as np

from softact.cli import doctor
from softact.doctor import Finding
from softact.errors import MeshError
from softact.geometry import base
from softact.measured.curve import run_columns
from softact.mesh.layout import Layout
from softact.preview import look
from softact.report import frames
from softact.results.folder import COMPLETE, NO_EQUILIBRIUM
from softact.results.writer import ResultsWriter
from softact.run import start

ROWS = 3
NOT_DRAWN = "not drawn here"
_CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
_TET = np.array([[0, 1, 2, 3]])
_SURFACES = {"clamp": np.array([[0, 2, 1]])}
_LAYOUT = Layout(regions=("body",), surfaces=("clamp",), cavities={})


def _not_drawing(arguments: object, variables: object) -> list[str]:
    return ["/bin/sh", "-c", f"echo {NOT_DRAWN} >&2; exit 3"]


@contextmanager
def stand_ins(restart: Path, sound: str) -> Iterator[None]:
    """Everything slow replaced. restart: a restart file, which every run leaves a copy of.
    sound: hash of the spec whose runs do not fail."""

    def solve(self, notes: Sequence[str], processes: int, threads: int | None) -> Mapping:
        return _solved(self.spec, self.directory, self.progress, restart, sound)

    with ExitStack() as stack:
        for place, name, other in (
            (start._Solver, "run", solve),
            (base, "_run_gmsh", _meshed),
            (look, "make_mesh", _not_meshed),
            (frames, "command", _not_drawing),
            (doctor, "examine", lambda: [Finding("Python", "ok", "as it should be")]),
        ):
            if callable(other):
                _called_alike(getattr(place, name), other)
            stack.enter_context(mock.patch.object(place, name, other))
        yield


def _called_alike(there: Callable, other: Callable) -> None:
    """What stands in takes what the thing itself takes; else it would be a fault of the fuzzer."""
    names, others = (list(inspect.signature(each).parameters) for each in (there, other))
    assert names == others, f"{there.__qualname__} takes {names}, its stand-in {others}"


def _meshed(
    geometry, path: Path, timeout: float, part: str, said: list[str], more: Mapping | None = None
) -> None:
    if path.suffix == ".npz":  # how points move: nothing stands in for what is read again
        raise MeshError("gmsh did not finish within 300 s and was stopped")
    if part != "look":
        path.write_bytes(base.ENDS.get(path.suffix, b"mesh"))


def _not_meshed(geometry, path: Path, timeout: float = 300.0, curved: bool = False) -> list[str]:
    """For previews, which read what they mesh."""
    raise MeshError("gmsh did not finish within 300 s and was stopped")


def _solved(spec, directory: Path, progress, restart: Path, sound: str) -> Mapping:
    number = zlib.crc32(spec.hash.encode())
    ends = number % 10 if spec.hash != sound else None
    progress({"stage": "mesh"})
    if ends == 0:
        raise MeshError("block: gmsh did not finish within 300 s and was stopped")
    status = NO_EQUILIBRIUM if ends == 1 else COMPLETE
    known = {"spec_hash": spec.hash, "processes": 1, "mesh": {"cells": 1, "unknowns": 12}}
    writer = ResultsWriter(directory, spec.to_yaml(), known)
    progress({"stage": "solve", "cells": 1, "unknowns": 12})
    writer.mesh(_CORNERS, _TET, np.zeros(1), ["body"], _SURFACES, _LAYOUT)
    row: dict = {}
    for step in spec.steps:
        for part in np.linspace(0, 1 if status == COMPLETE else 0.5, ROWS):
            columns = [name for name in run_columns(spec) if name != "step_fraction"]
            row = {"step": step.name, "increment": 1, "step_fraction": float(part)}
            row |= {name: _made_up(name, number) * float(part) for name in columns}
            writer.increment(row, {"displacement": 0.1 * part * _CORNERS})
            progress({"stage": "increment", "fraction": float(part), "iterations": 3, **row})
    writer.checkpoint(restart.read_bytes())
    said = ["step: no further equilibrium was found"] if status == NO_EQUILIBRIUM else []
    writer.finish(status, row, {"messages": said})
    return {"stage": "done", "status": status, "message": said[0] if said else None}


def _made_up(column: str, number: int) -> float:
    """Other numbers for each column and each spec, of either sign."""
    return zlib.crc32(f"{column}{number}".encode()) / 2**31 - 0.8

"""The result folder, written increment by increment so that no moment of a run looks complete.

``ResultsWriter`` is used by one process (rank 0). Every file is replaced in one step (temporary
file, then rename), and ``fields.h5`` changed in one (see ``softact.results.fields_file``);
``run.json`` says "incomplete" from the first moment to the last.
"""

import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from softact.errors import SpecError
from softact.files.restart import ANEW, RESTART
from softact.files.text import clear_temporaries, csv_cells, csv_text, write_atomic
from softact.mesh.layout import Layout
from softact.results import fields_file
from softact.results.fields_file import sheets_of, write_array, write_text
from softact.results.folder import (
    CURVE,
    FIELDS,
    MESH_ERROR,
    OWN_FILES,
    SENSITIVITIES,
    SPEC,
    SUMMARY,
    XDMF,
    checksums,
)
from softact.results.journal import journal_of, recover
from softact.results.run_json import COMPLETE, INCOMPLETE, NO_EQUILIBRIUM, RUN, damaged, run_text
from softact.results.xdmf import Xdmf, mixed


class ResultsWriter:
    """Makes a result folder and fills it while a run goes on.

    directory: the folder; an old result folder there is cleared of softact's own files, others
        are left alone.
    spec_yaml: the resolved spec, stored as ``spec.yaml``.
    provenance: what is known at the start (versions, hashes); stored in ``run.json``.

    Call ``mesh`` once, ``increment`` for every accepted state, ``finish`` at the end. A process
    killed at any moment leaves no folder or one whose ``run.json`` says "incomplete", with a
    ``curve.csv`` that can be read. Only the current increment is held in memory.

    Raises SpecError when ``directory`` is the name of a file.
    """

    def __init__(self, directory: str | Path, spec_yaml: str, provenance: Mapping | None = None):
        self.directory = Path(directory)
        self._provenance = dict(provenance or {})
        self._rows: list[dict[str, float | str]] = []
        self._steps: list[str] = []
        self._xdmf: Xdmf | None = None
        self._open_folder()
        write_atomic(self.directory / SPEC, spec_yaml)

    @classmethod
    def reopen(
        cls, directory: str | Path, spec_yaml: str, provenance: Mapping | None, curve: str
    ) -> "ResultsWriter":
        """Go on with the folder of a run that ended early, or that is to be extended.

        curve: text of curve.csv with the increments to keep; what was written after them is
        dropped. The folder says "incomplete" again from here on. Raises DamagedResultError, with
        nothing changed, where fields.h5 cannot be read or lacks some of them.
        """
        writer = cls.__new__(cls)
        writer.directory = Path(directory)
        writer._provenance = dict(provenance or {})
        writer._steps = []
        names, *cells = csv_cells(curve)
        writer._rows = [dict(zip(names, row, strict=True)) for row in cells]
        fields = writer.directory / FIELDS
        try:
            recover(fields)
        except OSError as error:
            raise damaged(fields, error, ANEW) from None
        with fields_file.opened(fields, ANEW) as file:
            names = list(file["increments"])
            if len(names) < len(writer._rows):
                raise ValueError(f"{len(names)} of {len(writer._rows)} increments are there")
            writer._xdmf = writer._described(file)
        write_atomic(writer.directory / RUN, writer._run_json(INCOMPLETE))
        made_of_the_end = SUMMARY, "report.html", "curve.png", "states.png", "shape.png"
        for name in (*made_of_the_end, MESH_ERROR):
            (writer.directory / name).unlink(missing_ok=True)
        if len(names) > len(writer._rows):
            with fields_file.changed(fields) as file:
                for name in names[len(writer._rows) :]:
                    del file["increments"][name]
        write_atomic(writer.directory / SPEC, spec_yaml)
        write_atomic(writer.directory / XDMF, writer._xdmf.text())
        write_atomic(writer.directory / CURVE, writer.curve)
        return writer

    def _described(self, file: h5py.File) -> Xdmf:
        """The XDMF of the increments of the rows so far. Raises ValueError where one of them is not
        as it was written: it would stay in the folder."""
        found = Xdmf(len(file["mesh/points"]), file["mesh/cells"].shape, sheets_of(file["mesh"]))
        for row, name in zip(self._rows, file["increments"], strict=False):
            items = dict(file["increments"][name].items())
            if not all(isinstance(field, str) and field.isprintable() for field in items):
                raise ValueError(f"increment {name} has fields without a name")
            values = {field: fields_file.array(item) for field, item in items.items()}
            found.add(self._time(row), f"increments/{name}", values)
        return found

    @property
    def curve(self) -> str:
        """Text of curve.csv so far."""
        return csv_text(self._rows)

    @property
    def last_row(self) -> dict[str, float | str]:
        """The last row, numbers as numbers."""
        return {name: _number(cell) for name, cell in self._rows[-1].items()} if self._rows else {}

    def checkpoint(self, data: bytes) -> None:
        """Store what a run needs to go on from here."""
        write_atomic(self.directory / RESTART, data)

    def sensitivities(self, text: str) -> None:
        """Store the table of derivatives as it is now."""
        write_atomic(self.directory / SENSITIVITIES, text)

    @property
    def sensitivities_so_far(self) -> str:
        """The table of derivatives that is there; empty where there is none that can be read."""
        try:
            return (self.directory / SENSITIVITIES).read_text(encoding="utf-8")
        except (OSError, ValueError):
            return ""

    def _open_folder(self) -> None:
        """Make the folder such that it says "incomplete" from its first moment."""
        directory = self.directory
        if directory.exists() and not directory.is_dir():
            raise SpecError(f"{directory}: is a file; a result folder needs another name (-o DIR)")
        start = self._run_json(INCOMPLETE)
        if directory.is_dir():
            write_atomic(directory / RUN, start)
            for name in OWN_FILES:
                (directory / name).unlink(missing_ok=True)
            clear_temporaries(directory, OWN_FILES)
            journal_of(directory / FIELDS).unlink(missing_ok=True)
            return
        directory.parent.mkdir(parents=True, exist_ok=True)
        nursery = directory.with_name(f".{directory.name}.new")
        shutil.rmtree(nursery, ignore_errors=True)
        nursery.mkdir()
        write_atomic(nursery / RUN, start)
        nursery.rename(directory)

    def mesh(
        self,
        points: np.ndarray,
        cells: np.ndarray,
        region: np.ndarray,
        region_names: Sequence[str],
        surfaces: Mapping[str, np.ndarray],
        layout: Layout,
    ) -> None:
        """Store the mesh.

        points: (n, 3) mm, undeformed nodes. cells: (m, 10) tets in VTK's order (or (m, 4)).
        region: (m,) index into ``region_names``. surfaces: name -> (k, 6) or (k, 3) triangles
        in VTK's order; of an actuator with a solid and sheets, the sheets too.
        """
        points = np.asarray(points, dtype=float)
        cells = np.asarray(cells, dtype=np.int64)
        with fields_file.created(self.directory / FIELDS) as file:
            mesh = file.create_group("mesh")
            write_array(mesh, "points", points)
            write_array(mesh, "cells", cells)
            region = np.asarray(region, dtype=np.int32)
            write_array(mesh, "region", region)
            write_text(mesh, "region_names", json.dumps(list(region_names)))
            write_text(mesh, "layout", json.dumps(asdict(layout)))
            surface_group = mesh.create_group("surfaces")
            for name, triangles in surfaces.items():
                write_array(surface_group, name, np.asarray(triangles, dtype=np.int64))
            file.create_group("increments")
            sheets = sheets_of(mesh)
            if sheets:
                blocks = [np.asarray(surfaces[name], dtype=np.int64) for name in layout.sheets]
                numbers = len(region_names) + np.arange(len(blocks), dtype=np.int32)
                of_sheets = np.repeat(numbers, [len(block) for block in blocks])
                write_array(mesh, "mixed", mixed(cells, np.concatenate(blocks)))
                write_array(mesh, "part", np.concatenate([region, of_sheets]))
        self._xdmf = Xdmf(len(points), (len(cells), cells.shape[1]), sheets)

    def increment(
        self, row: Mapping[str, float | str], fields: Mapping[str, np.ndarray] | None = None
    ) -> None:
        """Add an accepted state.

        row: a row of ``curve.csv``. fields: name -> (n,) or (n, 3) nodal values, or (m,) per
        cell; displacement (mm) is stored in double, the others in single precision.
        Raises RuntimeError when fields come before the mesh.
        """
        if fields:
            self._write_fields(row, fields)
        self._rows.append(dict(row))
        write_atomic(self.directory / CURVE, self.curve)

    def _write_fields(self, row: Mapping[str, Any], fields: Mapping[str, np.ndarray]) -> None:
        if self._xdmf is None:
            raise RuntimeError("ResultsWriter.mesh must be called before fields are written")
        number = len(self._rows)
        arrays = {}
        with fields_file.changed(self.directory / FIELDS) as file:
            group = file["increments"].create_group(f"{number:05d}")
            for name, values in fields.items():
                precision = np.float64 if name == "displacement" else np.float32
                arrays[name] = np.asarray(values, dtype=precision)
                write_array(group, name, arrays[name])
        self._xdmf.add(self._time(row), f"increments/{number:05d}", arrays)
        write_atomic(self.directory / XDMF, self._xdmf.text())

    def _time(self, row: Mapping[str, Any]) -> float:
        """Time of the XDMF collection: finished steps plus the fraction of the current one."""
        if "step_fraction" not in row:
            return float(len(self._rows))
        step = str(row.get("step", ""))
        if not self._steps or self._steps[-1] != step:
            self._steps.append(step)
        return len(self._steps) - 1 + float(row["step_fraction"])

    def finish(
        self,
        status: str,
        summary: Mapping[str, float | str] | None = None,
        provenance: Mapping | None = None,
    ) -> None:
        """Write ``summary.csv`` and, last of all, ``run.json`` with the final ``status``.

        status: "complete" or "no_equilibrium"; anything else raises ValueError.
        """
        if status not in (COMPLETE, NO_EQUILIBRIUM):
            raise ValueError(f"status {status!r}: must be {COMPLETE!r} or {NO_EQUILIBRIUM!r}")
        if not self._rows:
            write_atomic(self.directory / CURVE, csv_text([]))
        write_atomic(self.directory / SUMMARY, csv_text([dict(summary or {})]))
        self._provenance.update(provenance or {})
        self._provenance["files"] = checksums(self.directory)
        write_atomic(self.directory / RUN, self._run_json(status))

    def _run_json(self, status: str) -> str:
        known = {name: v for name, v in self._provenance.items() if name != "status"}
        return run_text({"status": status, **known})


def _number(cell: float | str) -> float | str:
    try:
        return float(cell)
    except ValueError:
        return cell

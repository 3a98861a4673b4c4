"""Error bars of a convergence study carried into the result folder of a run."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

from softact.converge.output import summary
from softact.converge.richardson import NOTHING, SAFETY
from softact.converge.study import WITHIN, Convergence
from softact.errors import DamagedResultError, SpecError
from softact.files.text import csv_text, json_text, write_atomic
from softact.report import write_report
from softact.results.folder import COMPLETE, MESH_ERROR, SUMMARY, checksums, read, read_cells
from softact.results.run_json import RUN, run_text
from softact.sweep import record
from softact.verdict import judge as verdict

#: Two runs of one spec are the same run within this part of the value, or of its error bar.
SAME, SAME_BAR = 1e-3, 0.1
_COLUMN = "_mesh_error"


def check_folder(directory: Path, hashes: Collection[object]) -> None:
    """Raise SpecError unless a result folder is sound, complete and of a spec with one of
    ``hashes``."""
    results = read(directory)
    faults = [*results.faults, *results.spec_faults]
    if faults:
        raise DamagedResultError(*faults)
    if results.status != COMPLETE or not results.summary:
        raise SpecError(f"{directory}: the run there is not complete; run it first")
    if results.run.get("spec_hash") not in hashes:
        raise SpecError(f"{directory}: computed from another spec than the meshes of this study")


def carry_into(study: Convergence, directory: Path) -> str:
    """Write the error bars of the mesh that a result folder was computed on into that folder, and
    whether that mesh is fine enough.

    summary.csv gets a column ``<measure>_mesh_error`` for each measure whose error is known,
    mesh_error.json the whole story, run.json the verdict with them, and the report is built anew.
    Returns a line that says so. Raises SpecError where the folder is not complete, of another spec,
    or has other values than the study's run.
    """
    hashes = [level.spec.hash for level in study.levels]
    check_folder(directory, hashes)
    results = read(directory)
    level = hashes.index(results.run["spec_hash"])
    errors = {m: study.estimate(m).errors[level] for m in study.measures}
    bars = {measure: bar for measure, bar in errors.items() if bar is not None}
    for measure in study.measures:
        there, here = float(results.curve[measure][-1]), study.values(measure)[level]
        near = max(SAME * abs(here), SAME_BAR * bars.get(measure, 0.0), NOTHING)
        if abs(there - here) > near:
            raise SpecError(
                f"{directory}: {measure} is {there:.6g} there and {here:.6g} in this study, on the "
                "same mesh; the folder is of another softact: run it again"
            )
    story = {"error_bars": bars, "level": level, "safety": SAFETY, **_story(study, level)}
    heads, rows = read_cells(directory / SUMMARY)
    cells = zip(heads, rows[0], strict=True)
    row: dict[str, Any] = {name: cell for name, cell in cells if not name.endswith(_COLUMN)}
    row |= {f"{measure}{_COLUMN}": bar for measure, bar in bars.items()}
    write_atomic(directory / MESH_ERROR, json_text(story))
    write_atomic(directory / SUMMARY, csv_text([row]))
    write_atomic(directory / RUN, run_text(results.run | {"files": checksums(directory)}))
    verdict.store(directory)
    record.refresh(directory)  # where it is a sweep's kept run, it shall stay one
    what = "error bars" if bars else "what is known of the mesh"
    return f"{what}: {directory / 'summary.csv'} and {write_report(directory)}"


def _story(study: Convergence, level: int) -> dict[str, Any]:
    """The study, with the verdict on one of its meshes instead of that on the finest."""
    story = summary(study)
    for measure, entry in story["measures"].items():
        entry["verdict"] = study.verdict_of(measure, level)
    return story | {"verdict": study.verdict(level), "converged": study.verdict(level) == WITHIN}

"""The run in a result folder that is to go on: what it was, and whether it is the same one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from softact.errors import DamagedResultError, SpecError
from softact.files.restart import RESTART, of_another_version, unseal
from softact.files.text import digest
from softact.geometry.imported import Imported, mesh_digest
from softact.results.folder import COMPLETE, INCOMPLETE, read_run
from softact.spec.timing import with_contents
from softact.verdict.judge import Verdict, from_data

if TYPE_CHECKING:
    from softact.spec import Spec

# What a resumed run may have changed: texts, and what comes after its last increment.
_FREE = {"name", "description", "source", "assumptions", "steps"}


@dataclass(frozen=True)
class Interrupted:
    """A run that can be resumed. status: "complete", "no_equilibrium" or "incomplete"; steps: of
    its spec, as plain data; verdict: on it, as far as it has one."""

    status: str
    steps: list[dict]
    verdict: Verdict | None

    def finished_as(self, spec: Spec) -> bool:
        """Whether nothing is left to solve."""
        return self.status == COMPLETE and self.steps == identity(spec)["steps"]


def identity(spec: Spec) -> dict:
    """What a run is the run of: its spec as plain data, and what is in the file that it names."""
    data = spec.model_dump(mode="json", exclude_none=True)
    if hasattr(spec.geometry, "content"):
        data["geometry"]["file"] = spec.geometry.content()
    data["steps"] = with_contents(data["steps"])
    if spec.target_line is not None:
        data["target_line"]["file"] = digest(Path(spec.target_line.file))
    for obstacle in data["obstacles"].values():
        if "file" in obstacle:
            obstacle["file"] = digest(Path(obstacle["file"]))
    if not data["tolerances"]:
        del data["tolerances"]  # as before there were any
    return data


def to_resume(spec: Spec, directory: Path) -> Interrupted | None:
    """The run in a folder; None where there is nothing to go on from.

    Raises SpecError where it is the run of another spec, DamagedResultError where the file from
    which it would go on cannot be used.
    """
    path = directory / RESTART
    if not path.is_file():
        return None
    known, _ = unseal(path)
    if "spec" not in known:
        raise of_another_version(path)
    old, new = known["spec"], identity(spec)
    differing = [key for key in (old | new) if old.get(key) != new.get(key) and key not in _FREE]
    if differing:
        raise SpecError(
            f"{directory}: holds the run of another spec ({', '.join(differing)} differ); a run is "
            "resumed with its own spec, in which only later steps may change"
        )
    try:
        run = read_run(directory)
    except (DamagedResultError, FileNotFoundError):
        run = {"status": INCOMPLETE}  # it is written anew
    _check_mesh(spec, run, directory)
    return Interrupted(run["status"], old["steps"], from_data(run.get("verdict")))


def _check_mesh(spec: Spec, run: Mapping, directory: Path) -> None:
    """Raise SpecError where a script makes another mesh than that of the run: it may read anything,
    and what it has read has changed."""
    geometry = spec.geometry
    if not isinstance(geometry, Imported) or geometry.self_contained:
        return
    known = run.get("mesh_hash")
    if known and mesh_digest(geometry, spec.solver.curved) != known:
        raise SpecError(
            f"{directory}: holds the run of another mesh: what {Path(geometry.file).name} reads "
            "has changed; start the run anew, without --resume"
        )

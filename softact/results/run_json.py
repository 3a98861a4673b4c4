"""run.json: what it may hold, and how it is read."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

from softact.errors import DamagedResultError
from softact.files.text import json_text

RUN = "run.json"
CHECKSUM = "checksum"

INCOMPLETE = "incomplete"
COMPLETE = "complete"
NO_EQUILIBRIUM = "no_equilibrium"
STATUSES = (COMPLETE, NO_EQUILIBRIUM, INCOMPLETE)

SOLVE_AGAIN = "solve the spec again"
_REMEDY = "'softact run SPEC -o DIR --resume' writes it anew"


class _Part(BaseModel):
    model_config = ConfigDict(extra="allow", strict=True)


class _Mesh(_Part):
    cells: int | None = None
    unknowns: int | None = None


class _Attempt(_Part):
    step: str | None = None
    fraction: float | None = None
    iterations: int | None = None
    converged: bool | None = None
    residuals: list[float | None] | None = None
    reason: str | None = None
    unstable_modes: int | None = None
    control: str | None = None
    kinetic_ratio: float | None = None
    speed: float | None = None


class _Run(_Part):
    """The keys that a reader looks at; NaN is null. Others are told as they are."""

    status: str
    spec_hash: str | None = None
    processes: int | None = None
    softact: str | None = None
    commit: str | None = None
    versions: dict[str, str | None] | None = None
    mesh: _Mesh | None = None
    times_s: dict[str, float | None] | None = None
    counts: dict[str, float | None] | None = None
    messages: list[str] | None = None
    notes: list[str] | None = None
    verdict: dict[str, Any] | None = None
    history: list[_Attempt] | None = None
    files: dict[str, str] | None = None


def read_run(directory: Path) -> dict:
    """run.json of a result folder as plain data. Raises DamagedResultError, and FileNotFoundError
    where there is none."""
    path = Path(directory) / RUN
    try:
        run = json.loads(path.read_text(encoding="utf-8"))
        _Run.model_validate(run)
        run.pop(CHECKSUM, None)
    except FileNotFoundError:
        raise
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "all of it"
        raise damaged(path, f"{where}: {first['msg']}", _REMEDY) from None
    except (OSError, ValueError, RecursionError) as error:
        raise damaged(path, error, _REMEDY) from None
    if run["status"] not in STATUSES:
        why = f"status: {run['status']!r} is none of {', '.join(STATUSES)}"
        raise damaged(path, why, _REMEDY)
    return run


def run_faults(directory: Path) -> list[str]:
    """What is wrong with a run.json that can be read. Raises OSError."""
    path = Path(directory) / RUN
    run = json.loads(path.read_text(encoding="utf-8"))
    checksum = run.pop(CHECKSUM, None)
    if checksum in (None, _checksum(run)):
        return []
    return [f"{path}: is not as it was written; {SOLVE_AGAIN}"]


def run_text(run: Mapping) -> str:
    """Text of run.json, with its checksum."""
    plain = json.loads(json_text(run))
    return json_text(plain | {CHECKSUM: _checksum(plain)})


def _checksum(run: Mapping) -> str:
    return hashlib.sha256(json_text(run).encode()).hexdigest()[:16]


def damaged(path: Path, why: object, remedy: str = SOLVE_AGAIN) -> DamagedResultError:
    """What to say of a file of a result folder that is not as softact writes it."""
    text = " ".join(str(why).split())
    return DamagedResultError(f"{path}: is damaged ({text[:200]}); {remedy}")

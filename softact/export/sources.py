"""The runs that a user means: result folders, or those of a sweep."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from softact.errors import SpecError
from softact.results.folder import COMPLETE, NO_EQUILIBRIUM, Results, read, read_cells
from softact.results.run_json import RUN
from softact.spec.kinds import expect_results
from softact.sweep.cache import DEFAULT, folder_of
from softact.sweep.table import TABLE


def runs(folders: Sequence[str | Path], cache: Path | None = None) -> list[Results]:
    """Read the runs. cache: where those of sweeps are kept. Raises SpecError, a line per folder
    that is neither, that is damaged or holds the same run as another."""
    found: dict[Path, Results] = {}
    faults: list[str] = []
    for folder in map(Path, folders):
        try:
            expect_results(folder)
            for each in _folders(folder, cache or DEFAULT):
                if each.resolve() in found:
                    raise SpecError(f"{each}: is named twice")
                run = read(each)
                # What a simulator shall rely on is not made of what is not as the run wrote it.
                faults += [*run.faults, *run.spec_faults]
                found[each.resolve()] = run
        except SpecError as error:
            faults += error.lines
    if faults:
        raise SpecError(*dict.fromkeys(faults))
    return list(found.values())


def _folders(folder: Path, cache: Path) -> Iterator[Path]:
    table = folder / TABLE
    if not table.is_file() or (folder / RUN).is_file():
        yield folder
        return
    heads, rows = read_cells(table)
    missing = [name for name in ("run", "status") if name not in heads]
    if missing:
        raise SpecError(f"{table}: has no column {missing[0]}, so it is not of a sweep of softact")
    run, status = heads.index("run"), heads.index("status")
    # Other points have no results: their runs failed, or their specs cannot be built.
    keys = [row[run] for row in rows if row[status] in (COMPLETE, NO_EQUILIBRIUM)]
    if not keys:
        raise SpecError(f"{folder}: none of the {len(rows)} runs of this sweep has results")
    gone = [key for key in keys if not (folder_of(cache, key) / RUN).is_file()]
    if gone:
        raise SpecError(
            f"{folder}: {len(gone)} of its {len(keys)} runs are not in {cache}; name the folder "
            "with --cache, or repeat the sweep"
        )
    yield from (folder_of(cache, key) for key in dict.fromkeys(keys))

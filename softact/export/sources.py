"""The runs that a user means: result folders, or those of a sweep."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from softact.errors import SpecError
from softact.files.text import csv_rows
from softact.results.folder import Results, read
from softact.sweep.cache import DEFAULT, folder_of


def runs(folders: Sequence[str | Path], cache: Path | None = None) -> list[Results]:
    """Read the runs. Raises SpecError, a line per folder that is neither."""
    found, faults = [], []
    for folder in map(Path, folders):
        try:
            found += [read(each) for each in _folders(folder, cache or DEFAULT)]
        except SpecError as error:
            faults += error.lines
    if faults:
        raise SpecError(*faults)
    return found


def _folders(folder: Path, cache: Path) -> Iterator[Path]:
    table = folder / "sweep.csv"
    if not table.is_file() or (folder / "run.json").is_file():
        yield folder
        return
    heads, *rows = csv_rows(table)
    if "run" not in heads:
        raise SpecError(f"{table}: has no column run, so it is not of a sweep of softact")
    keys = [row[heads.index("run")] for row in rows]
    missing = [key for key in keys if key and not (folder_of(cache, key) / "run.json").is_file()]
    if missing or not any(keys):
        raise SpecError(
            f"{folder}: {len(missing) or 'all'} of its {len(keys)} runs are not in {cache}; name "
            "the folder with --cache, or repeat the sweep"
        )
    yield from (folder_of(cache, key) for key in keys if key)

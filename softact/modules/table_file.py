"""A module's table as a file: JSON for any reader, HDF5 for large tools; both hold the same."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from softact.errors import SpecError
from softact.files.text import json_text, replacing, write_atomic
from softact.modules.ends import Ends, short_spec
from softact.modules.module_spec import module_specs
from softact.modules.response import Response
from softact.modules.rod_run import dead
from softact.modules.table import Grid, Table, Walked, largest_pressures, table
from softact.spec import Spec

FORMAT = 1
JSON, HDF5 = "table.json", "table.h5"
FILES = (JSON, HDF5)
ENOUGH = 1 - 1e-9
SAMPLE = 1e-3  # MPa: the pressure of the specs whose hash tells tables apart
UNITS = {
    "response.low": "1/mm, 1, MPa",
    "response.high": "1/mm, 1, MPa",
    "response.constants": "mJ/mm",
    "errors": "of moment, force and air at states held out, a part of each largest",
    "pitch": "mm",
    "outline": "mm, along and across",
    "origin": "mm, along and across",
    "walked.states": "curvature 1/mm, stretch, pressure MPa",
    "walked.conjugates": "moment N mm, force N, air by length mm^2",
    "walked.levels": "MPa",
    "walked.free": "1/mm",
    "ends.stiff": "modules",
    "ends.pressures": "MPa",
    "ends.idle": "modules",
    "ends.air": "mm^3",
    "walked.free_air": "mm^2",
    "moment": "N mm",
}
COMPLEX = ("outline", "origin")


def key(specs: Iterable[Spec], grid: Grid) -> str:
    """What a table was made from, as a short text, but for how high the pressure goes."""
    text = json.dumps([FORMAT, asdict(grid), [spec.hash for spec in specs]], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _plain(inner) for name, inner in value.items()}
    if isinstance(value, complex):
        return [value.real, value.imag]
    if isinstance(value, np.ndarray):
        pairs = np.stack([value.real, value.imag], axis=-1) if np.iscomplexobj(value) else value
        return pairs.tolist()
    return value


def _leaves(data: dict[str, Any], before: str = "") -> list[tuple[str, Any]]:
    found = []
    for name, value in data.items():
        if isinstance(value, dict):
            found += _leaves(value, f"{before}{name}.")
        else:
            found.append((before + name, value))
    return found


@dataclass(frozen=True)
class MadeTable:
    """A table and what it was made from."""

    table: Table
    made_from: str

    def serves(self, made_from: str, pressure: float, moment: float) -> bool:
        """Whether it is of the same module, up to a pressure (MPa) and with room for a moment of
        dead loads (N mm)."""
        reaches = self.table.walked.levels[-1], self.table.moment
        enough = all(r >= w * ENOUGH for r, w in zip(reaches, (pressure, moment), strict=True))
        return self.made_from == made_from and enough

    def write(self, json_file: Path, hdf5_file: Path) -> None:
        """Write both files."""
        data = _plain(asdict(self.table))
        heads = {"format": FORMAT, "made_from": self.made_from}
        write_atomic(json_file, json_text({**heads, "units": UNITS, **data}))
        # Imported here: reading a table shall not wait for it.
        import h5py

        with replacing(hdf5_file) as partial, h5py.File(partial, "w") as file:
            file.attrs.update(heads)
            for name, value in _leaves(data):
                place = name.replace(".", "/")
                file[place] = value
                if name in UNITS:
                    file[place].attrs["unit"] = UNITS[name]


def read(path: Path) -> MadeTable:
    """A table from its JSON file. Raises SpecError."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        if data.pop("format") != FORMAT:
            raise SpecError(f"{path}: is a table of another softact; make it anew")
        made_from, _ = data.pop("made_from"), data.pop("units")
        for name in COMPLEX:
            data[name] = np.asarray(data[name]) @ [1, 1j]
        response = {name: np.asarray(value) for name, value in data.pop("response").items()}
        walked = data.pop("walked")
        for name in ("states", "conjugates", "levels", "free", "free_air"):
            walked[name] = np.asarray(walked[name])
        data["errors"] = np.asarray(data["errors"])
        ends = data.pop("ends")
        arrays = {name: np.asarray(ends[name]) for name in ("pressures", "idle", "air")}
        data["ends"] = Ends(ends["stiff"], **arrays)
        found = Table(response=Response(**response), walked=Walked(**walked), **data)
        return MadeTable(found, made_from)
    except OSError as error:
        raise SpecError(f"{path}: cannot be read: {error.strerror}") from None
    except (ValueError, KeyError, TypeError, AttributeError):
        raise SpecError(f"{path}: is no table of 'softact module --table'") from None


def made_or_read(
    spec: Spec, known: Path, given: bool, tell: Callable[[str], None], grid: Grid | None = None
) -> MadeTable:
    """The table of an actuator's module: of the file ``known`` where that is of the same module,
    else a new one.

    given: the user named the file: another module's is then refused. Raises SpecError.
    """
    grid = grid or Grid()
    pressures, loads = largest_pressures(spec), dead(spec)
    full = max(pressures.values())
    shares = {name: value / full for name, value in pressures.items()}
    made_from = key(_specs(spec, {name: SAMPLE * part for name, part in shares.items()}), grid)
    found = _known(known, given)
    if found and found.serves(made_from, full, loads.moment):
        tell(f"table: that of {known}")
        return found
    if given:
        raise SpecError(
            f"{known}: is the table of another module, or of less than {1e3 * full:g} kPa or "
            f"{loads.moment:.3g} N mm of weight and payload; geometry, materials, layers and "
            "solver are to be the same"
        )
    free, *short = _specs(spec, pressures)
    return MadeTable(table(free, grid, loads, tell, *short), made_from)


def _known(path: Path, given: bool) -> MadeTable | None:
    """The table of a file; None where it is not given and there is none, or none to be read."""
    try:
        return read(path)
    except SpecError:
        if given:
            raise
        return None


def _specs(spec: Spec, pressures: Mapping[str, float]) -> list[Spec]:
    """Of the module, and of a short actuator where there is one, under pressures, MPa."""
    driven = {name: f"{value!r} MPa" for name, value in pressures.items()}
    steps = [{"name": "walk", "pressure": driven}]
    bare = spec.with_({"steps": steps, "obstacles": {}})
    short = short_spec(bare)
    return [module_specs(bare, {}).runs["free"], *([short] if short else [])]

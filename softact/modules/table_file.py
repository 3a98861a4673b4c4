"""A module's table as a file: JSON for any reader, HDF5 for large tools; both hold the same."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softact.errors import SpecError
from softact.files.text import json_text, replacing, write_atomic
from softact.modules.dead import Dead
from softact.modules.driven import Driven, driven
from softact.modules.ends import Ends, short_spec
from softact.modules.energy import Energy, Samples
from softact.modules.lumps import Lumps, lumps
from softact.modules.module_spec import module_specs
from softact.modules.table import Table, table
from softact.modules.walk import Grid, Walked
from softact.spec import Spec

Array = NDArray[np.float64]
FORMAT = 4
JSON, HDF5 = "table.json", "table.h5"
FILES = (JSON, HDF5)
ENOUGH = 1e-9  # of the range of pressures
SAMPLE = 1e-3  # MPa: the pressure of the specs whose hash tells tables apart
UNITS = {
    "energy.low": "1/mm, N, MPa",
    "energy.high": "1/mm, N, MPa",
    "energy.constants": "mJ/mm",
    "errors": "of moments, forces and air at states held out, a part of each largest",
    "pitch": "mm",
    "origin": "mm",
    "walked.samples.places": "curvatures 1/mm, forces N, pressures MPa",
    "walked.samples.first": "moments N mm, minus the change of stretch, minus air by length mm^2",
    "walked.samples.second": "their derivatives by curvatures, forces and pressures",
    "walked.centres": "curvatures, stretches and pressures where nothing holds the module",
    "room": "N mm",
    "lumps.masses": "tonne",
    "lumps.centres": "mm",
    "lumps.spreads": "tonne mm^2",
    "lumps.tip": "mm",
    "lumps.outline": "mm",
    "lumps.tip_outline": "mm",
    "ends.stiff": "modules",
    "ends.pressures": "MPa",
    "ends.idle": "modules",
    "ends.air": "mm^3",
}


def key(specs: Iterable[Spec], grid: Grid) -> str:
    """What a table was made from, as a short text, but for how high the pressure goes."""
    text = json.dumps([FORMAT, asdict(grid), [spec.hash for spec in specs]], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _plain(inner) for name, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


def _arrays(data: dict[str, Any], *but: str) -> dict[str, Any]:
    """Lists of numbers as arrays."""
    return {name: v if name in but else np.asarray(v) for name, v in data.items()}


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

    def serves(self, made_from: str, loads: Driven, dead: Dead) -> bool:
        """Whether it is of the same module, for all pressures of loads and with room for all dead
        loads on the way."""
        known = self.table
        if self.made_from != made_from:
            return False
        room = dead.room(known.walked.centres[:, known.k :])
        along = known.energy.names.index(f"force_{'xyz'[known.axis]}")
        pull = min(-known.energy.low[along], known.energy.high[along])
        if np.any(room * (1 - ENOUGH) > known.room) or dead.pull * (1 - ENOUGH) > pull:
            return False
        slack = ENOUGH * (known.high - known.low)
        return bool(
            np.all(loads.low >= known.low - slack) & np.all(loads.high <= known.high + slack)
        )

    def write(self, json_file: Path, hdf5_file: Path) -> None:
        """Write both files."""
        data = _plain(asdict(self.table))
        heads = {"format": FORMAT, "made_from": self.made_from}
        write_atomic(json_file, json_text({**heads, "units": UNITS, **data}))
        # Imported here: reading a table shall not wait for it.
        import h5py

        data["groups"] = json.dumps(data["groups"])
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
        energy = _arrays(data.pop("energy"), "names")
        energy["names"] = tuple(energy["names"])
        walked = data.pop("walked")
        walked["samples"] = Samples(**_arrays(walked["samples"]))
        walked["centres"] = np.asarray(walked["centres"])
        data["ends"] = Ends(**_arrays(data["ends"], "stiff"))
        data["lumps"] = Lumps(**_arrays(data["lumps"]))
        data["groups"] = tuple(data["groups"])
        data |= {name: np.asarray(data[name]) for name in ("free", "errors", "origin", "room")}
        found = Table(energy=Energy(**energy), walked=Walked(**walked), **data)
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
    loads = driven(spec)
    dead = Dead.of(spec, loads)
    made_from = key([spec_without_loads(spec), *_specs(spec, loads, SAMPLE)], grid)
    found = _known(known, given)
    if found and found.serves(made_from, loads, dead):
        tell(f"table: that of {known}")
        return found
    if given:
        most = max(np.abs(loads.low).max(), loads.high.max())
        raise SpecError(
            f"{known}: is the table of another module, or of less than {1e3 * most:g} kPa or "
            f"{dead.moments.max():.3g} N mm of weight and payload; geometry, materials, layers and "
            "solver are to be the same"
        )
    free, *short = _specs(spec, loads, 1.0)
    made = table(free, loads, grid, dead, lumps(spec), tell, *short)
    return MadeTable(made, made_from)


def _known(path: Path, given: bool) -> MadeTable | None:
    """The table of a file; None where it is not given and there is none, or none to be read."""
    try:
        return read(path)
    except SpecError:
        if given:
            raise
        return None


def spec_without_loads(spec: Spec) -> Spec:
    """The actuator alone."""
    step = {"name": "walk", "gravity": [0, 0, -1]}
    return spec.with_({"steps": [step], "obstacles": {}, "name": "table", "description": ""})


def _specs(spec: Spec, loads: Driven, scale: float) -> list[Spec]:
    """Of the module, and of a short actuator where there is one, under the shares of the groups
    times a pressure, MPa."""
    names = spec.geometry.in_segments()[0]
    driving = {
        names[name]: f"{scale * share!r} MPa"
        for group in loads.groups
        for name, share in group.items()
    }
    bare = spec.with_({"steps": [{"name": "walk", "pressure": driving}], "obstacles": {}})
    short = short_spec(bare)
    return [module_specs(bare, {}).runs["free"], *([short] if short else [])]

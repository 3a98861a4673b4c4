"""A geometry that a script or a mesh of the user's makes, with named physical groups.

Run by itself it writes a mesh: ``python geometries/from_script.py --file my.py -o my.msh``.
"""

import contextlib
import importlib.util
import sys
import traceback
from collections.abc import Iterator
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import ClassVar, Literal

import numpy as np

from softact.child_processes import importable
from softact.errors import MeshError
from softact.geometry.base import main
from softact.geometry.gmsh_files import guarded, merge_mesh
from softact.geometry.imported import Imported
from softact.geometry.part_size import Drawn
from softact.geometry.scripts import DATA
from softact.geometry.step_names import UNITS


class FromScript(Imported):
    """A Python file with a function ``build(gmsh)`` or a .geo file, which are run as code, or a
    finished .msh, which is read as data.

    What it makes has physical groups with the names that the spec gives: volumes for ``regions``,
    surfaces for everything else. ``build`` gets the gmsh module with an empty model in mm and adds
    entities and groups; it neither initialises nor finalises gmsh. It may mesh; where it does
    not, ``mesh_size`` counts. It runs in the folder of its file, and may import what lies there.
    """

    type: Literal["from_script"] = "from_script"
    suffixes: ClassVar[tuple[str, ...]] = (".py", ".geo", *DATA)

    @property
    def code(self) -> Path | None:
        """See ``Geometry.code``."""
        path = Path(self.file)
        return None if path.suffix.lower() in DATA else path

    def faults(self) -> Iterator[tuple[str, str]]:
        """See ``Geometry.faults``."""
        yield from super().faults()
        if self.unit and self.code:
            yield "unit", "a script makes its model in mm; leave unit: out, which is for meshes"

    def drawn(self, gmsh: ModuleType) -> Drawn:
        """See ``Imported.drawn``."""
        if self.code:
            return super().drawn(gmsh)
        points = gmsh.model.mesh.getNodes()[1].reshape(-1, 3)
        return Drawn(self.scale * np.ptp(points, axis=0), unit=self.unit or "mm")

    @property
    def scale(self) -> float:
        """See ``Imported.scale``."""
        return UNITS[self.unit or "mm"]

    @property
    def self_contained(self) -> bool:
        """Only a mesh is; a script may read anything."""
        return self.code is None

    def build(self, gmsh: ModuleType) -> None:
        """See ``Geometry.build``."""
        path = Path(self.file).absolute()
        if self.code is None:
            merge_mesh(gmsh, path)
        elif path.suffix.lower() == ".geo":
            gmsh.merge(str(path))
        else:
            with _beside(path), guarded(gmsh):
                _run(path, gmsh)


def _run(path: Path, gmsh: ModuleType) -> None:
    loader = SourceFileLoader("user_geometry", str(path))  # whatever the case of its suffix
    spec = importlib.util.spec_from_file_location("user_geometry", path, loader=loader)
    assert spec is not None  # there is a loader
    module = importlib.util.module_from_spec(spec)
    try:
        loader.exec_module(module)
        if not callable(getattr(module, "build", None)):
            raise MeshError(f"{path.name} has no function build(gmsh)")
        module.build(gmsh)
        gmsh.model.occ.synchronize()
    except MeshError:
        raise
    except (Exception, SystemExit) as error:
        what = f"{type(error).__name__}: {' '.join(str(error).split())}"
        raise MeshError(f"{path.name}{_line(error, path)}: {what}") from error


def _line(error: BaseException, path: Path) -> str:
    """The last line of the file on the way to an error."""
    if isinstance(error, SyntaxError) and error.filename == str(path):
        return f":{error.lineno}"
    frames = traceback.extract_tb(error.__traceback__)
    return next((f":{f.lineno}" for f in reversed(frames) if f.filename == str(path)), "")


@contextlib.contextmanager
def _beside(path: Path) -> Iterator[None]:
    """Relative files and modules count from the script's folder, as in ``python my.py`` there.

    Nothing compiled is kept: it would be taken for a file that was changed within a second.
    """
    kept, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    try:
        with importable(path.parent), contextlib.chdir(path.parent):
            yield
    finally:
        sys.dont_write_bytecode = kept


if __name__ == "__main__":
    main(FromScript)

"""A geometry that a script or a mesh of the user's makes, with named physical groups.

Run by itself it writes a mesh: ``python geometries/from_script.py --file my.py -o my.msh``.
"""

import importlib.util
import sys
from pathlib import Path
from typing import ClassVar, Literal

from softact.errors import MeshError
from softact.geometry import main
from softact.imported import Imported
from softact.orphans import importable


class FromScript(Imported):
    """A Python file with a function ``build(gmsh)``, a .geo file, or a finished .msh.

    What it makes has physical groups with the names that the spec gives: volumes for ``regions``,
    surfaces for everything else. ``build`` gets the gmsh module with an empty model in mm and adds
    entities and groups; it neither initialises nor finalises gmsh. It may mesh; where it does
    not, ``mesh_size`` counts.
    """

    type: Literal["from_script"] = "from_script"
    suffixes: ClassVar[tuple[str, ...]] = (".py", ".geo", ".msh")

    @property
    def self_contained(self) -> bool:
        """Only a mesh is; a script may read anything."""
        return Path(self.file).suffix.lower() == ".msh"

    def build(self, gmsh) -> None:
        path = Path(self.file)
        if path.suffix.lower() != ".py":
            gmsh.merge(str(path))
            return
        # Python takes the compiled form of a module that was edited within the same second for
        # the new one; nor is the script's folder the place for files of ours.
        sys.dont_write_bytecode = True
        spec = importlib.util.spec_from_file_location("user_geometry", path)
        module = importlib.util.module_from_spec(spec)
        with importable(path.absolute().parent):
            spec.loader.exec_module(module)
            if not callable(getattr(module, "build", None)):
                raise MeshError(f"{path.name} has no function build(gmsh)")
            module.build(gmsh)
        gmsh.model.occ.synchronize()


if __name__ == "__main__":
    main(FromScript)

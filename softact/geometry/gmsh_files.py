"""Files that are data, given to gmsh such that nothing in or beside them runs as code.

gmsh takes a file for a script of its own where neither its suffix nor its first line say otherwise,
and such a script may run any command (``SystemCall``). It also runs ``part.msh.opt`` beside
``part.msh`` without a word. So a mesh is read after a look at its header, and from a folder in
which nothing else is.
"""

import functools
import os
import re
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import BinaryIO

from softact.errors import MeshError
from softact.units import show

MESH_HEADERS = (b"$MeshFormat", b"$Comments")
# What gmsh takes for what its suffix says, whatever it holds.
BY_SUFFIX = (".step", ".stp", ".brep", ".iges", ".igs", ".stl", ".unv", ".vtk", ".mesh", ".bdf")
CODE = (".geo", ".geo_unrolled", ".opt", ".pos", ".script")
GROUP = re.compile(rb'\s*\d+\s+\d+\s+"[^"\r\n]*"\s*')


def merge_mesh(gmsh: ModuleType, path: Path) -> None:
    """Merge a mesh in gmsh's own format. Raises MeshError where the file is something else."""
    check_mesh(path)
    _read_alone(gmsh.merge, path, ".msh")


def check_mesh(path: Path) -> None:
    """Raise MeshError where a file is no mesh of gmsh's, or has names that cannot be read."""
    with open(path, "rb") as file:
        if not file.read(16).startswith(MESH_HEADERS):
            raise MeshError(
                f"{path.name} is no mesh: it does not begin with $MeshFormat; what gmsh would run "
                "as a script has to be named .geo"
            )
        file.seek(0)
        for number, name in _group_lines(file):
            if not GROUP.fullmatch(name):
                raise MeshError(
                    f"{path.name}:{number}: {show(name.decode(errors='replace').strip())} is no "
                    'line such as 2 1 "clamp": dimension, number and name of a group; a name has '
                    "neither quotes nor line breaks"
                )


def _group_lines(file: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """The lines of $PhysicalNames, numbered, without the count."""
    inside = False
    for number, line in enumerate(file, start=1):
        if line.startswith((b"$EndPhysicalNames", b"$Entities", b"$Nodes")):
            return
        if inside and not line.strip().isdigit():
            yield number, line
        inside = inside or line.startswith(b"$PhysicalNames")


@contextmanager
def guarded(gmsh: ModuleType) -> Iterator[None]:
    """Meanwhile, gmsh.merge and gmsh.open take data for data, too.

    Files of gmsh's own scripts (.geo and the like) run as they do in gmsh.
    """
    names = ("merge", "open")
    own = {name: getattr(gmsh, name) for name in names}
    try:
        for name in names:
            setattr(gmsh, name, functools.partial(_as_its_suffix_says, own[name]))
        yield
    finally:
        for name in names:
            setattr(gmsh, name, own[name])


def _as_its_suffix_says(read: Callable[[str], None], fileName: str) -> None:
    path = Path(fileName)
    suffix = path.suffix.lower()
    if suffix in CODE or not path.is_file():
        read(str(fileName))
    elif suffix in BY_SUFFIX:
        _read_alone(read, path, suffix)
    else:
        check_mesh(path)
        _read_alone(read, path, ".msh")


def _read_alone(read: Callable[[str], None], path: Path, suffix: str) -> None:
    with tempfile.TemporaryDirectory(prefix="softact-") as folder:
        link = Path(folder) / f"data{suffix}"
        os.symlink(path.absolute(), link)
        read(str(link))

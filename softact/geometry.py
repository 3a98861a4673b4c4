"""Geometries: what each must tell of itself, the registry, and meshing in a process of its own.

A geometry is one file in ``geometries/``: a frozen pydantic model whose fields are its parameters.
gmsh can hang or crash, so it never runs in the caller's process: ``make_mesh`` and ``export``
start ``softact.gmsh_process`` with a time limit and turn whatever goes wrong into one MeshError.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

from pydantic import BaseModel, ConfigDict

from softact.errors import MeshError

# A child started by a process that runs under mpirun would join its MPI job and hang.
MPI_PREFIXES = ("OMPI_", "PMIX_", "PMI_", "PRTE_", "HYDRA_", "MPI_")
FAULT = "softact-fault: "


@dataclass(frozen=True)
class Layout:
    """Named parts of a mesh and what they mean. Lengths in mm.

    regions: names of the volume groups.
    surfaces: names of all surface groups (outer, cavity walls, embedded).
    cavities: cavity name -> names of the surface groups that wall it. Together with the symmetry
        planes they close the cavity.
    clamp, tip: names of the surface groups at the two ends.
    axis: unit vector from clamp to tip in the undeformed state.
    bending_axis: unit vector about which a positive bending angle turns ``axis`` (right-hand
        rule), or None where the actuator can bend in any plane.
    symmetry: name of a surface group in a symmetry plane -> index (0, 1, 2) of the coordinate
        that is zero there. Each halves the model: the whole has ``copies`` parts.
    layers: names of surface groups meant for thin layers (outer or embedded).
    origin: a point on the axis at the clamp.
    length: distance from clamp to tip along the axis.
    """

    regions: tuple[str, ...]
    surfaces: tuple[str, ...]
    cavities: dict[str, tuple[str, ...]]
    clamp: str = "clamp"
    tip: str = "tip"
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    bending_axis: tuple[float, float, float] | None = None
    symmetry: dict[str, int] = field(default_factory=dict)
    layers: tuple[str, ...] = ()
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    length: float = 0.0

    @property
    def copies(self) -> int:
        """How many mirrored parts make the whole actuator."""
        return 2 ** len(self.symmetry)


class Geometry(BaseModel):
    """Parameters of one kind of actuator, and how gmsh builds it. Base of all geometries.

    Axes: x from the clamp to the tip, z up, y across. Lengths in mm. Subclasses have a field
    ``type: Literal["<name>"]`` and validators that refuse what cannot be built.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    def layout(self) -> Layout:
        """Names of the parts of the mesh and what they mean."""
        raise NotImplementedError

    def volumes(self) -> dict[str, float]:
        """Closed-form measures of the meshed part (half of the whole under one symmetry plane).

        Keys are names out of the layout: regions and cavities (mm^3), surfaces (mm^2).
        """
        raise NotImplementedError

    def volume_tolerance(self) -> float:
        """Relative difference to ``volumes`` that flat facets may have; rounding for flat walls."""
        return 1e-9

    def build(self, gmsh) -> None:
        """Adds OCC entities, physical groups and mesh sizes to the current gmsh model."""
        raise NotImplementedError

    def mesh(self, gmsh) -> None:
        """Meshes what ``build`` made with first-order tetrahedra."""
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.optimize("")


def __getattr__(name: str):
    # The geometry files import this module, so the registry can only be looked up afterwards.
    if name == "GEOMETRIES":
        from softact.geometries import GEOMETRIES

        return GEOMETRIES
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def make_mesh(geometry: Geometry, path: Path, timeout: float = 300.0) -> None:
    """Writes the mesh of a geometry to ``path`` (.msh 4.1, mm), meshed in a process of its own.

    timeout: seconds after which gmsh is killed. The file appears whole or not at all, and the
    same parameters give the same mesh. Raises MeshError where gmsh fails, crashes or runs out of
    time, or where the mesh does not have the parts and volumes that the geometry promises.
    """
    export(geometry, Path(path), timeout, suffix=".msh")


def export(geometry: Geometry, path: Path, timeout: float = 300.0, suffix: str = "") -> None:
    """Writes a geometry to ``path`` in the format of its suffix: .msh, .vtu, .stl or .step."""
    path = Path(path)
    handle, temporary = tempfile.mkstemp(
        suffix=suffix or path.suffix, prefix=f".{path.name}.", dir=path.parent
    )
    os.close(handle)
    try:
        _run_gmsh(geometry, temporary, timeout)
        os.replace(temporary, path)
    finally:
        Path(temporary).unlink(missing_ok=True)


def _run_gmsh(geometry: Geometry, path: str, timeout: float) -> None:
    kind = type(geometry)
    job = {
        "module": kind.__module__,
        "file": getattr(sys.modules[kind.__module__], "__file__", None),
        "class": kind.__qualname__,
        "parameters": {name: getattr(geometry, name) for name in kind.model_fields},
        "path": path,
    }
    environment = {k: v for k, v in os.environ.items() if not k.startswith(MPI_PREFIXES)}
    environment["OMP_NUM_THREADS"] = "1"
    process = subprocess.Popen(
        [sys.executable, "-m", "softact.gmsh_process"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=environment,
        start_new_session=True,
    )
    try:
        log, _ = process.communicate(json.dumps(job), timeout=timeout)
    except subprocess.TimeoutExpired:
        log = _kill(process)
        raise MeshError(
            f"{_name(geometry)}: gmsh did not finish within {timeout:g} s and was stopped; "
            f"a larger mesh_size makes a smaller mesh{_last_words(log)}"
        ) from None
    except BaseException:
        _kill(process)
        raise
    if process.returncode == 0:
        return
    faults = [line[len(FAULT) :] for line in log.splitlines() if line.startswith(FAULT)]
    if faults:
        raise MeshError(*(f"{_name(geometry)}: {fault}" for fault in faults))
    how = f"ended with exit code {process.returncode}"
    if process.returncode < 0:
        how = f"crashed ({signal.Signals(-process.returncode).name})"
    raise MeshError(f"{_name(geometry)}: gmsh {how}{_last_words(log)}")


def _kill(process: subprocess.Popen) -> str:
    # The whole session: gmsh could have started children of its own.
    os.killpg(process.pid, signal.SIGKILL)
    return process.communicate()[0] or ""


def _name(geometry: Geometry) -> str:
    return getattr(geometry, "type", type(geometry).__name__)


def _last_words(log: str) -> str:
    lines = [line.strip() for line in log.splitlines() if line.strip()]
    errors = [line for line in lines if line.startswith("Error")]
    last = (errors or lines)[-1:]
    return f"; gmsh's last words: {last[0][:300]}" if last else ""

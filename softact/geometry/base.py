"""Geometries: what each must tell of itself, the registry, and meshing in a process of its own.

A geometry is one file in ``geometries/``: a frozen pydantic model whose fields are its parameters.
gmsh can hang or crash, so it never runs in the caller's process: ``make_mesh`` and ``export``
start ``softact.geometry.gmsh_process`` with a time limit and turn whatever goes wrong into one
MeshError.
"""

import errno
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import InitErrorDetails, PydanticCustomError

from softact import forkserver
from softact.child_processes import bound, environment
from softact.errors import GmshKilledError, MeshError, SoftactError, SpecError
from softact.files.streams import UTF8
from softact.files.text import replacing
from softact.geometry.cutting_pattern import Pattern
from softact.geometry.saying import FAULT, NOTE
from softact.geometry.scripts import as_code
from softact.geometry.steps import steps
from softact.geometry.walls import Wall
from softact.mesh.cells import MOST_TETRAHEDRA
from softact.mesh.layout import Layout
from softact.units import LENGTH, dimension_of

# A child started by a process that runs under mpirun would join its MPI job and hang.
MPI_PREFIXES = ("OMPI_", "PMIX_", "PMI_", "PRTE_", "HYDRA_", "MPI_")
THINNEST, LONGEST = 1e-4, 1e5  # mm
SUFFIXES = (".msh", ".vtu", ".stl", ".step")
PATTERNS = (".dxf", ".svg")  # of sheets
CORE_SUFFIXES = (".stl", ".step")
ENDS = {".msh": b"$End", ".step": b"END-"}  # how the last line of a whole file begins
Part = Literal["solid", "core"]
Look = Literal["look", "faces"]  # at the file that a geometry is made of
MOST_THROUGH = 100
#: Parameters that say how many elements lie between two planes or lines at least, of solids and of
#: sheets.
STEPS = ("through_wall", "between_lines")
ThroughWall = Annotated[
    int | None,
    Field(
        ge=1,
        le=MOST_THROUGH,
        description="least number of elements through a wall, and between any two planes of the "
        "mesh; by default 1. Two or more tell how a wall bends",
    ),
]


def _unworldly(length: float, what: str) -> str:
    """What is wrong with a length of an actuator, mm; empty: nothing."""
    if length < THINNEST:
        return f"at {length:g} mm the {what} would vanish; write a length above 0 mm"
    if length > LONGEST:
        return f"{length:g} mm is longer than any actuator; write at most {LONGEST:g} mm"
    return ""


class Geometry(BaseModel):
    """Parameters of one kind of actuator, and how gmsh builds it. Base of all geometries.

    Axes: x from the clamp to the tip, z up, y across. Lengths in mm. Subclasses have a field
    ``type: Literal["<name>"]``, a field ``mesh_size``, and ``faults`` that refuse what cannot be
    built.
    """

    # A command needs few of all models: each is built when it is used first.
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, defer_build=True)

    #: Whether walls of its outside can meet as it deforms, so that there is contact of them unless
    #: a spec says otherwise.
    meets_itself: ClassVar[bool] = True

    if TYPE_CHECKING:  # Each has a default and a description of its own for them.
        type: str
        mesh_size: float

    def layout(self) -> Layout:
        """Names of the parts of the mesh and what they mean."""
        raise NotImplementedError

    def volumes(self) -> dict[str, float]:
        """Closed-form measures of the meshed part (half of the whole under one symmetry plane).

        Keys are names out of the layout: regions and cavities (mm^3), surfaces (mm^2).
        """
        raise NotImplementedError

    def faults(self) -> Iterator[tuple[str, str]]:
        """Field and reason of everything that cannot be built: say which wall would vanish.

        All lengths are at least THINNEST when this is called.
        """
        return iter(())

    def walls(self) -> tuple[Wall, ...] | None:
        """The walls that bend under pressure, with how many elements lie through each; None where
        that is not known before there is a mesh."""
        return None

    def wall_normal(self, region: str, points: np.ndarray) -> np.ndarray:
        """Normal (n, 3) or (3,) of the wall at undeformed points (n, 3) of a region.

        Fibres lie in the wall, at an angle to the layout's axis. By default the walls are flat and
        lie in planes of x and y.
        """
        return np.array([0.0, 0.0, 1.0])

    def volume_tolerance(self, name: str) -> float:
        """Relative error of ``volumes()[name]`` that flat facets on curved walls may make."""
        return 1e-9

    def pattern(self) -> Pattern | None:
        """What is cut out of flat sheets and where they are joined, of the whole actuator; None
        where nothing is."""
        return None

    @property
    def code(self) -> Path | None:
        """The file of the user's that is run as code to build it, None where there is none."""
        return None

    def notes(self) -> list[str]:
        """What a user should know before it is built, in lines."""
        return [as_code(self.code)] if self.code else []

    def look(self, gmsh: ModuleType) -> None:
        """Tells what is in the file that it is made of, without a mesh (see ``tell``)."""

    def draw(self, gmsh: ModuleType, path: Path) -> None:
        """Write the faces of the file that it is made of, for ``draw_faces``."""
        raise NotImplementedError

    def cells(self) -> int | None:
        """Number of tetrahedra, where it is known before there is a mesh."""
        return None

    def walls_between_planes(self, **thickness: float) -> tuple[Wall, ...]:
        """Walls between planes that every mesh has, by the names of their thickness."""
        return tuple(
            Wall(name, t, steps(t, self.mesh_size, self.least_steps))
            for name, t in thickness.items()
        )

    def walls_between_curves(self, **thickness: float) -> tuple[Wall, ...]:
        """Walls between curves of a section of triangles: where they are thinner than half of the
        mesh size there is one triangle through them, where they are thicker there may be two."""
        return tuple(
            Wall(name, t, steps(t, self.mesh_size / 2, self.least_steps))
            for name, t in thickness.items()
        )

    @property
    def least_steps(self) -> int:
        """Least number of elements between two planes or lines of the mesh: what the parameter
        STEPS says, where the geometry has it."""
        given = (getattr(self, name, None) for name in STEPS)
        return next((number for number in given if number), 1)

    #: Follows on "has no module that repeats", where ``module`` is not written.
    why_no_module: ClassVar[str] = ", or none yet"

    def module(self) -> Self:
        """One module of the chain of equal ones that the actuator is, between two faces that
        repeat (``Layout.repeats``) and away from its ends. Raises SpecError where it is none.
        """
        kind = type(self).model_fields["type"].default
        raise SpecError(
            f"geometry.type: {kind} has no module that repeats{self.why_no_module}; "
            "docs/modules.md says which have one"
        )

    @property
    def pitches(self) -> float:
        """Pitches of a module in the part of the actuator's length that its modules fill."""
        raise NotImplementedError

    def in_segments(self) -> tuple[Mapping[str, str], ...]:
        """For each of the equal parts in a row, from the clamp, that have cavities of their own:
        cavity of a module alone -> what the whole actuator calls it there."""
        return ({name: name for name in self.layout().cavities},)

    def build(self, gmsh: ModuleType) -> None:
        """Adds the solid as OCC entities to the current gmsh model, with named groups and mesh
        sizes unless ``mesh`` is written too."""
        raise NotImplementedError

    def entities(self, gmsh: ModuleType) -> None:
        """Adds the OCC entities that are meshed, with named groups; see ``mesh``."""
        self.build(gmsh)

    def export_sheets(self, path: Path, suffix: str) -> None:
        """Write the mesh of a geometry without a solid (.msh, .vtu, .stl)."""
        raise NotImplementedError

    def mesh(self, gmsh: ModuleType) -> None:
        """Makes the current gmsh model hold a mesh of first-order tetrahedra in named groups."""
        from softact.geometry.subdivide import cut_mesh, fill

        self.entities(gmsh)
        fill(gmsh, self.mesh_size, self.least_steps)
        cut_mesh(gmsh, self.least_steps)

    @field_validator("*")
    @classmethod
    def _lengths_of_this_world(cls, value: Any, info: ValidationInfo) -> Any:
        name = info.field_name or ""
        if value is None or dimension_of(cls.model_fields[name]) is not LENGTH:
            return value
        if value == 0.0 == cls.model_fields[name].default:
            return value  # there is none
        what = name.replace("_", " ")
        for length in value if isinstance(value, tuple) else (value,):
            if fault := _unworldly(length, what):
                raise PydanticCustomError("geometry", "{fault}", {"fault": fault})
        return value

    @model_validator(mode="after")
    def _refuse_what_cannot_be_built(self) -> Self:
        found = list(self.faults()) or list(self._too_many())
        if found:
            raise ValidationError.from_exception_data(
                type(self).__name__, [_line_error(self, *fault) for fault in found]
            )
        return self

    def _too_many(self) -> Iterator[tuple[str, str]]:
        volume = sum(self.volumes()[region] for region in self.layout().regions)
        sizes = {name: getattr(self, name, None) for name in ("mesh_size", "cavity_mesh_size")}
        for name, size in sizes.items():
            count = 6 * volume / size**3 if size else 0
            if count > MOST_TETRAHEDRA:
                yield (
                    name,
                    f"{size:g} mm would make about {count:.0e} tetrahedra, and "
                    f"{MOST_TETRAHEDRA:.0e} are the most; write a larger length",
                )
                return
        count = self.cells() or 0
        if count > MOST_TETRAHEDRA:
            yield (
                "through_wall" if self.least_steps > 1 else "mesh_size",
                f"the mesh would have {count:.2e} tetrahedra, and {MOST_TETRAHEDRA:.0e} are the "
                "most; write a larger mesh_size or a smaller through_wall",
            )


def is_of_mesh(path: str) -> bool:
    """Whether a dotted path of a spec says how fine the mesh is, and nothing of the actuator."""
    part, _, name = path.strip().partition(".")
    return part == "geometry" and (name.endswith("mesh_size") or name in STEPS)


def _line_error(geometry: Geometry, name: str, fault: str) -> InitErrorDetails:
    # The text goes in as context: braces in it are no template.
    error = PydanticCustomError("geometry", "{fault}", {"fault": fault})
    return InitErrorDetails(type=error, loc=(name,), input=getattr(geometry, name, None))


def look(geometry: Geometry, said: list[str], timeout: float = 60.0) -> None:
    """Append to ``said`` what is in the file that a geometry is made of; no script is run.

    Raises MeshError where the file does not give what the geometry promises; what was found until
    then has been said.
    """
    if not geometry.code and type(geometry).look is not Geometry.look:
        _run_gmsh(geometry, Path(), timeout, "look", said)


def draw_faces(geometry: Geometry, path: Path, timeout: float = 300.0) -> list[str]:
    """Write the faces of the file that a geometry is made of to ``path``, as its ``draw`` does, and
    return what is to be said of them. Raises MeshError where the file cannot be read."""
    said: list[str] = []
    _run_gmsh(geometry, path.absolute(), timeout, "faces", said)
    return said


def make_mesh(
    geometry: Geometry, path: Path, timeout: float = 300.0, curved: bool = False
) -> list[str]:
    """Writes the mesh of a geometry to ``path`` (.msh 4.1, mm), meshed in a process of its own.

    timeout: seconds after which gmsh is killed. curved: whether edges along curved walls are. The
    file appears whole or not at all, and the same parameters give the same mesh. Returns remarks on
    the mesh, such as which walls are too thin for it. Raises MeshError where gmsh fails, crashes or
    runs out of time, or where the mesh does not have the parts and volumes that the geometry
    promises; OSError where the folder cannot be written or the disk is full.
    """
    return _write(geometry, Path(path), timeout, ".msh", curved=curved)


def move_mesh(
    geometry: Geometry,
    pairs: Sequence[tuple[Geometry, Geometry, float]],
    path: Path,
    curved: bool,
    timeout: float = 300.0,
) -> None:
    """Writes how the mesh of a solid moves with parameters, see ``softact.geometry.motion.Moved``.

    pairs: the geometry with a smaller and with a larger parameter, and the difference of the two.
    curved: whether edges may be. Raises MeshError as ``make_mesh`` does.
    """
    dumped = [(low.model_dump(), high.model_dump(), width) for low, high, width in pairs]
    _run_gmsh(geometry, path, timeout, "solid", [], {"pairs": dumped, "curved": curved})


def export(
    geometry: Geometry, path: Path, timeout: float = 300.0, part: Part = "solid"
) -> list[str]:
    """Writes a geometry to ``path`` in the format of its suffix; returns what the user should know.

    part: "solid" is what is printed; "core" is the air of its cavities, what is put into a mould,
    in .stl and .step only.

    .msh: gmsh 4.1 with named groups; .vtu: the same mesh for ParaView; .stl: the closed skin of the
    whole solid, outside and cavities; .step: the whole solid for CAD. Returns and raises as
    ``make_mesh``, SpecError for another suffix or a missing folder.
    """
    path = Path(path)
    if path.suffix.lower() not in (*SUFFIXES, *PATTERNS):
        raise SpecError(f"{path}: no format for '{path.suffix}'; use one of {', '.join(SUFFIXES)}")
    if path.suffix.lower() in PATTERNS and geometry.pattern() is None:
        raise SpecError(
            f"{path}: a cutting pattern is that of sheets; {_name(geometry)} is a solid"
        )
    if part == "core":
        if path.suffix.lower() not in CORE_SUFFIXES:
            raise SpecError(f"{path}: a core is written to {' or '.join(CORE_SUFFIXES)} only")
        if not geometry.layout().cavities:
            raise SpecError(f"{path}: {_name(geometry)} has no closed cavity, so there is no core")
    return _write(geometry, path, timeout, path.suffix.lower(), part)


def _write(
    geometry: Geometry,
    path: Path,
    timeout: float,
    suffix: str,
    part: Part = "solid",
    curved: bool = False,
) -> list[str]:
    notes: list[str] = []
    if not path.parent.is_dir():
        raise SpecError(f"{path}: there is no folder '{path.parent}'")
    pattern = geometry.pattern() if suffix in PATTERNS else None
    with replacing(path, suffix) as temporary:
        if pattern is not None:
            temporary.write_text(pattern.text(suffix), encoding="utf-8")
        elif not geometry.layout().regions:
            geometry.export_sheets(temporary, suffix)
        else:
            more = {"curved": curved}
            _run_gmsh(geometry, temporary.resolve(), timeout, part, notes, more)
            _check_whole(temporary)
    return notes


def _check_whole(path: Path) -> None:
    """Raises OSError where the disk was full: gmsh cuts the file short and says nothing."""
    with open(path, "rb") as file:
        file.seek(max(0, path.stat().st_size - 100))
        last = file.read().rstrip().rpartition(b"\n")[2]
    if not last.startswith(ENDS.get(path.suffix, b"")):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))


def _run_gmsh(
    geometry: Geometry,
    path: Path,
    timeout: float,
    part: Part | Look,
    said: list[str],
    more: Mapping[str, Any] | None = None,
) -> None:
    kind = type(geometry)
    job = {
        "module": kind.__module__,
        "file": getattr(sys.modules[kind.__module__], "__file__", None),
        "class": kind.__qualname__,
        "parameters": geometry.model_dump(),
        "path": str(path),
        "part": part,
        "timeout": timeout,
        "parent": os.getpid(),
        **(more or {}),
    }
    variables = environment(without=MPI_PREFIXES) | {"OMP_NUM_THREADS": "1"}
    process = subprocess.Popen(
        bound(forkserver.command(["-m", "softact.geometry.gmsh_process"], variables)),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        **UTF8,
        env=variables,
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
    said += _said(log, NOTE)
    if process.returncode == 0:
        return
    faults = _said(log, FAULT)
    if faults:
        raise MeshError(*(f"{_name(geometry)}: {fault}" for fault in faults))
    if process.returncode == -signal.SIGKILL:
        raise GmshKilledError(f"{_name(geometry)}: gmsh was killed by signal 9 (out of memory?)")
    how = f"ended with exit code {process.returncode}"
    if process.returncode < 0:
        how = f"crashed ({signal.Signals(-process.returncode).name})"
    raise MeshError(f"{_name(geometry)}: gmsh {how}{_last_words(log)}")


def _said(log: str, mark: str) -> list[str]:
    return [line[len(mark) :] for line in log.splitlines() if line.startswith(mark)]


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


def main(kind: type[Geometry]) -> None:
    """Lets a geometry file run by itself: its fields become options, it writes one file."""
    import click

    def write(output: Path, timeout: float, **texts: str | None) -> None:
        values = {name: _as_in_spec(text) for name, text in texts.items() if text is not None}
        try:
            export(kind.model_validate(values), output, timeout)
        except ValidationError as error:
            for fault in error.errors():
                where = ".".join(str(part) for part in fault["loc"])
                click.echo(f"{where}: {fault['msg']}", err=True)
            sys.exit(2)
        except SoftactError as error:
            click.echo("\n".join(error.lines), err=True)
            sys.exit(error.exit_code)

    command = click.Command("geometry", callback=write, help=kind.__doc__)
    command.params.append(
        click.Option(
            ["-o", "--output"],
            type=click.Path(path_type=Path),
            required=True,
            help=".msh, .vtu, .stl or .step; .dxf or .svg for the pattern of sheets",
        )
    )
    command.params.append(click.Option(["--timeout"], type=float, default=300.0, help="seconds"))
    for name, info in kind.model_fields.items():
        if name != "type":
            flag = "--" + name.replace("_", "-")
            command.params.append(click.Option([flag, name], help=info.description))
    command()


def _as_in_spec(text: str) -> Any:
    """6 is a number, true a truth, and '16 mm' a text, as YAML reads them."""
    from softact.files.document import scalar

    try:
        return scalar(text)
    except SpecError:
        return text

"""Faces of a STEP file by number, place and direction, and the names of those that have none."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    WithJsonSchema,
    model_validator,
)

from softact.geometry import part_axis
from softact.geometry.step_solids import Solid
from softact.mesh.components import connected, place
from softact.units import Dimensionless, Length

# Parts of the part's size within which a face lies in a plane or a box; of 1 within which two
# directions are the same.
NEAR, SAME_DIRECTION = 1e-5, 1e-4
_ON_AN_EDGE = 17  # points
CAVITY, OUTER = "cavity", "outer"  # names of faces without one


def _three(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _numbers(value: Any) -> Any:
    """``3`` and ``[3, 4]`` are numbers of faces."""
    if isinstance(value, int) and not isinstance(value, bool):
        return {"numbers": [value]}
    return {"numbers": value} if isinstance(value, list) else value


def _beside(value: Any) -> Any:
    """``3`` is a number of a face, ``tip`` the name of a surface."""
    if isinstance(value, int) and not isinstance(value, bool):
        return (value,)
    return tuple(value) if isinstance(value, list) else value


Beside = Annotated[
    str | tuple[Annotated[int, Field(ge=1)], ...],
    BeforeValidator(_beside),
    WithJsonSchema({"anyOf": [
        {"type": "string"},
        {"type": "integer", "minimum": 1},
        {"type": "array", "items": {"type": "integer", "minimum": 1}},
    ]}),
]  # fmt: skip
Point = Annotated[tuple[Length, Length, Length], BeforeValidator(_three)]
Direction = Annotated[tuple[Dimensionless, Dimensionless, Dimensionless], BeforeValidator(_three)]


class Selection(BaseModel):
    """Faces of a STEP file, by what is given; all of it has to hold. Numbers may stand alone:
    `3` or `[3, 4]`."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    numbers: tuple[Annotated[int, Field(ge=1)], ...] | None = Field(
        None, strict=False, description="of the faces, as 'softact validate' lists them"
    )
    plane: dict[Literal["x", "y", "z"], Length] | None = Field(
        None, description="flat faces in a plane: {x: 0 mm}"
    )
    normal: Direction | None = Field(
        None, description="flat faces that look this way, out of the solid: [0, 0, 1]"
    )
    box: Annotated[tuple[Point, Point], BeforeValidator(_three)] | None = Field(
        None, description="faces that lie in a box, by two corners of it"
    )
    beside: Beside | None = Field(
        None,
        description="faces that share an edge with those of another surface, or with these numbers",
    )

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        if not any((self.numbers, self.plane, self.normal, self.box, self.beside)):
            raise ValueError("selects no face; write numbers, plane, normal, box or beside")
        if self.normal and not any(self.normal):
            raise ValueError("normal: three zeros are no direction")
        return self

    def holds(self, face: Face, near: float, others: Sequence[Face] = ()) -> bool:
        """Whether a face is one of these; near: mm that count as nothing; others: the faces that
        ``beside`` means."""
        lower, upper = face.box
        if self.beside and (
            face in others or not any(face.edges & other.edges for other in others)
        ):
            return False
        if self.numbers and not face.numbers & set(self.numbers):
            return False
        for axis, value in (self.plane or {}).items():
            at = "xyz".index(axis)
            if not face.flat or max(abs(lower[at] - value), abs(upper[at] - value)) > near:
                return False
        if self.normal:
            wanted = np.array(self.normal) / np.linalg.norm(self.normal)
            if not face.flat or np.linalg.norm(face.normal - wanted) > 1e2 * SAME_DIRECTION:
                return False
        if self.box:
            corners = np.array(self.box)
            inside = (lower > corners.min(axis=0) - near) & (upper < corners.max(axis=0) + near)
            return bool(inside.all())
        return True


class _OrNumbers:
    """Tells the JSON schema what else may stand in the place of a selection."""

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        number = {"type": "integer", "minimum": 1}
        return {"anyOf": [number, {"type": "array", "items": number}, handler(schema)]}


AnySelection = Annotated[Selection, BeforeValidator(_numbers), _OrNumbers()]


@dataclass(frozen=True, eq=False)
class Face:
    """A face of the solids, or a piece of one where two solids are joined.

    tag: gmsh's. solids: gmsh's tags of the one or two that it bounds. numbers, names: of the faces
    of the file that it is a piece of. edges: gmsh's tags. box: (2, 3) mm; area: mm^2; normal: out
    of the first of its solids, in its middle; width: mm, twice the area over the length of its
    edges, infinite where it has none.
    """

    tag: int
    solids: tuple[int, ...]
    numbers: frozenset[int]
    names: frozenset[str]
    edges: frozenset[int]
    box: np.ndarray
    centre: np.ndarray
    area: float
    normal: np.ndarray
    flat: bool
    width: float

    @property
    def look(self) -> str:
        """What it looks like, in words."""
        looks = f", looks along ({', '.join(f'{n + 0.0:.3g}' for n in np.round(self.normal, 3))})"
        return (
            f"{'flat' if self.flat else 'curved'}, {self.area:.4g} mm^2, middle at "
            f"{place(self.centre)}{looks if self.flat else ''}"
        )

    def line(self, owner: str) -> str:
        """A line about it; owner: name of its solid, "" where there is one only."""
        numbers = " and ".join(map(str, sorted(self.numbers)))
        name = f" {', '.join(sorted(self.names))}," if self.names else ""
        of = f" of {owner}" if owner else ""
        return f"face {numbers}{of}:{name} {self.look}"


def faces_of(gmsh: ModuleType, solids: Sequence[Solid], pieces: dict[int, list[int]]) -> list[Face]:
    """The faces of gmsh's current solids. pieces: face of a solid when it was read -> faces now."""
    numbers: dict[int, set[int]] = {}
    names: dict[int, set[str]] = {}
    count = 0
    for solid in solids:
        for face, name in zip(solid.faces, solid.face_names, strict=True):
            count += 1
            for piece in pieces.get(face, [face]):
                numbers.setdefault(piece, set()).add(count)
                names.setdefault(piece, set()).update([name] if name else [])
    owners: dict[int, list[int]] = {}
    for _, solid in gmsh.model.getEntities(3):
        for _, face in gmsh.model.getBoundary([(3, solid)], oriented=False):
            owners.setdefault(face, []).append(solid)
    return [
        _face(gmsh, tag, owners[tag], numbers.get(tag, set()), names.get(tag, set()))
        for tag in sorted(owners)
    ]


def _face(
    gmsh: ModuleType, tag: int, owners: Sequence[int], numbers: set[int], names: set[str]
) -> Face:
    lower, upper = (np.array(bound) for bound in gmsh.model.getParametrizationBounds(2, tag))
    grid = [lower + (upper - lower) * (i, j) for j in (0.5, 0.1, 0.9) for i in (0.5, 0.1, 0.9)]
    # Those of a face are turned out of the solid that it was made for.
    normals = np.reshape(gmsh.model.getNormal(tag, np.concatenate(grid)), (-1, 3))
    flat = bool(np.linalg.norm(normals - normals[0], axis=1).max() < SAME_DIRECTION)
    edges = frozenset(abs(edge) for _, edge in gmsh.model.getBoundary([(2, tag)], oriented=False))
    area, around = gmsh.model.occ.getMass(2, tag), sum(gmsh.model.occ.getMass(1, e) for e in edges)
    return Face(
        tag,
        tuple(owners),
        frozenset(numbers),
        frozenset(names),
        edges,
        _box_of(gmsh, tag, edges)
        if flat
        else np.reshape(gmsh.model.getBoundingBox(2, tag), (2, 3)),
        np.array(gmsh.model.occ.getCenterOfMass(2, tag)),
        area,
        normals[0],
        flat,
        2 * area / around if around else float("inf"),
    )


def _box_of(gmsh: ModuleType, tag: int, edges: Iterable[int]) -> np.ndarray:
    """(2, 3) mm, of a flat face: OCC's box, within the middle of its plane. OCC's own is as much
    too large as a healed face may be off."""
    box = np.reshape(gmsh.model.getBoundingBox(2, tag), (2, 3))
    points = [np.zeros((0, 3))]
    for edge in edges:
        (low,), (high,) = gmsh.model.getParametrizationBounds(1, edge)
        places = np.linspace(low, high, _ON_AN_EDGE)
        points.append(np.reshape(gmsh.model.getValue(1, edge, places), (-1, 3)))
    found = np.vstack(points)
    if not len(found):
        return box
    # An arc between the points goes beyond them, and not beyond OCC's box.
    lower, upper = found.min(axis=0), found.max(axis=0)
    plane = np.ptp(found, axis=0) < NEAR * np.ptp(box, axis=0).max()
    return np.where(plane, [lower, upper], box)


def linked(groups: Sequence[Iterable[int]]) -> list[int]:
    """A number for each group that those have in common which share a member, by any way."""
    sets = [set(group) for group in groups]
    owners: dict[int, list[int]] = {}
    for number, members in enumerate(sets):
        for member in members:
            owners.setdefault(member, []).append(number)
    pairs = [(known[0], other) for known in owners.values() for other in known[1:]]
    one, other = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    return [int(number) for number in connected(one, other, len(sets))]


def shells(faces: Sequence[Face], axis: str = "x") -> tuple[list[Face], list[list[Face]]]:
    """The faces outside, and those around each room inside, from the clamp to the tip.

    Faces between two joined solids are neither.
    """
    free = [face for face in faces if len(face.solids) == 1]
    part = dict(zip(_tags(faces), linked([face.solids for face in faces]), strict=True))
    shell = linked([face.edges for face in free])
    grouped: dict[int, list[Face]] = {}
    for face, number in zip(free, shell, strict=True):
        grouped.setdefault(number, []).append(face)
    outside, rooms = [], []
    for label in dict.fromkeys(part.values()):
        own = [group for group in grouped.values() if part[group[0].tag] == label]
        own.sort(key=lambda group: -np.linalg.norm(np.ptp(_box(group), axis=0)))
        outside += own[0]
        rooms += own[1:]
    return outside, sorted(rooms, key=lambda group: part_axis.order(axis, *_box(group)))


def around_rooms(named: Sequence[Face], faces: Sequence[Face]) -> list[Face]:
    """The walls of a room, of faces that are named so.

    Where joining has cut a face, its name has gone to all its pieces; those outside the room go.
    """
    inside = {face.tag for room in shells(faces)[1] for face in room}
    cut = set().union(*(face.numbers for face in named if face.tag in inside))
    return [face for face in named if face.tag in inside or not face.numbers & cut]


def _tags(faces: Sequence[Face]) -> list[int]:
    return [face.tag for face in faces]


def _box(faces: Sequence[Face]) -> np.ndarray:
    boxes = np.array([face.box for face in faces])
    return np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def automatic(
    faces: Sequence[Face], clamp: str, tip: str, axis: str, slack: float = 0.0
) -> dict[str, list[Face]]:
    """Names for the faces of a file that has none. slack: mm by which a box may be too large.

    clamp, tip: the flat faces at the ends along ``axis``. The walls of all rooms inside are
    'cavity', and 'cavity_1', 'cavity_2', ... one by one; what is left outside is 'outer'.
    """
    outside, rooms = shells(faces, axis)
    k, found = part_axis.component(axis), {}
    at_clamp, at_tip = part_axis.clamp_and_tip(axis, *_box(outside)[:, k])
    near = NEAR * np.linalg.norm(np.ptp(_box(outside), axis=0)) + 1e-6 + slack
    for name, at in ((clamp, at_clamp), (tip, at_tip)):
        found[name] = [
            face for face in outside if face.flat and (np.abs(face.box[:, k] - at) < near).all()
        ]
    found[CAVITY] = [face for room in rooms for face in room]
    found |= {f"{CAVITY}_{number}": room for number, room in enumerate(rooms, start=1)}
    ends = {face.tag for name in (clamp, tip) for face in found[name]}
    found[OUTER] = [face for face in outside if face.tag not in ends]
    return {name: members for name, members in found.items() if name and members}

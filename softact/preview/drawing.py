"""What is drawn of a model before it is solved: patches of its surfaces, by what they are for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from softact.geometry.step_drawing import FaceDrawing
from softact.mesh.boundary import among, exterior, face_keys
from softact.mesh.components import FACES
from softact.mesh.layout import Layout
from softact.mesh.msh_file import Tetrahedra
from softact.mesh.sheets import SheetMesh
from softact.preview.roles import CAVITIES, HELD, TIP, Role
from softact.report.surface import mirrored

SECTION = "section"
_UNNAMED = "not named"
#: Colours of the solids where they are cut, by region.
_SECTIONS = ("#d5dde2", "#cfe0c4", "#e8d8c3", "#d9d0e6", "#c7e0e4")
_PLAIN = "#9fb4c0"
#: Colours of faces of a file, by the names that they would be given.
_FACES = {"clamp": HELD, "tip": TIP, "cavity": CAVITIES[0]}


@dataclass(frozen=True)
class Patch:
    """Triangles (k, 3), or edges (k, 2), with a name and a colour. said: what happens with it.

    seen: in which view: "open" (cut), "whole", or "" for both.
    """

    name: str
    colour: str
    said: str
    corners: np.ndarray
    seen: str = ""
    label: bool = True
    opacity: float = 1.0


@dataclass(frozen=True)
class Drawing:
    """points (n, 3) mm and the patches on them. cut: in words, how it was cut open, "" where it
    was not. closed: axes (0, 1, 2) whose symmetry plane the cut is."""

    points: np.ndarray
    patches: list[Patch] = field(default_factory=list)
    cut: str = ""
    closed: tuple[int, ...] = ()

    def seen(self, view: str) -> list[Patch]:
        """The patches of a view, "open" or "whole"."""
        return [patch for patch in self.patches if patch.seen in ("", view)]

    def add(self, points: np.ndarray, patch: Patch) -> Drawing:
        """With a patch on points of its own, such as an obstacle."""
        moved = replace(patch, corners=patch.corners + len(self.points))
        return replace(
            self, points=np.vstack([self.points, points]), patches=[*self.patches, moved]
        )


def of_solid(mesh: Tetrahedra, layout: Layout, roles: Mapping[str, Role]) -> Drawing:
    """The surfaces of a solid, cut open along its symmetry planes or else through its middle."""
    axes = tuple(layout.symmetry.values())
    outside = exterior(mesh.cells)
    if axes:
        names = " and ".join(f"{'xyz'[axis]} = 0" for axis in axes)
        planes = "planes" if len(axes) > 1 else "plane"
        drawing = Drawing(mesh.points, [], f"cut along its symmetry {planes} {names}", axes)
        parts = [*_named(outside, mesh, layout, roles, ""), *_inside(mesh, layout, roles, outside)]
        whole = [p for p in parts if _is_outside(p.name, layout)]
        for patch in parts:
            drawing.patches.append(replace(patch, seen="open"))
        return _with_images(drawing, whole, axes)
    at = float(mesh.points[:, 1].min() + mesh.points[:, 1].max()) / 2
    kept = mesh.points[mesh.cells].mean(axis=1)[:, 1] >= at
    halved = exterior(mesh.cells[kept])
    open_ = _named(
        halved, mesh, layout, roles, "open", _sections(mesh, layout, roles, kept, halved, outside)
    )
    inside = _inside(mesh, layout, roles, outside, kept)
    said = f"cut through its middle, y = {at:.4g} mm, along the elements"
    return Drawing(
        mesh.points,
        [*open_, *(replace(p, seen="open") for p in inside),
         *_named(outside, mesh, layout, roles, "whole")],
        said,
    )  # fmt: skip


def of_sheets(mesh: SheetMesh, layout: Layout, roles: Mapping[str, Role]) -> Drawing:
    """The sheets and curves of a geometry without a solid, and their mirror images."""
    axes = tuple(layout.symmetry.values())
    parts = [
        _patch(name, roles, mesh.triangles[members], _SECTIONS[number % len(_SECTIONS)])
        for number, (name, members) in enumerate(mesh.parts.items())
    ]
    lines = [
        _patch(name, roles, np.asarray(edges), "#15202b")
        for name, edges in mesh.curves.items()
        if name not in layout.symmetry and len(edges)
    ]
    drawing = Drawing(mesh.points, [replace(p, seen="open") for p in (*parts, *lines)])
    return _with_images(drawing, [*parts, *lines], axes)


def of_faces(points: np.ndarray, faces: Sequence[FaceDrawing]) -> Drawing:
    """The faces of a file by their numbers, those of one surface in one colour; cut open by leaving
    out the half that is nearer."""
    at = float(points[:, 1].min() + points[:, 1].max()) / 2
    names = [face.names[0] if face.names else "" for face in faces]
    colours = {name: _FACES.get(name, "") for name in names}
    others = [name for name, colour in colours.items() if name and not colour]
    colours |= {name: CAVITIES[n % len(CAVITIES)] for n, name in enumerate(others)}
    patches = []
    for number, (face, name) in enumerate(zip(faces, names, strict=True)):
        colour = colours[name] or _SECTIONS[number % len(_SECTIONS)]
        of = "; ".join([*face.names, face.said])
        behind = face.triangles[points[face.triangles].mean(axis=1)[:, 1] >= at]
        for seen, triangles in (("open", behind), ("whole", face.triangles)):
            if len(triangles):
                patches.append(Patch(face.number, colour, of, triangles, seen))
    return Drawing(points, patches, f"cut through its middle, y = {at:.4g} mm")


def _patch(name: str, roles: Mapping[str, Role], corners: np.ndarray, plain: str) -> Patch:
    role = roles.get(name)
    colour = (role.colour if role else "") or plain
    return Patch(name, colour, role.said if role else "", corners)


def _is_outside(name: str, layout: Layout) -> bool:
    walls = {wall for names in layout.cavities.values() for wall in names}
    return not (name.startswith(SECTION) or name in walls or name in layout.symmetry)


def _with_images(drawing: Drawing, whole: Sequence[Patch], axes: Sequence[int]) -> Drawing:
    """With the mirror images of patches, as another view."""
    points, _ = mirrored(drawing.points, np.zeros((0, 3), int), axes)
    images = []
    for patch in whole:
        _, corners = mirrored(drawing.points, patch.corners, axes)
        images.append(replace(patch, corners=corners, seen="whole"))
    return replace(drawing, points=points, patches=[*drawing.patches, *images])


def _named(
    faces: np.ndarray,
    mesh: Tetrahedra,
    layout: Layout,
    roles: Mapping[str, Role],
    seen: str,
    sections: Sequence[Patch] = (),
) -> list[Patch]:
    """Faces (k, 3) by the surface that says most of them: one that is held or loaded, else the one
    with the fewest triangles. Symmetry planes and what was cut are sections of their region."""
    free = ~among(faces, [patch.corners for patch in sections])
    found: list[Patch] = []
    order = sorted(mesh.surfaces, key=lambda name: (name not in roles, len(mesh.surfaces[name])))
    for name in order:
        own = free & among(faces, [mesh.surfaces[name]])
        free &= ~own
        if not own.any():
            continue
        if name in layout.symmetry:
            found += _by_region(mesh, layout, roles, faces[own], seen)
        else:
            found.append(replace(_patch(name, roles, faces[own], _PLAIN), seen=seen))
    if free.any():
        found.append(Patch(_UNNAMED, _PLAIN, "", faces[free], seen, label=False))
    return [*found, *(replace(p, seen=seen) for p in sections)]


def _by_region(
    mesh: Tetrahedra, layout: Layout, roles: Mapping[str, Role], faces: np.ndarray, seen: str
) -> list[Patch]:
    owner = _owners(mesh.cells, faces)
    region = mesh.region[owner]
    return [
        _section(name, number, roles, faces[region == number], seen)
        for number, name in enumerate(layout.regions)
        if (region == number).any()
    ]


def _sections(
    mesh: Tetrahedra,
    layout: Layout,
    roles: Mapping[str, Role],
    kept: np.ndarray,
    halved: np.ndarray,
    outside: np.ndarray,
) -> list[Patch]:
    """The faces that the cut has laid open, by region number."""
    faces = halved[~among(halved, [outside])]
    region = mesh.region[kept][_owners(mesh.cells[kept], faces)]
    return [
        _section(layout.regions[number], number, roles, faces[region == number])
        for number in np.unique(region)
    ]


def _section(
    region: str, number: int, roles: Mapping[str, Role], faces: np.ndarray, seen: str = ""
) -> Patch:
    colour, name = _SECTIONS[number % len(_SECTIONS)], f"{SECTION} of {region}"
    return Patch(name, colour, roles[region].said if region in roles else "", faces, seen, False)


def _inside(
    mesh: Tetrahedra,
    layout: Layout,
    roles: Mapping[str, Role],
    outside: np.ndarray,
    kept: np.ndarray | None = None,
) -> Iterator[Patch]:
    """Surfaces inside the solid, such as those of embedded layers."""
    nodes = np.unique(mesh.cells if kept is None else mesh.cells[kept])
    for name, triangles in mesh.surfaces.items():
        inner = triangles[~among(triangles, [outside])]
        inner = inner[np.isin(inner, nodes).all(axis=1)]
        if len(inner):
            yield _patch(name, roles, inner, "#7b5ea7")


def _owners(cells: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """A cell (k,) of each face (k, 3)."""
    count = int(cells.max()) + 1
    keys = face_keys(cells[:, FACES].reshape(-1, 3), count)
    order = np.argsort(keys, kind="stable")
    return order[np.searchsorted(keys[order], face_keys(faces, count))] // 4

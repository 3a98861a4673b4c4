"""Which wall gives way at a limit of the load, in a designer's words: from the fields on both sides
of the limit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softact.mesh.boundary import among, exterior, surface_of
from softact.results.folder import Results, load, load_name, place_text
from softact.verdict.reached import reached, unstable_rows

# Stretch by that at the limit from which on a wall is said to balloon.
BALLOONS = 1.05
_STRETCH = "max_principal_stretch"
_SIDES = {
    (2, 1): "upper wall", (2, -1): "lower wall", (1, 1): "side wall", (1, -1): "side wall",
    (0, 1): "cross wall", (0, -1): "cross wall",
}  # fmt: skip


@dataclass(frozen=True)
class Place:
    """A place of the undeformed actuator. at: (3,) mm. along: mm from the clamp along the axis.
    wall: such as "upper wall"; surface, region: names, "" where there is none."""

    at: np.ndarray
    along: float
    wall: str
    surface: str
    region: str

    def __str__(self) -> str:
        named = f" of surface '{self.surface}'" if self.surface else ""
        region = f" of region '{self.region}'" if self.region else ""
        return (
            f"the {self.wall}{named}{region} {self.along:.0f} mm from the clamp (x, y, z = "
            f"{place_text(self.at)} mm, undeformed)"
        )


def limit_text(results: Results) -> str:
    """What happens at the limit of the path and what helps; "" where there is no limit or the
    fields do not tell."""
    loads, name = load(results), load_name(results)
    if not reached(results).limit or not results.has_mesh or len(results.increments) != len(loads):
        return ""
    if not results.layout.regions or len(loads) < 3 or name is None:
        return ""
    unstable = unstable_rows(results)
    if _STRETCH not in results.field_names(-1):
        return ""
    if not unstable.any():
        return _stretched_most(results)
    begin, end = _both_sides(unstable)
    before, after = (_at_cells(results, row) for row in (begin, end))
    growth = after / np.maximum(before, 1e-300)
    cell = int(np.argmax(after - before))
    if growth[cell] < BALLOONS or not _takes_in(results, name, begin, end):
        return _moves_aside(results, begin, end)
    place = place_of(results, cell)
    falls = abs(loads[end]) < abs(loads[begin])
    how = f"the pressure falls to {loads[end]:.4g} kPa" if falls else (
        f"the pressure goes from {loads[begin]:.4g} to {loads[end]:.4g} kPa"
    )  # fmt: skip
    return (
        f"{place} balloons: its stretch goes from {before[cell]:.2f} to {after[cell]:.2f} while "
        f"{how}; a thicker or stiffer wall there bears more, and inject instead of pressure (as by "
        "a syringe) goes on beyond the limit"
    )


def place_of(results: Results, cell: int) -> Place:
    """Where an element is: the nearest face of the surface says which wall it belongs to."""
    layout = results.layout
    at = results.points[results.cells[cell, :4]].mean(axis=0)
    planes = [results.surfaces[n] for n in layout.symmetry if n in results.surfaces]
    faces = exterior(results.cells)
    faces = faces[~among(faces, planes)]
    corners = results.points[faces[:, :3]]
    nearest = int(np.argmin(np.linalg.norm(corners.mean(axis=1) - at, axis=1)))
    a, b, c = corners[nearest]
    normal = np.cross(b - a, c - a)
    if _is_wall_of_cavity(results, faces[nearest]):
        normal = -normal  # from the cavity outwards
    direction = int(np.argmax(np.abs(normal)))
    wall = _SIDES[direction, 1 if normal[direction] > 0 else -1]
    if abs(layout.axis[0]) < 0.9:
        wall = "wall"  # the words are those of an actuator that lies along x
    regions = results.region_names
    region = regions[int(results.region[cell])] if len(regions) > 1 else ""
    along = float((at - np.asarray(layout.origin)) @ np.asarray(layout.axis))
    return Place(at, along, wall, surface_of(faces[nearest], results.surfaces), region)


def _is_wall_of_cavity(results: Results, face: np.ndarray) -> bool:
    walls = [n for names in results.layout.cavities.values() for n in names]
    return bool(among(face[None], [results.surfaces[n] for n in walls if n in results.surfaces])[0])


def _both_sides(unstable: np.ndarray) -> tuple[int, int]:
    """The state before the first unstable ones, and the last of these."""
    first = int(np.argmax(unstable))
    later = np.flatnonzero(~unstable[first:])
    end = first + int(later[0]) if len(later) else len(unstable)
    return max(first - 1, 0), end - 1


def _at_cells(results: Results, row: int) -> np.ndarray:
    """(cells,) mean stretch of the elements' corners: a node at a sharp corner alone decides
    nothing."""
    return results.field(row, _STRETCH)[results.cells[:, :4]].mean(axis=1)


def _stretched_most(results: Results) -> str:
    """What to say of a run that ends before its limit is passed."""
    stretch = _at_cells(results, -1)
    cell = int(np.argmax(stretch))
    return (
        f"in the last state the material is stretched most, {stretch[cell]:.2f} times, in "
        f"{place_of(results, cell)}"
    )


def _takes_in(results: Results, name: str, begin: int, end: int) -> bool:
    """Whether the pressed cavity grows between two states."""
    column = name.replace("pressure", "cavity_volume", 1).replace("_kPa", "_mm3")
    volumes = results.curve.get(column)
    return volumes is None or volumes[end] > volumes[begin]


def _moves_aside(results: Results, begin: int, end: int) -> str:
    """What to say of a structure that snaps or buckles without a wall that balloons."""
    moved = results.field(end, "displacement") - results.field(begin, "displacement")
    size = np.linalg.norm(moved, axis=1)
    cell = int(np.argmax(size[results.cells[:, :4]].mean(axis=1)))
    way = moved[results.cells[cell, :4]].mean(axis=0)
    place = place_of(results, cell)
    return (
        f"{place} moves most there, by {np.linalg.norm(way):.1f} mm: the structure snaps or "
        "buckles; thicker walls there or a support bear more"
    )

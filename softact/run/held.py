"""Parts of a mesh that nothing holds, found before the first load: they would fly away."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from softact.errors import SpecError
from softact.mesh.components import components, gap, part_names
from softact.mesh.layout import Layout
from softact.mesh.msh_file import Tetrahedra
from softact.spec.contact import outside

if TYPE_CHECKING:
    from softact.spec import Spec, SupportSpec

FREE = 1e-10  # of the stiffest motion: what is softer is not held


def refuse_loose(tets: Tetrahedra, layout: Layout, spec: Spec) -> None:
    """Raise SpecError where a part of a mesh can move or turn as a whole in some step of a spec.

    Parts that may touch something, or on which a sheet lies, are left to the solver.
    """
    if layout.repeats:
        return  # the means of its left face hold it
    labels = components(tets.points, tets.cells)
    names = part_names(tets.points, tets.cells, tets.region, list(layout.regions), labels)
    touching = _touching(layout, spec)
    faults: dict[str, None] = {}
    for label, name in enumerate(names):
        nodes = np.zeros(len(tets.points), dtype=bool)
        nodes[tets.cells[labels == label]] = True
        if any(nodes[tets.surfaces[surface]].any() for surface in touching):
            continue
        for step, supports in _sets_of_supports(spec):
            free = _free(tets, layout, supports, nodes)
            if free:
                faults[_fault(tets, labels, label, name, step, free)] = None
    if faults:
        raise SpecError(*faults)


def _touching(layout: Layout, spec: Spec) -> set[str]:
    """Surfaces that obstacles, other surfaces or sheets may hold; that the outside keeps from
    passing through itself holds nothing."""
    found = set(layout.covers.values())
    for obstacle in spec.obstacles.values():
        found |= set(obstacle.surfaces or layout.outside)
    for contact in spec.contact or ():
        if contact.groups != (outside(layout),):
            found |= {name for group in contact.groups for name in group}
    return found & set(layout.surfaces)


def _sets_of_supports(spec: Spec) -> Iterable[tuple[str, Sequence[SupportSpec]]]:
    """The supports at the start and those of each step that has its own, with the step's name."""
    steps = [(step.name, step.supports) for step in spec.steps if step.supports is not None]
    first = spec.steps[0].supports if spec.steps else None
    return steps if first is not None else [("", spec.supports or ()), *steps]


def _free(
    tets: Tetrahedra, layout: Layout, supports: Sequence[SupportSpec], nodes: np.ndarray
) -> str:
    """What a part can do as a whole, "" where it is held. nodes: (n,) whether each is of it."""
    held = [(surface, axis) for surface, axis in layout.symmetry.items()]
    known = (*tets.surfaces, *layout.marks)
    held += [(s.surface, axis) for s in supports for axis in s.held if s.surface in known]
    middle = tets.points[nodes].mean(axis=0)
    size = float(np.abs(tets.points[nodes] - middle).max())
    stiffness = np.zeros((6, 6))
    for surface, axis in held:
        rows = _motions((_places(tets, layout, surface, nodes) - middle) / size)[:, axis]
        stiffness += rows.T @ rows
    values, ways = np.linalg.eigh(stiffness)
    loose = ways.T[values <= FREE * values.max()]
    if not len(loose):
        return ""
    if len(loose) == 6:
        return "nothing holds it"
    # A turn about an axis beside the middle moves the middle as well: that is no motion of its own.
    moves = np.linalg.norm(loose[:, :3], axis=0) > 0.99
    turns = np.linalg.norm(loose[:, 3:], axis=0) > 0.1
    able = [f"move along {c}" for c, free in zip("xyz", moves, strict=True) if free]
    able += [f"turn about {c}" for c, free in zip("xyz", turns, strict=True) if free]
    return f"it can {' and '.join(able) or 'move'}"


def _places(tets: Tetrahedra, layout: Layout, name: str, nodes: np.ndarray) -> np.ndarray:
    """Undeformed places (n, 3) at which a support of that name holds a part."""
    line = layout.lines.get(name, ())
    if name in layout.points or (line and not isinstance(line[0], str)):
        places = np.atleast_2d(np.array(layout.points.get(name, line), dtype=float))
        for axis in layout.symmetry.values():
            side = np.sign(tets.points[:, axis].mean())
            places[:, axis] = np.where(places[:, axis] * side < 0, -1, 1) * places[:, axis]
        nearest = [np.linalg.norm(tets.points - place, axis=1).argmin() for place in places]
        return places[nodes[nearest]]
    surfaces = [layout.covers.get(str(surface), str(surface)) for surface in line] or [name]
    found = [tets.surfaces.get(surface, np.empty(0, int)) for surface in surfaces]
    own = np.unique(functools.reduce(np.intersect1d, found))
    return tets.points[own[nodes[own]]]


def _motions(points: np.ndarray) -> np.ndarray:
    """Displacement (n, 3, 6) of points (n, 3) by unit motions and turns."""
    found = np.zeros((len(points), 3, 6))
    found[:, range(3), range(3)] = 1.0
    for axis, direction in enumerate(np.eye(3)):
        found[:, :, 3 + axis] = np.cross(direction, points)
    return found


def _fault(
    tets: Tetrahedra, labels: np.ndarray, label: int, name: str, step: str, free: str
) -> str:
    when = f"step {step}: " if step else ""
    if labels.max() == 0:
        return f"{when}the supports do not hold the body: {free}; fix it on some surface"
    return (
        f"{when}the part {name} {gap(tets.points, tets.cells, labels, label)}, and {free}; join "
        "it, fix it on some surface, or write a contact that holds it"
    )

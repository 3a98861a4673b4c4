"""The places of highest stretch and stress: which they are, and the section of the page on them.

A place counts by its own where the value falls by ``_FALL`` on every way to a higher one: the
prominence of a mountain, over the edges of the mesh. So a ridge of neighbours is one place.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from markupsafe import Markup

from softact.mesh.boundary import exterior
from softact.report import base, labels
from softact.report.base import Section
from softact.report.place import Places
from softact.report.surface import pair_keys
from softact.results.folder import Results, load_text, place_text
from softact.verdict.reached import reached

STRETCH, STRESS, MISES = "max_principal_stretch", "max_principal_stress", "von_mises"
_FALL = 0.15
_FLOOR = 0.5  # of the largest value: what is lower is no hot spot
_MOST = 3  # places of each field
_ALIKE, _ACROSS = 0.2, 0.06  # of the value, and of the size across the axis
_SAME = 0.03  # of the actuator's size: one place by stretch and by stress
_SHARP_DEG = 30.0
# Middles of edges are neighbours of each other: one between two lower corners is no peak yet.
_SIDES = ((0, 4), (4, 1), (1, 5), (5, 2), (2, 6), (6, 0), (0, 7), (7, 3), (1, 8), (8, 3), (2, 9),
          (9, 3), *combinations(range(4, 10), 2))  # fmt: skip
_SHEET = ((0, 3), (3, 1), (1, 4), (4, 2), (2, 5), (5, 0), *combinations(range(3, 6), 2))
_FLAT = {4: ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)), 3: ((0, 1), (1, 2), (2, 0))}


@dataclass(frozen=True)
class HotSpot:
    """A place of high values. field: by which it was found, first of all; values: field -> value;
    before, now: (3,) mm, undeformed and in the state; words: where that is; sharp: whether it lies
    in a re-entrant corner, where a finer mesh finds more; alike: how many such places follow each
    other along the axis, this one with them, and reach: the lowest and highest place of those on
    it, mm."""

    node: int
    field: str
    values: Mapping[str, float]
    before: np.ndarray
    now: np.ndarray
    words: str
    sharp: bool
    alike: int = 1
    reach: tuple[float, float] = (0.0, 0.0)


def spots(results: Results) -> list[HotSpot]:
    """The hot spots of the state that stands for the run, those by stretch first; none without
    one."""
    row = reached(results).main
    if row is None or not results.increments:
        return []
    names = results.field_names(row)
    stress = STRESS if STRESS in names else MISES
    fields = {name: results.field(row, name) for name in (STRETCH, stress) if name in names}
    moved, edges, sharp = results.field(row, "displacement"), _edges(results), _sharp(results)
    places, found = Places(results), []
    for name, values in fields.items():
        rise = np.nan_to_num(values - (1.0 if name == STRETCH else 0.0))
        for node, alike in _leaders(results, rise, peaks(rise, edges)):
            spot = HotSpot(
                node, name, {each: float(some[node]) for each, some in fields.items()},
                results.points[node], results.points[node] + moved[node], places.words(node),
                bool(sharp[node]), len(alike), _reach(results, alike),
            )  # fmt: skip
            found.append(spot)
    return _merged(results, found)


def peaks(rise: np.ndarray, edges: np.ndarray) -> list[int]:
    """Nodes of the highest values of a field, the highest first, each with a fall of ``_FALL`` of
    it before any higher one is reached.

    rise: (n,) values, from where they are nothing. edges: (e, 2) nodes that are neighbours.
    """
    top = float(rise.max(initial=0.0))
    if not top > 0:
        return []
    high = rise >= _FLOOR * top * (1 - _FALL)
    edges = edges[high[edges].all(axis=1)]
    order = np.argsort(-np.minimum(rise[edges[:, 0]], rise[edges[:, 1]]), kind="stable")
    summit = {int(node): int(node) for node in np.flatnonzero(high)}

    def root(node: int) -> int:
        while summit[node] != node:
            summit[node] = summit[summit[node]]
            node = summit[node]
        return node

    fallen = {}
    for one, other in edges[order].tolist():  # the water sinks, and islands grow together
        a, b = sorted((root(one), root(other)), key=lambda node: -rise[node])
        if a != b:
            fallen[b] = min(rise[one], rise[other])
            summit[b] = a
    found = [n for n in summit if rise[n] - fallen.get(n, 0.0) >= _FALL * rise[n]]
    return sorted((n for n in found if rise[n] >= _FLOOR * top), key=lambda node: -rise[node])


def _edges(results: Results) -> np.ndarray:
    """(e, 2) nodes that are neighbours."""
    cells = results.cells
    faces = [results.surfaces[name] for name in results.layout.sheets if name in results.surfaces]
    parts = [cells, *faces] if len(cells) else faces
    sides = {10: _SIDES, 6: _SHEET, **_FLAT}
    pairs = [part[:, side] for part in parts for side in sides[part.shape[1]]]
    count = len(results.points)
    keys = np.unique(pair_keys(np.sort(np.vstack(pairs), axis=1), count))
    return np.stack(np.divmod(keys, count), axis=1)


def _leaders(
    results: Results, rise: np.ndarray, found: Sequence[int]
) -> list[tuple[int, list[int]]]:
    """The highest peaks, each with those that are like it and follow it along the axis."""
    axis = np.array(results.layout.axis, float)
    across = results.points - np.outer(results.points @ axis, axis)
    near = _ACROSS * np.ptp(across, axis=0).max() if results.layout.length else 0.0
    groups: list[tuple[int, list[int]]] = []
    for node in found:
        for leader, group in groups:
            close = np.linalg.norm(across[node] - across[leader]) <= near
            if close and rise[node] >= (1 - _ALIKE) * rise[leader]:
                group.append(node)
                break
        else:
            groups.append((node, [node]))
    return groups[:_MOST]


def _reach(results: Results, nodes: Sequence[int]) -> tuple[float, float]:
    layout = results.layout
    along = (results.points[list(nodes)] - layout.origin) @ np.array(layout.axis, float)
    return float(along.min()), float(along.max())


def _merged(results: Results, found: Sequence[HotSpot]) -> list[HotSpot]:
    """Without those by stress that are one by stretch."""
    size = np.ptp(results.points, axis=0).max()
    kept: list[HotSpot] = []
    for spot in found:
        same = [n for n, other in enumerate(kept)
                if np.linalg.norm(spot.before - other.before) <= _SAME * size
                and spot.field != other.field]  # fmt: skip
        if not same:
            kept.append(spot)
            continue
        other = kept[same[0]]  # its own largest stress may be at the next node
        values = {name: max(other.values[name], spot.values[name]) for name in other.values}
        kept[same[0]] = replace(other, values=values)
    return kept


def _sharp(results: Results) -> np.ndarray:
    """(n,) whether a node lies on a re-entrant edge of the solid: one with less room outside than
    half a turn, where the stress of linear elasticity has no limit."""
    sharp = np.zeros(len(results.points), bool)
    if results.cells.shape[1] not in (4, 10) or not len(results.cells):
        return sharp
    faces = exterior(results.cells)
    corners = results.points[faces[:, :3]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    sides = np.vstack([faces[:, side] for side in ((0, 1, 2), (1, 2, 0), (2, 0, 1))])
    middle = np.concatenate([faces[:, nth] for nth in (3, 4, 5)]) if faces.shape[1] == 6 else None
    ends = np.sort(sides[:, :2], axis=1)
    order = np.lexsort(ends.T)
    same = (ends[order[1:]] == ends[order[:-1]]).all(axis=1)
    one, other = order[:-1][same], order[1:][same]
    ahead = results.points[sides[other, 2]] - results.points[sides[other, 0]]
    above = (ahead * normal[one % len(faces)]).sum(axis=1) > 0
    bent = (normal[one % len(faces)] * normal[other % len(faces)]).sum(axis=1)
    edge = one[above & (bent < np.cos(np.radians(_SHARP_DEG)))]
    sharp[sides[edge, :2]] = True
    if middle is not None:
        sharp[middle[edge]] = True
    return sharp


def section(results: Results, found: Sequence[HotSpot], pictures: Sequence[bytes]) -> list[Section]:
    """The section of the page; none without hot spots. pictures: WebP of each, or none."""
    row = reached(results).main
    if not found or row is None:
        return []
    drawn: list[bytes] = [*pictures] if len(pictures) == len(found) else [b""] * len(found)
    pairs = enumerate(zip(found, drawn, strict=True), start=1)
    cards = [_card(results, number, spot, picture) for number, (spot, picture) in pairs]
    said = f"{_INTRODUCTION} {_CORNERS}" if any(spot.sharp for spot in found) else _INTRODUCTION
    said = f"At {load_text(results, row)}. {said}"
    body = Markup("<div class='spots'>") + Markup("").join(cards) + Markup("</div>")
    return [Section("hotspots", "Hot spots", body + base.note(said), "Hot spots")]


_INTRODUCTION = (
    f"A place counts where the value falls by {100 * _FALL:.0f} % on every way to a higher one. In "
    "each picture the place is in the middle, red is its value, and what stands before it is cut "
    "away."
)
_CORNERS = (
    "In a re-entrant corner the computed value rises with every finer mesh: a fillet there makes "
    "it real."
)


def _card(results: Results, number: int, spot: HotSpot, picture: bytes) -> Markup:
    shown = base.picture(picture, f"Hot spot {number}") if picture else ""
    place = ",".join(f"{coordinate:.3f}" for coordinate in spot.before)
    return base.parts().spot(number, _head(spot), shown, _facts(results, spot), place)


def _head(spot: HotSpot) -> str:
    label = labels.field(spot.field)
    name = label.name.removeprefix("largest ")
    return f"{name[:1].upper() + name[1:]} {_three(spot.values[spot.field])} {label.unit}".strip()


def _three(value: float) -> str:
    """Three digits, the last zeros too."""
    return labels.number(value, 3, largest=value)


def _facts(results: Results, spot: HotSpot) -> list[str]:
    """What is said of a spot, line by line."""
    corner = ", in a re-entrant corner" if spot.sharp else ""
    found = [f"{spot.words[:1].upper()}{spot.words[1:]}{corner}"]
    for name, value in spot.values.items():
        if name != spot.field:
            label = labels.field(name)
            said = label.name if label.name.startswith("von") else label.name.capitalize()
            found.append(f"{said} {_three(value)} {label.unit}".strip())
    found.append(f"At x, y, z = {place_text(spot.before)} mm (undeformed)")
    if spot.alike > 1:
        low, high = (labels.number(place, 3) for place in spot.reach)
        found.append(f"{spot.alike} such places, from {low} to {high} mm along the axis")
    if results.layout.symmetry:
        found.append("Mirrored in the symmetry plane, too")
    return found

"""The data of the 3-D view: all states of the skin, small enough to stand in the page."""

from __future__ import annotations

import base64
import gzip
from typing import TYPE_CHECKING

import numpy as np

from softact.report import headline, labels
from softact.report.obstacles import COLOUR, Body, bodies
from softact.report.place import Places, called
from softact.report.solid import solid
from softact.report.surface import Skin, drawn, mirrored, skin
from softact.report.view import STRESS_COLOURS, bending_view, colour_range
from softact.results.folder import Results, load, load_name, load_text
from softact.verdict.reached import moving_rows, unstable_rows

if TYPE_CHECKING:
    from softact.results.folder import Results

_MOST_STATES, _LEAST_STATES = 40, 12
_MOST_PLACES = 500_000  # of nodes in all states: 2.2 MB of the page, with three fields
_MOST_TRIANGLES = 45_000
_STEPS = 16383  # of a coordinate; 0.012 mm on an actuator of 200 mm


def pack(results: Results, parts: Skin | None = None) -> dict:
    """Header and data of the 3-D view, for report.js. parts: the ``skin``, where it is known.

    The data are base64 of gzip of, one after the other and little-endian, with ``delta`` for the
    difference to the entry before along an axis:

    - triangles, outer ones (a) and then inner ones (b): delta of (3, a + b), uint32;
    - tets: delta of (4, t), uint32; places in the fields that are above the colour range, (p,)
      uint32, and the values there, (p,) float32;
    - coordinates in steps of ``scale`` mm from ``low``: delta by state and by vertex of (state,
      xyz, vertex), uint16 with their sign in the lowest bit, all low bytes and then all high ones;
    - fields in 1/255 of the colour range: delta by state of (field, state, vertex), uint8;
    - of each vertex the numbers of its region and of its surface, 255 for none, and whether the
      next is a copy of it, uint8.

    Differences of smooth motions are small numbers, which gzip packs three times as tight.
    """
    if parts is None or len(parts.outer) > _MOST_TRIANGLES:
        parts = skin(results, most=_MOST_TRIANGLES)
    used, where = np.unique(np.vstack([parts.outer, parts.inner]), return_inverse=True)
    triangles, nodes = where.reshape(-1, 3), parts.nodes[used]
    inside = solid(results, nodes)
    nodes = np.concatenate([nodes, inside.nodes])
    numbers = _states(results, len(nodes))
    places = np.array([_place(results, number, nodes) for number in numbers])
    low = places.min(axis=(0, 1))
    scale = max(float((places.max(axis=(0, 1)) - low).max()) / _STEPS, 1e-12)
    steps = np.round((places - low) / scale).astype(np.uint16).transpose(0, 2, 1)
    outer_nodes = parts.nodes[np.unique(parts.outer)]
    names = [name for name in labels.FIELDS if name in results.field_names(-1)]
    fields, shades, peaks = [], [], []
    for name in names:
        bottom, top, largest = colour_range(results, name, outer_nodes)
        label = labels.FIELDS[name]
        fields.append({
            "label": str(label), "name": label.name, "unit": label.unit,
            "low": bottom, "high": top, "largest": largest,
        })  # fmt: skip
        values = np.array([_values(results, number, name, nodes, bottom) for number in numbers])
        shades.append(_shades(values, bottom, top))
        peaks.append(np.where(values > top, values, 0.0).ravel())
    high = np.concatenate(peaks) if peaks else np.zeros(0)
    above = np.flatnonzero(high)
    where_on = Places(results)
    surfaces = [name for name in where_on.surfaces if name not in results.layout.symmetry]
    raw = b"".join((
        np.diff(triangles.T, axis=1, prepend=0).astype("<u4").tobytes(),
        np.diff(inside.tets.T, axis=1, prepend=0).astype("<u4").tobytes(),
        above.astype("<u4").tobytes(),
        high[above].astype("<f4").tobytes(),
        _small(steps),
        np.diff(np.array(shades, np.uint8), axis=1, prepend=np.uint8(0)).tobytes()
        if names else b"",
        where_on.regions[nodes].tobytes(),
        _surface_of(where_on, surfaces, nodes, triangles).tobytes(),
        (np.diff(nodes, append=-1) == 0).tobytes(),
    ))  # fmt: skip
    box = _box(places, parts)
    return {
        "vertices": len(nodes),
        "outer": len(parts.outer),
        "inner": len(parts.inner),
        "pieces": 4 if np.isin(parts.nodes, results.cells[:, 4:]).any() else 1,
        "tets": len(inside.tets),
        "peaks": len(above),
        "regions": [name.replace("_", " ") for name in results.region_names],
        "surfaces": [called(results.layout, name) for name in surfaces],
        "mirrors": list(parts.mirrors),
        "low": low.tolist(),
        "scale": scale,
        "states": [_caption(results, number) for number in numbers],
        "fields": fields,
        "colours": STRESS_COLOURS,
        "box": box.T.tolist(),
        "bodies": [_obstacle(body, numbers) for body in bodies(results, *box)],
        "held": _held(results, nodes),
        "camera": _camera(results),
        "data": base64.b64encode(gzip.compress(raw, 6, mtime=0)).decode(),
    }


def _small(steps: np.ndarray) -> bytes:
    """Coordinates (state, xyz, vertex) uint16 as ``pack`` says."""
    change = np.diff(steps, axis=0, prepend=np.uint16(0))
    change = np.diff(change, axis=2, prepend=np.uint16(0)).astype(np.int16)
    signed = ((change << 1) ^ (change >> 15)).astype("<u2")
    return np.ascontiguousarray(signed.view(np.uint8).reshape(-1, 2).T).tobytes()


def _surface_of(
    where: Places, surfaces: list[str], nodes: np.ndarray, triangles: np.ndarray
) -> np.ndarray:
    """(v,) number of the surface of each vertex, that of one of its triangles; 255 for none."""
    found = np.full(len(nodes), 255, np.uint8)
    for number, name in enumerate(surfaces):
        whole = where.surfaces[name][nodes[triangles]].all(axis=1)
        found[triangles[whole]] = number
    return found


def _held(results: Results, nodes: np.ndarray) -> list[dict]:
    """The surfaces with supports: their names, and their outlines as pairs of vertices, one after
    the other."""
    vertex = np.full(len(results.points), -1)
    vertex[nodes] = np.arange(len(nodes))
    found = []
    for name in _supported(results):
        faces = results.surfaces.get(name)
        if faces is not None and faces.shape[1] >= 3:
            pairs = vertex[_outline(results, faces)]
            pairs = pairs[(pairs >= 0).all(axis=1)]
            found.append({"name": called(results.layout, name), "pairs": pairs.ravel().tolist()})
    return [each for each in found if each["pairs"]]


def _supported(results: Results) -> list[str]:
    """Names of the surfaces that are held, but for symmetry planes, in the spec's order."""
    spec = results.spec
    steps = [step for step in spec.get("steps") or [] if isinstance(step, dict)]
    given = [spec.get("supports"), *(step.get("supports") for step in steps)]
    names = [support.get("surface") for some in given for support in some or []]
    return [name for name in dict.fromkeys(names) if name not in results.layout.symmetry]


def _outline(results: Results, faces: np.ndarray) -> np.ndarray:
    """(e, 2) nodes of the pieces of the edges that only one of the faces has; those in a symmetry
    plane, which are cuts, are left out."""
    sides = ((0, 3, 1), (1, 4, 2), (2, 5, 0)) if faces.shape[1] == 6 else ((0, 1), (1, 2), (2, 0))
    edges = np.vstack([faces[:, side] for side in sides])
    ends = np.sort(edges[:, [0, -1]], axis=1)
    _, first, count = np.unique(ends, axis=0, return_index=True, return_counts=True)
    border = edges[first[count == 1]]
    size = np.ptp(results.points, axis=0).max()
    for axis in results.layout.symmetry.values():
        border = border[(np.abs(results.points[border, axis]) > 1e-6 * size).any(axis=1)]
    return np.vstack([border[:, n : n + 2] for n in range(border.shape[1] - 1)])


def _obstacle(body: Body, numbers: list[int]) -> dict:
    """An obstacle for report.js: its surface, and its motion from state to state."""
    points, triangles = np.round(body.points, 4).T, body.triangles.T
    return {
        **dict(zip("xyz", points.tolist(), strict=True)),
        **dict(zip("ijk", triangles.tolist(), strict=True)),
        "middle": body.middle.tolist(),
        "shift": [(body.shift[n] if n >= 0 else np.zeros(3)).tolist() for n in numbers],
        "turn": [np.round(body.turned(n), 6).tolist() for n in numbers],
        "there": [body.seen(n) for n in numbers],
        "colour": COLOUR,
    }


def _states(results: Results, nodes: int) -> list[int]:
    """The undeformed state (-1) and the others, evenly thinned where there are many, or many
    nodes."""
    count = len(results.increments)
    most = min(count, max(_LEAST_STATES, min(_MOST_STATES, _MOST_PLACES // nodes)))
    chosen = np.unique(np.linspace(0, count - 1, most).round().astype(int))
    begins_at_rest = not results.field(0, "displacement").any()
    return [*([] if begins_at_rest else [-1]), *chosen.tolist()]


def _place(results: Results, number: int, nodes: np.ndarray) -> np.ndarray:
    moved = np.zeros_like(results.points) if number < 0 else results.field(number, "displacement")
    return drawn(results, moved)[nodes]


def _values(
    results: Results, number: int, name: str, nodes: np.ndarray, bottom: float
) -> np.ndarray:
    """(v,) of a field; the undeformed state and what is not known have the lowest value."""
    if number < 0:
        return np.full(len(nodes), bottom)
    return np.nan_to_num(results.field(number, name)[nodes], nan=bottom)


def _shades(values: np.ndarray, bottom: float, top: float) -> np.ndarray:
    return np.round(np.clip((values - bottom) / (top - bottom), 0, 1) * 255).astype(np.uint8)


def _caption(results: Results, number: int) -> str:
    """What the slider says of a state."""
    if number < 0:
        return "undeformed"
    name = load_name(results)
    said = [load_text(results, number)]
    if name:
        said = [f"{labels.number(load(results)[number])} {labels.column(name).unit}".strip()]
    said += [headline.state_text(results, number)]
    stress = "max_principal_stress_MPa"
    if stress in results.curve and np.isfinite(results.curve[stress][number]):
        said.append(headline.figure(results, stress, number).text)
    said = list(dict.fromkeys(filter(None, said)))
    steps = results.curve.get("step", ())
    if name and len(set(steps)) > 1:
        said.insert(0, str(steps[number]))
    if unstable_rows(results)[number]:
        said.append("not stable")
    if moving_rows(results)[number]:
        said.append("in motion, no equilibrium")
    return " · ".join(said)


def _box(places: np.ndarray, parts: Skin) -> np.ndarray:
    """(2, 3) mm: lowest and highest coordinates of the whole actuator in all states."""
    corners = np.vstack([places.min(axis=1), places.max(axis=1)])
    whole, _ = mirrored(corners, np.zeros((0, 3), int), parts.mirrors)
    low, high = whole.min(axis=0), whole.max(axis=0)
    margin = 0.03 * (high - low).max()
    return np.array([low - margin, high + margin])


def _camera(results: Results) -> dict:
    view = bending_view(results)
    up = np.eye(3)[np.argmax(np.abs(view.up))] * np.sign(view.up[np.argmax(np.abs(view.up))])
    return {"eye": view.eye.tolist(), "up": up.tolist()}

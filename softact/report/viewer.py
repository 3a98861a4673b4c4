"""The data of the 3-D view: all states of the skin, small enough to stand in the page."""

from __future__ import annotations

import base64
import gzip
from typing import TYPE_CHECKING

import numpy as np

from softact.report import headline, labels
from softact.report.obstacles import COLOUR, Body, bodies
from softact.report.surface import Skin, drawn, mirrored, skin
from softact.report.view import STRESS_COLOURS, bending_view, colour_range
from softact.results.folder import Results, load, load_name, load_text
from softact.verdict.reached import moving_rows, unstable_rows

if TYPE_CHECKING:
    from softact.results.folder import Results

_MOST_STATES = 40
_MOST_TRIANGLES = 45_000
_STEPS = 65535  # of a coordinate; 0.003 mm on an actuator of 200 mm


def pack(results: Results, parts: Skin | None = None) -> dict:
    """Header and data of the 3-D view, for report.js. parts: the ``skin``, where it is known.

    The data are base64 of gzip of, one after the other and little-endian: outer triangles
    (a, 3) and inner ones (b, 3) as uint32; places (state, xyz, vertex) as uint16 differences to
    the state before, in steps of ``scale`` mm from ``low``; fields (field, state, vertex) as
    uint8 differences to the state before, in 1/255 of the colour range. Differences of smooth
    motions are small numbers, which gzip packs three times as tight.
    """
    if parts is None or len(parts.outer) > _MOST_TRIANGLES:
        parts = skin(results, most=_MOST_TRIANGLES)
    used, where = np.unique(np.vstack([parts.outer, parts.inner]), return_inverse=True)
    triangles, nodes = where.reshape(-1, 3), parts.nodes[used]
    numbers = _states(results)
    places = np.array([_place(results, number, nodes) for number in numbers])
    low = places.min(axis=(0, 1))
    scale = max(float((places.max(axis=(0, 1)) - low).max()) / _STEPS, 1e-12)
    steps = np.round((places - low) / scale).astype(np.uint16).transpose(0, 2, 1)
    outer_nodes = parts.nodes[np.unique(parts.outer)]
    names = [name for name in labels.FIELDS if name in results.field_names(-1)]
    fields, values = [], []
    for name in names:
        bottom, top, largest = colour_range(results, name, outer_nodes)
        label = labels.FIELDS[name]
        fields.append({
            "label": str(label), "name": label.name, "unit": label.unit,
            "low": bottom, "high": top, "largest": largest,
        })  # fmt: skip
        values.append([_shade(results, number, name, nodes, bottom, top) for number in numbers])
    raw = b"".join((
        triangles.astype("<u4").tobytes(),
        np.diff(steps, axis=0, prepend=np.uint16(0)).astype("<u2").tobytes(),
        np.diff(np.array(values, np.uint8), axis=1, prepend=np.uint8(0)).tobytes()
        if names else b"",
    ))  # fmt: skip
    box = _box(places, parts)
    return {
        "vertices": len(nodes),
        "outer": len(parts.outer),
        "inner": len(parts.inner),
        "mirrors": list(parts.mirrors),
        "low": low.tolist(),
        "scale": scale,
        "states": [_caption(results, number) for number in numbers],
        "fields": fields,
        "colours": STRESS_COLOURS,
        "box": box.T.tolist(),
        "bodies": [_obstacle(body, numbers) for body in bodies(results, *box)],
        "camera": _camera(results),
        "data": base64.b64encode(gzip.compress(raw, 6, mtime=0)).decode(),
    }


def _obstacle(body: Body, numbers: list[int]) -> dict:
    """An obstacle for report.js: its surface, and its motion from state to state."""
    points, triangles = np.round(body.points, 4).T, body.triangles.T
    return {
        **dict(zip("xyz", points.tolist(), strict=True)),
        **dict(zip("ijk", triangles.tolist(), strict=True)),
        "shift": [(body.shift[n] if n >= 0 else np.zeros(3)).tolist() for n in numbers],
        "there": [body.seen(n) for n in numbers],
        "colour": COLOUR,
    }


def _states(results: Results) -> list[int]:
    """The undeformed state (-1) and the others, evenly thinned where there are many."""
    count = len(results.increments)
    chosen = np.unique(np.linspace(0, count - 1, min(count, _MOST_STATES)).round().astype(int))
    begins_at_rest = not results.field(0, "displacement").any()
    return [*([] if begins_at_rest else [-1]), *chosen.tolist()]


def _place(results: Results, number: int, nodes: np.ndarray) -> np.ndarray:
    moved = np.zeros_like(results.points) if number < 0 else results.field(number, "displacement")
    return drawn(results, moved)[nodes]


def _shade(
    results: Results, number: int, name: str, nodes: np.ndarray, bottom: float, top: float
) -> np.ndarray:
    if number < 0:
        return np.zeros(len(nodes), np.uint8)
    values = np.nan_to_num(results.field(number, name)[nodes], nan=bottom)
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

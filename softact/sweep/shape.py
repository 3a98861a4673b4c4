"""The last state of a run as a small packed skin, for pages that show many of them."""

from __future__ import annotations

import base64
import gzip
import json
from pathlib import Path

import numpy as np

from softact.files.text import write_atomic
from softact.report import labels
from softact.report.surface import mirrored, skin
from softact.report.view import bending_view, colour_range
from softact.results.folder import Results

SHAPE = "shape.json"
_MOST_TRIANGLES = 6000
_STEPS = 65535


def pack(results: Results) -> dict:
    """The outside of the whole actuator in its last state.

    data: base64 of gzip of, one after the other and little-endian: triangles (t, 3) uint16 or
    uint32 (``wide``), places (3, v) uint16 in steps of ``scale`` mm from ``low``, and the field
    (v,) uint8 in 1/255 of ``range``. eye, up: where to look from.
    """
    parts = skin(results, most=_MOST_TRIANGLES)
    used, where = np.unique(parts.outer, return_inverse=True)
    nodes, triangles = parts.nodes[used], where.reshape(-1, 3)
    last = len(results.increments) - 1
    places = results.points[nodes] + results.field(last, "displacement")[nodes]
    name = next((n for n in labels.FIELDS if n in results.field_names(last)), None)
    low, high = 0.0, 1.0
    shade: np.ndarray = np.zeros(len(nodes))
    if name:
        low, high, _ = colour_range(results, name, nodes)
        shade = np.clip((results.scalar(last, name)[nodes] - low) / (high - low), 0, 1)
    places, triangles = mirrored(places, triangles, parts.mirrors)
    shade = np.tile(np.nan_to_num(shade), len(places) // len(nodes))
    origin = places.min(axis=0)
    scale = max(float(np.ptp(places, axis=0).max()) / _STEPS, 1e-12)
    wide = len(places) > _STEPS
    raw = b"".join((
        triangles.astype("<u4" if wide else "<u2").tobytes(),
        np.round((places - origin) / scale).astype("<u2").T.tobytes(),
        np.round(shade * 255).astype(np.uint8).tobytes(),
    ))  # fmt: skip
    view = bending_view(results)
    return {
        "vertices": len(places), "triangles": len(triangles), "wide": wide,
        "low": origin.tolist(), "scale": scale, "range": [low, high],
        "field": str(labels.FIELDS[name]) if name else "",
        "eye": view.eye.tolist(), "up": view.up.tolist(),
        "data": base64.b64encode(gzip.compress(raw, 6, mtime=0)).decode(),
    }  # fmt: skip


def store(results: Results) -> None:
    """Write the packed skin into the result folder; a run without a state has none."""
    if results.increments:
        write_atomic(results.directory / SHAPE, json.dumps(pack(results)))


def load(directory: Path) -> dict | None:
    """The packed skin of a run, None where it has none."""
    try:
        return json.loads((directory / SHAPE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None

"""The page of a preview: the model in 3-D, cut open or whole, and what can be said of it."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Iterator
from typing import Any

import numpy as np
from markupsafe import Markup

from softact.preview.drawing import Drawing, Patch
from softact.preview.look import Preview
from softact.preview.words import rows
from softact.report import base
from softact.report.base import Section

#: Triangles up to which the edges of elements are drawn at first.
_EDGES_SHOWN = 30_000


def html(preview: Preview) -> str:
    """The text of the page: one file that needs no other."""
    drawn = preview.drawing
    sections = [
        Section("view", "The model"),
        *([Section("figures", "Figures", _table(preview))] if preview.figures else []),
        Section("parts", preview.heads[0], _parts(preview)),
        *([Section("steps", "Steps", _steps(preview))] if preview.steps else []),
    ]
    return base.page(
        preview.name,
        sections,
        kicker="Preview: nothing is solved yet",
        kind="preview",
        data={"view": packed(drawn)},
        template="preview/preview.html",
        about=preview.about,
        notes=preview.notes,
        cut=drawn.cut,
    )


def _table(preview: Preview) -> Markup:
    return base.table(["Figure", "Value"], [list(row) for row in rows(preview)])


def _parts(preview: Preview) -> Markup:
    said = {p.name: p.said for p in preview.drawing.patches if p.label or p.said}
    return base.table(list(preview.heads[1:]), [list(item) for item in said.items()])


def _steps(preview: Preview) -> Markup:
    return base.table(["Step", "Loads at its end"], [list(step) for step in preview.steps])


def packed(drawn: Drawing) -> dict[str, Any]:
    """Header and data for preview.js: base64 of gzip of the points (n, 3) as float32, then the
    corners of each patch as uint32."""
    corners = [np.ascontiguousarray(patch.corners, "<u4") for patch in drawn.patches]
    raw = drawn.points.astype("<f4").tobytes() + b"".join(c.tobytes() for c in corners)
    low, high = drawn.points.min(axis=0), drawn.points.max(axis=0)
    margin = 0.05 * float((high - low).max())
    triangles = sum(len(c) for c in corners if c.shape[1] == 3)
    return {
        "points": len(drawn.points),
        "patches": list(_headers(drawn)),
        "box": np.column_stack([low - margin, high + margin]).tolist(),
        "camera": {"eye": eye(drawn).tolist(), "up": [0, 0, 1]},
        "edges": triangles < _EDGES_SHOWN,
        "both": len({p.seen for p in drawn.patches} - {""}) > 1,
        "data": base64.b64encode(gzip.compress(raw, 6, mtime=0)).decode(),
    }


def _headers(drawn: Drawing) -> Iterator[dict[str, Any]]:
    for patch in drawn.patches:
        yield {
            "name": patch.name, "said": patch.said, "colour": patch.colour, "seen": patch.seen,
            "count": len(patch.corners), "corners": patch.corners.shape[1],
            "label": place(drawn.points, patch).tolist() if patch.label else None,
            "opacity": patch.opacity,
        }  # fmt: skip


def place(points: np.ndarray, patch: Patch) -> np.ndarray:
    """Where the label of a patch stands: at the triangle that is nearest to its middle."""
    middles = points[patch.corners].mean(axis=1)
    return middles[np.argmin(np.linalg.norm(middles - middles.mean(axis=0), axis=1))]


def eye(drawn: Drawing) -> np.ndarray:
    """The direction to the eye, a unit vector: from the side that is cut open."""
    level = -0.45 if 2 in drawn.closed else 0.45
    found = np.array([-0.45, -0.9, level])
    return found / np.linalg.norm(found)

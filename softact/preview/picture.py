"""The picture of a preview: cut open, its parts in colours, with their names and the figures."""

from __future__ import annotations

import math
from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from softact.preview import page
from softact.preview.drawing import Drawing, Patch
from softact.preview.look import Preview
from softact.preview.words import rows
from softact.report import frames
from softact.report.pictures import INK
from softact.report.view import View

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_DPI, _INCHES, _MARGIN = 150, 7.0, 0.05
_LETTERS = 54  # of a line beside the picture


@dataclass(frozen=True)
class Picture:
    """What ``frames.Renderer`` draws of a preview: one state, each patch in one colour."""

    drawing: Drawing
    view: View
    low: np.ndarray
    high: np.ndarray

    @property
    def size(self) -> tuple[int, int]:
        """Pixels."""
        mm = (self.high - self.low).max() / (_INCHES * _DPI)
        wide, tall = (2 * math.ceil(side / mm / 2) for side in self.high - self.low)
        return wide, tall

    def job(self) -> dict[str, np.ndarray]:
        """Arrays for ``render.py``."""
        solid = [p for p in _patches(self.drawing) if p.corners.shape[1] == 3]
        plain = [p for p in solid if p.opacity == 1] or solid
        bodies = [p for p in solid if p.opacity < 1] if plain is not solid else []
        points, values = _apart(self.drawing.points, plain)
        body_points, _ = _apart(self.drawing.points, bodies)
        triangles, body_triangles = (
            np.arange(len(p)).reshape(-1, 3) for p in (points, body_points)
        )
        edges = [triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]
        lines = [p.corners for p in _patches(self.drawing) if p.corners.shape[1] == 2]
        loose = np.vstack(lines) if lines else np.zeros((0, 2), int)
        ends = self.drawing.points[loose.ravel()]
        edges.append(np.arange(len(ends)).reshape(-1, 2) + len(points))
        points = np.vstack([points, ends])
        values = np.append(values, np.zeros(len(ends)))
        return {
            "points": points[None], "values": values[None], "triangles": triangles,
            "edges": np.vstack(edges), "ghost": np.zeros((0, 3)),
            "bodies": body_points[None], "body_triangles": body_triangles,
            "limits": np.array([0.0, max(len(plain) - 1, 1)]),
            "colours": np.array([_rgb(p.colour) for p in plain]),
            "right": self.view.right, "up": self.view.up, "eye": self.view.eye,
            "low": self.low, "high": self.high, "size": np.array(self.size),
        }  # fmt: skip


def png(preview: Preview) -> bytes:
    """The picture. Raises DrawingError where it cannot be drawn."""
    drawing = preview.drawing
    eye = page.eye(drawing)
    right = np.cross((0.0, 0.0, 1.0), eye)
    right /= np.linalg.norm(right)
    view = View(right, np.cross(eye, right), eye)
    used = np.unique(np.concatenate([p.corners.ravel() for p in _patches(drawing)]))
    flat = view.project(drawing.points[used])
    margin = _MARGIN * np.ptp(flat, axis=0).max()
    picture = Picture(drawing, view, flat.min(axis=0) - margin, flat.max(axis=0) + margin)
    with frames.renderer() as renderer:
        renderer.draw(picture.job())
        (panels,) = renderer.drawn()
    return _composed(preview, picture, panels[0])


def _patches(drawing: Drawing) -> list[Patch]:
    return drawing.seen("open")


def _apart(points: np.ndarray, patches: list[Patch]) -> tuple[np.ndarray, np.ndarray]:
    """The corners (3 k, 3) of all triangles and the number of the patch at each: none is shared,
    so that each triangle has its own colour and looks flat."""
    found = [points[patch.corners].reshape(-1, 3) for patch in patches]
    values = [np.full(len(some), float(number)) for number, some in enumerate(found)]
    return np.vstack([np.zeros((0, 3)), *found]), np.concatenate([np.zeros(0), *values])


def _rgb(colour: str) -> tuple[float, ...]:
    return tuple(int(colour[n : n + 2], 16) / 255 for n in (1, 3, 5))


def _composed(preview: Preview, picture: Picture, panel: np.ndarray) -> bytes:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    wide, tall = np.array(picture.size) / _DPI
    words = list(_words(preview))
    size = wide + 4.4, max(tall, 0.19 * len(words) + 0.6)
    figure = Figure(figsize=size, dpi=_DPI, facecolor="white")
    FigureCanvasAgg(figure)
    bottom = (size[1] - tall) / 2
    figure.figimage(panel, 0, round(bottom * _DPI), origin="upper")
    _labels(figure, preview.drawing, picture, bottom, size)
    top = size[1] - 0.3
    for colour, text in words:
        at = (wide + 0.3) / size[0], top / size[1]
        if colour:
            figure.text(*at, "\u25a0", color=colour, fontsize=11, va="center")
        figure.text(at[0] + (0.2 / size[0] if colour is not None else 0), at[1], text, color=INK,
                    fontsize=8.5, va="center")  # fmt: skip
        top -= 0.19
    out = BytesIO()
    figure.savefig(out, format="png", pil_kwargs={"compress_level": 4})
    return out.getvalue()


def _labels(
    figure: Figure, drawing: Drawing, picture: Picture, bottom: float, size: tuple[float, float]
) -> None:
    mm = (picture.high - picture.low).max() / _INCHES  # of an inch
    for patch in _patches(drawing):
        if not patch.label:
            continue
        place = picture.view.project(page.place(drawing.points, patch)[None])[0]
        x, y = (place - picture.low) / mm
        figure.text(
            x / size[0], (bottom + y) / size[1], patch.name, fontsize=8, color=INK, ha="center",
            va="center", bbox={"boxstyle": "round,pad=0.15", "fc": "white", "ec": patch.colour,
                               "alpha": 0.8, "lw": 1.0},
        )  # fmt: skip


def _words(preview: Preview) -> list[tuple[str | None, str]]:
    """Colour and text of each line beside the picture; None: no colour, "": a line that goes on."""
    lines: list[tuple[str | None, str]] = [(None, preview.name)]
    for patch in {p.name: p for p in _patches(preview.drawing) if p.label or p.said}.values():
        text = patch.name + (f": {patch.said}" if patch.said else "")
        first, *more = _broken(text)
        lines += [(patch.colour, first), *(("", line) for line in more)]
    for name, value in rows(preview):
        lines += [(None, line) for line in _broken(f"{name}: {value}")]
    if preview.drawing.cut:
        lines += [(None, line) for line in _broken(preview.drawing.cut)]
    return lines


def _broken(text: str) -> list[str]:
    import textwrap

    return textwrap.wrap(text, _LETTERS) or [""]

"""Small pictures of hot spots: what ``render.py`` is to draw of each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from softact.report.frames import Scene, colours
from softact.report.hot_spots import HotSpot
from softact.report.view import STRESS_COLOURS, colour_range
from softact.verdict.reached import reached

_PIXELS = 220
_PART = 0.16  # of the actuator's size: the side of a picture
_TILT = 0.35  # of the direction that sees the whole actuator best, added to the surface's normal
_CLEAR = 0.7  # of the way to what stands before the place: there it is cut


def jobs(scene: Scene, spots: Sequence[HotSpot]) -> Iterator[dict[str, np.ndarray]]:
    """Arrays for ``render.py`` of each spot's picture, of the meshed part alone."""
    row = reached(scene.results).main
    if row is None or not spots:
        return
    points = scene.points(row)
    triangles = np.vstack([scene.skin.outer, scene.skin.inner])
    size = np.ptp(points, axis=0).max()
    for spot in spots:
        low, _, _ = colour_range(scene.results, spot.field, scene.skin.nodes)
        values = scene.results.scalar(row, spot.field)[scene.skin.nodes]
        right, up, eye = _directions(scene, points, triangles, spot.node)
        half = _PART * size / 2
        middle = np.array([spot.now @ right, spot.now @ up])
        front = min(half, _CLEAR * _room(points, triangles, spot.now, eye, size))
        yield {
            "bodies": np.zeros((1, 0, 3)), "body_triangles": np.zeros((0, 3), int),
            "points": points[None], "values": values[None], "triangles": triangles,
            "edges": scene.skin.edges, "ghost": np.zeros((0, 3)),
            "limits": np.array([low, max(spot.values[spot.field], low + 1e-12)]),
            "colours": colours(STRESS_COLOURS), "right": right, "up": up, "eye": eye,
            "low": middle - half, "high": middle + half, "size": np.array([_PIXELS, _PIXELS]),
            "front": np.array(spot.now @ eye + front),
        }  # fmt: skip


def _directions(
    scene: Scene, points: np.ndarray, triangles: np.ndarray, node: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit vectors to the right, up, and to the eye: nearly along the surface's normal at a node,
    out of the material."""
    own = np.isin(scene.skin.nodes[triangles], node).any(axis=1)
    a, b, c = (points[triangles[own][:, n]] for n in range(3))
    normal = np.cross(b - a, c - a).sum(axis=0) if own.any() else scene.view.eye
    length = float(np.linalg.norm(normal))
    normal = normal / length if length > 0 else scene.view.eye
    toward = scene.view.eye if normal @ scene.view.eye > -0.5 else -scene.view.eye
    eye = normal + _TILT * toward
    eye /= np.linalg.norm(eye)
    up = scene.view.up - (scene.view.up @ eye) * eye
    if np.linalg.norm(up) < 0.2:
        up = scene.view.right - (scene.view.right @ eye) * eye
    up /= np.linalg.norm(up)
    return np.cross(up, eye), up, eye


def _room(
    points: np.ndarray, triangles: np.ndarray, place: np.ndarray, eye: np.ndarray, size: float
) -> float:
    """mm from a place to the first triangle towards the eye (Möller and Trumbore 1997)."""
    start = place + 1e-3 * size * eye
    a, b, c = (points[triangles[:, n]] for n in range(3))
    one, two, far = b - a, c - a, start - a
    across = np.cross(eye, two)
    volume = (one * across).sum(axis=1)
    volume[np.abs(volume) < 1e-12 * size**2] = np.nan
    u = (far * across).sum(axis=1) / volume
    turned = np.cross(far, one)
    v, way = turned @ eye / volume, (two * turned).sum(axis=1) / volume
    hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (way > 0)
    return float(way[hit].min(initial=size)) + 1e-3 * size

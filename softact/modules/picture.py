"""A picture of a chain of modules: one that was solved, and its images."""

from __future__ import annotations

from io import BytesIO

import numpy as np

from softact.report import frames, labels
from softact.report.frames import Scene
from softact.report.view import STRESS_COLOURS
from softact.results.folder import Results
from softact.system.rotation import RotationVector

MOST_DRAWN, PIXELS, DPI = 24, 1100.0, 160


def motion(results: Results, number: int) -> tuple[np.ndarray, np.ndarray]:
    """The rotation R (3, 3) and shift d (3,) mm that make of a module the next one: x -> R x + d.
    Of state ``number``, from the columns of the curve."""
    curve, length = results.curve, results.layout.length

    def vector(title: str, default: float) -> np.ndarray:
        return np.array(
            [float(curve[title.format(c)][number]) if title.format(c) in curve else default
             for c in "xyz"]
        )  # fmt: skip

    turn = np.radians(vector("module_angle_{}_deg", 0.0))
    stretched = length * vector("module_stretch_{}", 0.0)
    rotation = RotationVector(turn).matrix
    centre = _middle(results, results.layout.clamp)
    shift = centre + RotationVector(turn, integral=True).matrix @ stretched - rotation @ centre
    return rotation, shift


def _middle(results: Results, surface: str) -> np.ndarray:
    """Middle (3,) of an undeformed surface of the meshed part, mm."""
    a, b, c = (results.points[results.surfaces[surface][:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return area @ (a + b + c) / 3 / area.sum()


def chain(results: Results, number: int, modules: int) -> bytes:
    """PNG of ``modules`` modules in state ``number``, coloured by stress. Raises DrawingError."""
    scene = frames.make_scene(results)
    job = scene.job(scene.group([number], ghost=False, pixels=PIXELS))
    rotation, shift = motion(results, number)
    images = [job["points"][0]]
    for _ in range(modules - 1):
        images.append(images[-1] @ rotation.T + shift)
    count = len(images[0])
    job["points"] = np.concatenate(images)[np.newaxis]
    for name in ("triangles", "edges"):
        job[name] = np.concatenate([job[name] + k * count for k in range(modules)])
    job["values"] = np.tile(job["values"], modules)
    _frame(job)
    with frames.renderer() as renderer:
        renderer.draw(job)
        (drawn,) = renderer.drawn()
    return _composed(scene, drawn[0])


def _frame(job: dict[str, np.ndarray]) -> None:
    """Let the frame hold all points."""
    flat = job["points"][0] @ np.stack([job["right"], job["up"]], axis=1)
    margin = 0.04 * np.ptp(flat, axis=0).max()
    low, high = flat.min(axis=0) - margin, flat.max(axis=0) + margin
    mm = (high - low).max() / PIXELS
    size = 2 * np.ceil((high - low) / mm / 2).astype(int)
    middle = (low + high) / 2
    job |= {"low": middle - size * mm / 2, "high": middle + size * mm / 2, "size": size}


def _composed(scene: Scene, picture: np.ndarray) -> bytes:
    """PNG of a picture with the bar of its colours."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap, Normalize
    from matplotlib.figure import Figure

    high, wide = np.array(picture.shape[:2]) / DPI
    width, height = wide + 1.5, max(high, 3.0)
    figure = Figure(figsize=(width, height), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 1 - high / height, wide / width, high / height))
    axes.imshow(picture, interpolation="nearest")
    axes.set_axis_off()
    bar = figure.add_axes(((wide + 0.3) / width, 0.15, 0.15 / width, 0.7))
    colours = LinearSegmentedColormap.from_list("stress", STRESS_COLOURS)
    mappable = ScalarMappable(Normalize(*scene.limits), colours)
    figure.colorbar(mappable, cax=bar, label=str(labels.field(scene.field)))
    data = BytesIO()
    figure.savefig(data, format="png")
    return data.getvalue()

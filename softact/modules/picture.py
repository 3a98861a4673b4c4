"""A picture of a chain of modules: one that was solved, and its images."""

from __future__ import annotations

from io import BytesIO

import numpy as np
from scipy.spatial import cKDTree

from softact.report import frames, labels
from softact.report.frames import Scene
from softact.report.view import STRESS_COLOURS
from softact.results.folder import Results
from softact.system.rotation import RotationVector

MOST_DRAWN, PIXELS, DPI = 24, 1100.0, 160
SAME = 1e-6  # of the pitch


def motion(results: Results, number: int) -> tuple[np.ndarray, np.ndarray]:
    """The rotation R (3, 3) and shift d (3,) mm that make of a module the next one: x -> R x + d.
    Of state ``number``, from its columns and from where its two faces are."""
    curve, layout = results.curve, results.layout
    columns = [f"module_angle_{c}_deg" for c in "xyz"]
    turn = np.radians([float(curve[n][number]) if n in curve else 0.0 for n in columns])
    rotation = RotationVector(turn).matrix
    axis, points = np.array(layout.axis), results.points
    along, near = points @ axis, SAME * layout.length
    left = np.flatnonzero(along < along.min() + near)
    right = np.flatnonzero(along > along.max() - near)
    partner = cKDTree(points[right]).query(points[left] + layout.length * axis)[1]
    moved = points + results.field(number, "displacement")
    return rotation, (moved[right[partner]] - moved[left] @ rotation.T).mean(axis=0)


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

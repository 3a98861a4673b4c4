"""Pictures of the actuator: ``states.png`` and ``shape.png``, drawn without a display.

Run as ``python -m softact.report.pictures DIR`` in a process of its own, since a missing
graphics library can end the process that draws.
"""

import os
import subprocess
import sys
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np

from softact.report import labels
from softact.report.surface import Skin, mirrored, skin
from softact.report.view import View, bending_view, colour_range, load, load_name, states
from softact.results import Results, read, write_atomic

_PIXELS = 900  # of the longer side of a panel
_TIME_LIMIT_S = 600.0
_INK, _GREY = "#15202b", "#8a949b"


def colours() -> list[str]:
    """The colour scale of stresses, from low to high, as #rrggbb.

    Turbo (Mikhailov 2019) without its dark ends: shading must not be taken for stress.
    """
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    return [to_hex(colormaps["turbo"](value)) for value in np.linspace(0.07, 0.92, 32)]


def _colour_map():
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("stress", colours())


def draw(directory: Path) -> str:
    """Draw both pictures in another process; returns why it failed, or ""."""
    # Neither a display nor the MPI job that we may be part of is the child's business.
    mine = ("OMPI_", "PMIX_", "PMI_", "PRTE_", "DISPLAY", "WAYLAND_DISPLAY")
    environment = {k: v for k, v in os.environ.items() if not k.startswith(mine)}
    command = [sys.executable, "-m", "softact.report.pictures", str(directory)]
    try:
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=_TIME_LIMIT_S
        )
    except subprocess.TimeoutExpired:
        return f"drawing took longer than {_TIME_LIMIT_S:g} s and was given up"
    if done.returncode == 0:
        return ""
    said = [line for line in done.stderr.splitlines() if line.strip()]
    reason = said[-1] if said else "no message"
    return f"drawing ended with code {done.returncode}: {reason}"


@dataclass(frozen=True)
class _Scene:
    """All that is the same in every panel."""

    results: Results
    skin: Skin
    view: View
    field: str
    clim: tuple[float, float]

    def points(self, number: int) -> np.ndarray:
        """(v, 3) mm: vertices of the meshed part in state ``number``; -1 is undeformed."""
        at_rest = self.results.points[self.skin.nodes]
        if number < 0:
            return at_rest
        return at_rest + self.results.field(number, "displacement")[self.skin.nodes]

    def frame(self, numbers: list[int]) -> tuple[np.ndarray, np.ndarray]:
        """Lower left and upper right (mm in the picture) of all these states."""
        used = np.unique(self.skin.outer)
        flat = []
        for number in numbers:
            whole, _ = mirrored(self.points(number)[used], np.zeros((0, 3), int), self.skin.mirrors)
            flat.append(self.view.project(whole))
        flat = np.vstack(flat)
        margin = 0.04 * np.ptp(flat, axis=0).max()
        return flat.min(axis=0) - margin, flat.max(axis=0) + margin


def _scene(results: Results) -> _Scene:
    parts = skin(results)
    names = results.field_names(-1)
    field = next((name for name in labels.FIELDS if name in names), "displacement")
    low, high, _ = colour_range(results, field, parts.nodes[np.unique(parts.outer)])
    return _Scene(results, parts, bending_view(results), field, (low, high))


def _panel(scene: _Scene, number: int, low: np.ndarray, high: np.ndarray, ghost: bool):
    """RGBA picture of state ``number``, with the undeformed outline behind if ``ghost``."""
    import pyvista

    span = high - low
    width, height = np.ceil(_PIXELS * span / span.max()).astype(int)
    plotter = pyvista.Plotter(off_screen=True, window_size=(int(width), int(height)))
    plotter.enable_anti_aliasing("ssaa")
    points, triangles = mirrored(scene.points(number), scene.skin.outer, scene.skin.mirrors)
    surface = pyvista.PolyData.from_regular_faces(points, triangles)
    values = scene.results.scalar(number, scene.field)[scene.skin.nodes]
    surface[scene.field] = np.tile(values, len(points) // len(values))
    plotter.add_mesh(
        surface,
        scalars=scene.field,
        clim=scene.clim,
        cmap=_colour_map(),
        smooth_shading=True,
        show_scalar_bar=False,
        ambient=0.5,
        diffuse=0.58,
        specular=0.1,
        specular_power=20,
    )
    plotter.add_mesh(_lines(scene, number), color="#1c2a33", line_width=1.5, opacity=0.6)
    if ghost:
        plotter.add_mesh(_lines(scene, -1), color=_GREY, line_width=1.5)
    _aim(plotter, scene.view, low, high, points)
    picture = plotter.screenshot(transparent_background=True, return_img=True)
    plotter.close()
    return picture


def _lines(scene: _Scene, number: int):
    import pyvista

    points, edges = mirrored(scene.points(number), scene.skin.edges, scene.skin.mirrors)
    cells = np.column_stack([np.full(len(edges), 2), edges]).ravel()
    return pyvista.PolyData(points, lines=cells)


def _aim(plotter, view: View, low: np.ndarray, high: np.ndarray, points: np.ndarray) -> None:
    """Parallel projection whose frame is the rectangle ``low`` to ``high``."""
    middle = (low + high) / 2
    depth = points @ view.eye
    focus = middle[0] * view.right + middle[1] * view.up + depth.mean() * view.eye
    far = 10 * max(np.ptp(depth), *(high - low))
    camera = plotter.camera
    camera.focal_point, camera.position, camera.up = focus, focus + far * view.eye, view.up
    camera.parallel_projection, camera.parallel_scale = True, (high - low)[1] / 2
    camera.clipping_range = (0.1 * far, 3 * far)


def _compose(scene: _Scene, numbers: list[int], columns: int, side: float, ghost: bool) -> bytes:
    """PNG of the panels with titles, colour bar and axes; ``side`` in inches per panel."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    low, high = scene.frame([*numbers, -1] if ghost else numbers)
    inch_per_mm = side / (high - low).max()
    width, height = (high - low) * inch_per_mm
    rows = -(-len(numbers) // columns)
    legend, title = 1.5, 0.4
    size = (columns * width + legend, max(rows * (height + title) + 0.1, 3.6))
    figure = Figure(figsize=size, dpi=160, facecolor="white")
    FigureCanvasAgg(figure)

    def place(left, top, wide, tall):
        """Axes at inches from the upper left corner."""
        at = (left / size[0], 1 - (top + tall) / size[1], wide / size[0], tall / size[1])
        axes = figure.add_axes(at)
        axes.set_axis_off()
        return axes

    for number, (row, column) in zip(numbers, np.ndindex(rows, columns), strict=False):
        axes = place(column * width, row * (height + title) + title, width, height)
        picture = _panel(scene, number, low, high, ghost)
        axes.imshow(picture, extent=(low[0], high[0], low[1], high[1]), aspect="auto")
        axes.set_title(_title(scene.results, number), fontsize=11, color=_INK, pad=4)
    bar = place(columns * width + 0.3, title, 0.16, max(size[1] - title - 1.55, 1.2))
    _colour_bar(figure, bar, scene)
    cross = place(columns * width + 0.1, size[1] - 1.3, legend - 0.2, 1.2)
    note = "grey: undeformed" if ghost else ""
    _axes_cross(cross, scene.view, 1 / inch_per_mm, legend - 0.2, 1.2, note)
    out = BytesIO()
    figure.savefig(out, format="png")
    return out.getvalue()


def _title(results: Results, number: int) -> str:
    """What the reader needs of a state: its load, and how far it bends."""
    name = load_name(results)
    if name:
        label = labels.column(name)
        said = f"{labels.number(load(results)[number])} {label.unit}"
    else:
        said = f"load {labels.number(load(results)[number])}"
    if "bending_angle_deg" in results.curve:
        said += f"   ·   {results.curve['bending_angle_deg'][number]:.0f}° bending"
    return said


def _colour_bar(figure, axes, scene: _Scene) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    axes.set_axis_on()
    bar = figure.colorbar(
        ScalarMappable(Normalize(*scene.clim), _colour_map()), cax=axes, extend="max"
    )
    bar.outline.set_visible(False)
    bar.ax.tick_params(labelsize=9, color=_GREY, labelcolor=_INK)
    bar.set_label(str(labels.field(scene.field)), fontsize=10, color=_INK)


def _axes_cross(axes, view: View, mm_per_inch: float, wide: float, tall: float, note: str) -> None:
    """The three axes as arrows of a round length in mm, to the scale of the panels."""
    axes.set_xlim(0, wide * mm_per_inch)
    axes.set_ylim(0, tall * mm_per_inch)
    length = round_down(0.6 * mm_per_inch)
    start = np.array([0.35 * wide, 0.4 * tall]) * mm_per_inch
    for name, direction in zip("xyz", view.project(np.eye(3)), strict=True):
        end = start + length * direction
        axes.annotate(
            "", end, start, arrowprops={"arrowstyle": "-|>", "color": _INK, "lw": 1.2,
                                        "shrinkA": 0, "shrinkB": 0, "mutation_scale": 8},
        )  # fmt: skip
        beyond = end + 0.11 * mm_per_inch * direction / max(np.linalg.norm(direction), 0.3)
        axes.text(*beyond, name, fontsize=9, color=_INK, ha="center", va="center")
    for height, text in ((0.15, f"arrows: {length:g} mm"), (0.0, note)):
        axes.text(
            0.5 * wide * mm_per_inch, height * tall * mm_per_inch, text,
            fontsize=8.5, color=_INK, ha="center", va="bottom",
        )  # fmt: skip


def round_down(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above ``value``."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step for step in (1, 2, 5) if step * power <= value * (1 + 1e-9)) * power)


def main(directory: Path) -> None:
    """Draw ``states.png`` (four loads) and ``shape.png`` (the last state) of a result folder."""
    results = read(directory)
    scene = _scene(results)
    last = len(results.increments) - 1
    four = states(results, 4)
    write_atomic(directory / "states.png", _compose(scene, four, min(len(four), 2), 4.2, True))
    write_atomic(directory / "shape.png", _compose(scene, [last], 1, 5.5, False))


if __name__ == "__main__":
    main(Path(sys.argv[1]))

"""Pictures of the actuator: ``states.png`` and ``shape.png``."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO

import numpy as np

from softact.errors import reason
from softact.files import write_atomic
from softact.report import frames, labels
from softact.report.frames import Group, Scene
from softact.report.surface import Skin
from softact.report.view import STRESS_COLOURS, View, load, load_name, states
from softact.results import Results

INK, _GREY = "#15202b", "#8a949b"
_DPI = 160
_TITLE = 0.4  # inches above a panel
CORNER = 0, round(_TITLE * _DPI)  # pixels from the upper left corner to that of a single panel
_SIDES = 4.2, 5.5  # inches of the longer side of one of several panels, and of a single one


@contextmanager
def drawing(results: Results, make_skin: Callable[[], Skin]) -> Iterator[Callable[[], str]]:
    """Begin to draw both pictures in another process; other work can be done meanwhile.

    make_skin: gives the ``skin`` of the results. Gives a function that waits for them and writes
    ``states.png`` (four loads) and ``shape.png`` (the last state); it returns why that failed, or
    "".
    """
    with frames.renderer() as renderer:
        groups, failed = {}, ""
        try:
            scene = frames.make_scene(results, make_skin())
            four, last = states(results, 4), [len(results.increments) - 1]
            groups |= {
                "states.png": scene.group(four, ghost=True, pixels=_DPI * _SIDES[0]),
                "shape.png": scene.group(last, ghost=False, pixels=_DPI * _SIDES[1]),
            }
            for group in groups.values():
                renderer.draw(scene, group)
        except Exception as error:  # a report without pictures beats no report
            failed = reason(error)

        def write() -> str:
            composed = {}
            if failed:
                return failed
            try:
                for (name, group), panels in zip(groups.items(), renderer.drawn(), strict=True):
                    columns = min(len(group.numbers), 2)
                    composed[name] = compose(scene, group, panels, columns)
            except frames.DrawingError as error:
                return str(error)
            except Exception as error:  # as above
                return reason(error)
            for name, picture in composed.items():
                write_atomic(results.directory / name, picture)
            return ""

        yield write


def _colour_map():
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("stress", STRESS_COLOURS)


def compose(
    scene: Scene,
    group: Group,
    panels: np.ndarray,
    columns: int,
    titles: Sequence[str] | None = None,
) -> bytes:
    """PNG of the panels, pixel by pixel, with titles, colour bar and axes.

    titles: in place of those that say the load of each state.
    """
    titles = titles or [state_title(scene.results, number) for number in group.numbers]
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    width, height = np.array(group.size) / _DPI
    rows = -(-len(panels) // columns)
    legend, title = 1.5, _TITLE
    size = (columns * width + legend, max(rows * (height + title) + 0.1, 3.6))
    figure = Figure(figsize=size, dpi=_DPI, facecolor="white")
    FigureCanvasAgg(figure)

    def place(left, top, wide, tall):
        """Axes at inches from the upper left corner."""
        at = (left / size[0], 1 - (top + tall) / size[1], wide / size[0], tall / size[1])
        axes = figure.add_axes(at)
        axes.set_axis_off()
        return axes

    cells = np.ndindex(rows, columns)
    for said, panel, (row, column) in zip(titles, panels, cells, strict=False):
        left, top = column * width, row * (height + title) + title
        at = round(left * _DPI), round((size[1] - top - height) * _DPI)
        figure.figimage(panel, *at, origin="upper")
        figure.text(
            (left + width / 2) / size[0], 1 - (top - 0.06) / size[1],
            said, fontsize=11, color=INK, ha="center",
        )  # fmt: skip
    bar = place(columns * width + 0.3, title, 0.16, max(size[1] - title - 1.55, 1.2))
    _colour_bar(figure, bar, scene)
    cross = place(columns * width + 0.1, size[1] - 1.3, legend - 0.2, 1.2)
    note = "grey: undeformed" if group.ghost else ""
    mm_per_inch = (group.high - group.low)[0] / width
    _axes_cross(cross, scene.view, mm_per_inch, legend - 0.2, 1.2, note)
    out = BytesIO()
    figure.savefig(out, format="png", pil_kwargs={"compress_level": 4})
    return out.getvalue()


def state_title(results: Results, number: float) -> str:
    """What the reader needs of a state: its load, and how far it bends.

    number: of the state; with a fraction, linear between two.
    """

    def value(column: np.ndarray) -> float:
        return float(np.interp(number, np.arange(len(column)), column))

    name = load_name(results)
    if name:
        label = labels.column(name)
        said = f"{labels.number(value(load(results)))} {label.unit}"
    else:
        said = f"load {labels.number(value(load(results)))}"
    if "bending_angle_deg" in results.curve:
        said += f"   ·   {round(float(value(results.curve['bending_angle_deg'])))}° bending"
    return said


def _colour_bar(figure, axes, scene: Scene) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    axes.set_axis_on()
    bar = figure.colorbar(
        ScalarMappable(Normalize(*scene.limits), _colour_map()), cax=axes, extend="max"
    )
    bar.outline.set_visible(False)
    bar.ax.tick_params(labelsize=9, color=_GREY, labelcolor=INK)
    bar.set_label(str(labels.field(scene.field)), fontsize=10, color=INK)


def _axes_cross(axes, view: View, mm_per_inch: float, wide: float, tall: float, note: str) -> None:
    """The three axes as arrows of a round length in mm, to the scale of the panels."""
    axes.set_xlim(0, wide * mm_per_inch)
    axes.set_ylim(0, tall * mm_per_inch)
    length = round_down(0.6 * mm_per_inch)
    start = np.array([0.35 * wide, 0.4 * tall]) * mm_per_inch
    for name, direction in zip("xyz", view.project(np.eye(3)), strict=True):
        end = start + length * direction
        axes.annotate(
            "", end, start, arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 1.2,
                                        "shrinkA": 0, "shrinkB": 0, "mutation_scale": 8},
        )  # fmt: skip
        beyond = end + 0.11 * mm_per_inch * direction / max(np.linalg.norm(direction), 0.3)
        axes.text(*beyond, name, fontsize=9, color=INK, ha="center", va="center")
    for height, text in ((0.15, f"arrows: {length:g} mm"), (0.0, note)):
        axes.text(
            0.5 * wide * mm_per_inch, height * tall * mm_per_inch, text,
            fontsize=8.5, color=INK, ha="center", va="bottom",
        )  # fmt: skip


def round_down(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above ``value``."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step for step in (1, 2, 5) if step * power <= value * (1 + 1e-9)) * power)

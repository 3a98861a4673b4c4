"""Pictures of the actuator: ``states.png`` and ``shape.png``."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from io import BytesIO
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from softact.errors import reason
from softact.files.text import write_atomic
from softact.report import close_ups, frames, headline, labels
from softact.report.base.parts import webp
from softact.report.frames import Group, Scene
from softact.report.hot_spots import HotSpot
from softact.report.surface import Skin
from softact.report.view import STRESS_COLOURS, View, states
from softact.results.folder import Results, load, load_name, load_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.figure import Figure

INK, _GREY = "#15202b", "#8a949b"


class Ground(NamedTuple):
    """Colours of what a picture stands on and of its texts, those of base.css."""

    paper: str
    ink: str


LIGHT, DARK = Ground("#ffffff", INK), Ground("#12181d", "#e6ebef")
_DPI = 160
_TITLE = 0.4  # inches above a panel
MOST_STATES = 4
MARK = "#b3261e"
CORNER = 0, round(_TITLE * _DPI)  # pixels from the upper left corner to that of a single panel
_SIDES = 4.2, 5.5  # inches of the longer side of one of several panels, and of a single one


@dataclass(frozen=True)
class Drawn:
    """What came of the pictures. fault: why drawing failed, or ""; both: name of a picture -> its
    WebP on a light ground and on a dark one; spots: WebP of each hot spot, on a clear one."""

    fault: str = ""
    both: Mapping[str, tuple[bytes, bytes]] = field(default_factory=dict)
    spots: Sequence[bytes] = ()


@contextmanager
def drawing(
    results: Results,
    make_skin: Callable[[], Skin],
    spots: Sequence[HotSpot] = (),
    renderer: frames.Renderer | None = None,
) -> Iterator[Callable[..., Drawn]]:
    """Begin to draw all pictures in another process; other work can be done meanwhile.

    make_skin: gives the ``skin`` of the results. spots: to draw small. renderer: that process,
    where it is there. Gives a function that waits for them and writes ``states.png`` and
    ``shape.png``, the last of these states; it takes places (3,) mm to mark in that.
    """
    with nullcontext(renderer) if renderer else frames.renderer() as renderer:
        groups: dict[str, frames.Group] = {}
        failed = ""
        try:
            scene = frames.make_scene(results, make_skin())
            four = states(results, MOST_STATES)
            groups |= {
                "states.png": scene.group(four, ghost=True, pixels=_DPI * _SIDES[0]),
                "shape.png": scene.group(four[-1:], ghost=False, pixels=_DPI * _SIDES[1]),
            }
            for job in (*map(scene.job, groups.values()), *close_ups.jobs(scene, spots)):
                renderer.draw(job)
        except Exception as error:  # a report without pictures beats no report
            failed = reason(error)

        def write(marks: Sequence[np.ndarray] = ()) -> Drawn:
            if failed:
                return Drawn(failed)
            try:
                # Packing lets this thread work.
                with ThreadPoolExecutor(1) as beside:
                    drawn = renderer.covering()
                    packed = {
                        name: _packed(
                            beside, scene, group, panels, marks if name == "shape.png" else ()
                        )
                        for (name, group), panels in zip(groups.items(), drawn, strict=False)
                    }
                    small = [beside.submit(webp, picture[0]) for picture in drawn]
                    both = {name: (w.result(), d.result()) for name, (_, w, d) in packed.items()}
                    found = Drawn("", both, [each.result() for each in small])
                    light = {name: png.result() for name, (png, _, _) in packed.items()}
            except frames.DrawingError as error:
                return Drawn(str(error))
            except Exception as error:  # as above
                return Drawn(reason(error))
            for name, picture in light.items():
                write_atomic(results.directory / name, picture)
            return found

        yield write


def _packed(
    beside: Executor,
    scene: Scene,
    group: Group,
    panels: np.ndarray,
    marks: Sequence[np.ndarray],
) -> tuple[Future[bytes], Future[bytes], Future[bytes]]:
    """A picture as PNG on a light ground, and as WebP on that and on a dark one."""
    columns = min(len(group.numbers), 2)
    both = composed(scene, group, panels, columns, marks=marks, grounds=(LIGHT, DARK))
    light = next(both)
    first = beside.submit(_png, light), beside.submit(webp, light)
    return *first, beside.submit(webp, next(both))


def _png(picture: np.ndarray) -> bytes:
    from PIL import Image

    out = BytesIO()
    Image.fromarray(picture).save(out, format="PNG", compress_level=4)
    return out.getvalue()


def _on(panels: np.ndarray, ground: Ground) -> np.ndarray:
    """(..., 3) of panels on white with their cover, (..., 4), on another ground."""
    if ground is LIGHT:
        return panels[..., :3]
    paper = 255 * frames.colours([ground.paper])[0]
    colour, cover = np.ogrid[:256, :256]
    found = np.empty((*panels.shape[:-1], 3), np.uint8)
    for channel in range(3):
        # There are fewer pairs of a colour and a cover than pixels.
        mixed = np.clip(colour - (255.0 - cover) * (1 - paper[channel] / 255), 0, 255)
        pairs = panels[..., channel].astype(np.uint16) << 8 | panels[..., 3]
        found[..., channel] = np.round(mixed).astype(np.uint8).ravel()[pairs]
    return found


def _colour_map() -> LinearSegmentedColormap:
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("stress", STRESS_COLOURS)


def composed(
    scene: Scene,
    group: Group,
    panels: np.ndarray,
    columns: int,
    titles: Sequence[str] | None = None,
    marks: Sequence[np.ndarray] = (),
    grounds: Sequence[Ground] = (LIGHT,),
) -> Iterator[np.ndarray]:
    """On each ground (height, width, 3) uint8: the panels, pixel by pixel, with titles, colour bar
    and axes.

    titles: in place of those that say the load of each state. marks: places (3,) mm of the first
    state to put a ring around. grounds: for any but ``LIGHT`` the panels have their cover as fourth
    channel.
    """
    ground = grounds[0]
    titles = titles or [state_title(scene.results, number) for number in group.numbers]
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    width, height = np.array(group.size) / _DPI
    rows = -(-len(panels) // columns)
    legend, title = 1.5, _TITLE
    size = (columns * width + legend, max(rows * (height + title) + 0.1, 3.6))
    figure = Figure(figsize=size, dpi=_DPI, facecolor="none")
    canvas = FigureCanvasAgg(figure)
    wide, tall = map(int, canvas.get_renderer().get_canvas_width_height())
    corners = []  # of the panels, pixels from above and from the left

    def place(left: float, top: float, width: float, height: float) -> Axes:
        """Axes at inches from the upper left corner."""
        at = (left / size[0], 1 - (top + height) / size[1], width / size[0], height / size[1])
        axes = figure.add_axes(at)
        axes.set_axis_off()
        return axes

    cells = np.ndindex(rows, columns)
    for said, panel, (row, column) in zip(titles, panels, cells, strict=False):
        left, top = column * width, row * (height + title) + title
        down = tall - round((size[1] - top - height) * _DPI)
        corners.append((down - len(panel), round(left * _DPI)))
        figure.text(
            (left + width / 2) / size[0], 1 - (top - 0.06) / size[1],
            said, fontsize=11, color=ground.ink, ha="center",
        )  # fmt: skip
    if len(marks):
        _ring(place(0, title, width, height), group, scene.view.project(np.array(marks)))
    bar = place(columns * width + 0.3, title, 0.16, max(size[1] - title - 1.55, 1.2))
    _colour_bar(figure, bar, scene, ground)
    cross = place(columns * width + 0.1, size[1] - 1.3, legend - 0.2, 1.2)
    note = "ring: deepest overlap" if len(marks) else "grey: undeformed" * group.ghost
    mm_per_inch = (group.high - group.low)[0] / width
    _axes_cross(cross, scene.view, mm_per_inch, legend - 0.2, 1.2, note, ground)
    for each in grounds:
        if each is not ground:
            _recolour(figure, ground.ink, each.ink)
        canvas.draw()
        below = np.empty((tall, wide, 3), np.uint8)
        below[:] = np.round(255 * frames.colours([each.paper])[0])
        for panel, (down, right) in zip(_on(panels, each), corners, strict=False):
            # Not by matplotlib, which takes each of them through its colour maps.
            below[down : down + len(panel), right : right + panel.shape[1]] = panel
        yield _over(np.asarray(canvas.buffer_rgba()), below)


def _recolour(figure: Figure, ink: str, other: str) -> None:
    """Give what is written in one ink, and the arrows, another one."""
    from matplotlib.text import Annotation, Text

    for text in figure.findobj(Text):
        if isinstance(text, Text) and text.get_color() == ink:
            text.set_color(other)
        if isinstance(text, Annotation) and text.arrow_patch is not None:
            text.arrow_patch.set_color(other)


def _over(drawn: np.ndarray, below: np.ndarray) -> np.ndarray:
    """Put what is drawn, (height, width, 4) uint8 on a clear ground, over (height, width, 3)."""
    rows, columns = np.nonzero(drawn[..., 3])
    ink = drawn[rows, columns].astype(float)
    cover, shown = ink[:, 3:] / 255, below.copy()
    shown[rows, columns] = np.round(ink[:, :3] * cover + shown[rows, columns] * (1 - cover))
    return shown


def state_title(results: Results, number: float) -> str:
    """What the reader needs of a state: its load, and what the actuator does there.

    number: of the state; with a fraction, linear between two.
    """

    def value(column: np.ndarray) -> float:
        return float(np.interp(number, np.arange(len(column)), column))

    name = load_name(results)
    if name:
        label = labels.column(name)
        said = f"{labels.number(value(load(results)))} {label.unit}"
    else:
        said = _part_of_step(results, number)
    known = ((each, value(results.curve[each])) for each in headline.told(results))
    first = next((pair for pair in known if np.isfinite(pair[1])), None)
    if first:
        shown = headline.short(results, *first)
        said += f"   ·   {shown}"
    return said


def _part_of_step(results: Results, number: float) -> str:
    """``load_text`` of what stands between two states, too, without a pressure."""
    row = int(np.ceil(number))
    if number == row or "step_fraction" not in results.curve:
        return load_text(results, row)
    loads = load(results)
    begun = loads[row] - results.curve["step_fraction"][row]
    part = np.interp(number, np.arange(len(loads)), loads) - begun
    step = results.curve.get("step", [""] * len(loads))[row]
    return f"{100 * part:.3g} % of step '{step}'"


def _ring(axes: Axes, group: Group, places: np.ndarray) -> None:
    """Rings around places (n, 2) mm of a panel that fills the axes."""
    axes.set_zorder(1)  # above the picture
    axes.set_xlim(group.low[0], group.high[0])
    axes.set_ylim(group.low[1], group.high[1])
    # A white rim lets it be seen on any colour.
    for colour, width in (("white", 4.5), (MARK, 2.2)):
        axes.scatter(
            places[:, 0],
            places[:, 1],
            s=320,
            facecolors="none",
            edgecolors=colour,
            linewidths=width,
        )


def _colour_bar(figure: Figure, axes: Axes, scene: Scene, ground: Ground) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    axes.set_axis_on()
    bar = figure.colorbar(
        ScalarMappable(Normalize(*scene.limits), _colour_map()), cax=axes, extend="max"
    )
    bar.outline.set_visible(False)
    bar.ax.tick_params(labelsize=9, color=_GREY, labelcolor=ground.ink)
    bar.set_label(str(labels.field(scene.field)), fontsize=10, color=ground.ink)


def _axes_cross(
    axes: Axes, view: View, mm_per_inch: float, wide: float, tall: float, note: str, ground: Ground
) -> None:
    """The three axes as arrows of a round length in mm, to the scale of the panels."""
    axes.set_xlim(0, wide * mm_per_inch)
    axes.set_ylim(0, tall * mm_per_inch)
    length = round_down(0.6 * mm_per_inch)
    directions = view.project(np.eye(3))
    # Above the two lines of text, whichever way the arrows point.
    start = (np.array([0.35 * wide, 0.32 * tall]) - [0.0, 0.11]) * mm_per_inch
    start[1] -= min(0.0, length * float(directions[:, 1].min()) - 0.22 * mm_per_inch)
    for name, direction in zip("xyz", directions, strict=True):
        end = start + length * direction
        axes.annotate(
            "", tuple(end), tuple(start),
            arrowprops={"arrowstyle": "-|>", "color": ground.ink, "lw": 1.2, "shrinkA": 0,
                        "shrinkB": 0, "mutation_scale": 8},
        )  # fmt: skip
        beyond = end + 0.11 * mm_per_inch * direction / max(np.linalg.norm(direction), 0.3)
        axes.text(
            beyond[0], beyond[1], name, fontsize=9, color=ground.ink, ha="center", va="center"
        )
    for height, text in ((0.15, f"arrows: {length:g} mm"), (0.0, note)):
        axes.text(
            0.5 * wide * mm_per_inch, height * tall * mm_per_inch, text,
            fontsize=8.5, color=ground.ink, ha="center", va="bottom",
        )  # fmt: skip


def round_down(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above ``value``."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step for step in (1, 2, 5) if step * power <= value * (1 + 1e-9)) * power)

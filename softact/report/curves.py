"""What the curves and tables of a report show, taken from curve.csv; and ``curve.png``."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from softact.report import labels
from softact.results.folder import BOOKKEEPING, Results, load, load_name, rest_state
from softact.verdict import frequency_response

if TYPE_CHECKING:
    from softact.results.folder import Results

#: Title of a chart and the beginnings of the names of the columns in it. Other columns get a
#: chart of their own.
_GROUPS = (
    ("Bending angle", ("bending_angle", "chord_angle")),
    ("Pressures", ("pressure_",)),
    ("Cavity volume", ("cavity_volume",)),
    ("Stress", ("max_principal_stress", "max_von_mises", "principal_stress")),
    ("Stretch", ("max_principal_stretch", "principal_stretch", "max_fibre_stretch")),
    ("Pressures at failure", ("failure_pressure", "safe_pressure", "tested_stretch_pressure")),
    ("Elongation", ("elongation",)),
    ("Twist", ("twist_angle",)),
    ("Reaction force", ("reaction_x", "reaction_y", "reaction_z")),
    ("Reaction moment", ("reaction_moment",)),
    ("Energy", ("strain_energy", "pressure_work")),
    ("Material volume change", ("volume_change",)),
)
# Noise: by the scale of a unit, and of any unit. Newton's tolerance is 1e-6 or finer.
_NOISE, _ROUNDING, _WHOLE_TURN = 1e-7, 1e-9, 360.0
#: What is the same in all states.
_CONSTANT = "mass_g"
_AXES = ("_x_mm", "_y_mm", "_z_mm")


@dataclass(frozen=True)
class Chart:
    """Lines over one abscissa; ``equal`` asks for the same scale on both axes,
    ``logarithmic`` for a logarithmic abscissa. columns: of
    curve.csv, one for each line; none where the abscissa is no load."""

    title: str
    x: str
    y: str
    series: list[tuple[str, np.ndarray, np.ndarray]]
    equal: bool = False
    logarithmic: bool = False
    columns: tuple[str, ...] = ()


def is_place(name: str, names: Collection[str]) -> bool:
    """Whether a column is a coordinate of where a largest value lies."""
    return any(
        name.endswith(axis) and any(f"{name.removesuffix(axis)}{e}" in names for e in ("", "_MPa"))
        for axis in _AXES
    )


def measures(results: Results) -> list[str]:
    """Columns that are results: numbers, not bookkeeping, not places, not zero or noise
    throughout."""
    columns = results.curve
    angle = columns.get("bending_angle_deg", np.zeros(0))
    bends = _size(angle) > noise(results, "bending_angle_deg")  # else its axis is any
    return [
        name
        for name, values in columns.items()
        if name not in BOOKKEEPING
        and name != _CONSTANT
        and values.dtype == float
        and not is_place(name, columns)
        and _size(values) > noise(results, name)
        and not (name.startswith("bending_axis") and not bends)
    ]


def _size(values: np.ndarray) -> float:
    return float(np.nanmax(np.abs(values), initial=0.0, where=np.isfinite(values)))


def noise(results: Results, name: str) -> float:
    """Size below which a column's values are rounding or what the solver's tolerance leaves, in the
    column's unit.

    Forces and moments are measured by the stored energy, over the length where it is a force, and
    lengths by the actuator's.
    """
    unit = labels.column(name).unit
    energy = _size(results.curve.get("strain_energy_mJ", np.zeros(0)))
    length = results.layout.length
    scales = {
        "N·mm": energy,
        "N": energy / length if length else 0.0,
        "mm": length,
        "°": _WHOLE_TURN,
    }
    return max(_NOISE * scales.get(unit, 0.0), _ROUNDING)


def charts(results: Results) -> list[Chart]:
    """All charts, the tip's path included; none where there are no rows."""
    driver = load_name(results)
    abscissa = load(results)
    x_label = str(labels.column(driver)) if driver else "Load (finished steps and fraction)"
    left = [name for name in measures(results) if name != driver]
    found = []
    for title, beginnings in _GROUPS:
        names = [name for name in left if name.startswith(beginnings)]
        if title == "Pressures" and names and driver:
            names.insert(0, driver)
        # What stands in one chart has one unit.
        names = [name for name in names if labels.column(name).unit == labels.column(names[0]).unit]
        if names == [driver]:
            continue
        if names:
            found.append(_chart(results, title, x_label, abscissa, names))
            left = [name for name in left if name not in names]
    tip = [name for name in left if name.startswith("tip_")]
    if len(tip) > 1:
        found.insert(1, _tip_path(results, tip))
        left = [name for name in left if name not in tip]
    found += [_chart(results, labels.column(name).name, x_label, abscissa, [name]) for name in left]
    return [*_loops(results), *found, *_over_time(results), *_over_frequency(results)]


def _loops(results: Results) -> list[Chart]:
    """The last cycle of steps that swing, where two frequencies or more drove one pressure."""
    found = [one for one in frequency_response.harmonics(results) if one.drive]
    alike = [one for one in found if (one.column, one.drive) == (found[0].column, found[0].drive)]
    if len({one.frequency for one in alike}) < 2:
        return []
    x, y = labels.column(found[0].drive), labels.column(found[0].column)
    series = []
    for one in alike:
        rows = slice(one.rows[0], one.rows[1] + 1)
        pressure, answer = (results.curve[name][rows] for name in (one.drive, one.column))
        series.append((f"{one.frequency:g} Hz", pressure * x.factor, answer * y.factor))
    return [Chart(f"{y.name}, last cycle", str(x), str(y), series)]


def _over_frequency(results: Results) -> list[Chart]:
    """Gain and phase of steps that swing, where two frequencies or more were tried."""
    found = frequency_response.harmonics(results)
    if len({one.frequency for one in found}) < 2:
        return []
    charts, label = [], "Frequency (Hz)"
    frequencies = np.array([one.frequency for one in found])
    answer = labels.column(found[0].column)
    unit = f"{answer.unit}/kPa" if found[0].drive else answer.unit
    for title, y, values in (
        (f"{answer.name}: gain", f"Gain ({unit})", [one.gain * answer.factor for one in found]),
        (f"{answer.name}: phase", "Phase (°)", [-one.lag for one in found]),
    ):
        line = (answer.name, frequencies, np.array(values))
        charts.append(Chart(title, label, y, [line], logarithmic=True))
    return charts


def _over_time(results: Results) -> list[Chart]:
    """The load and what follows it, over the time of a run with a clock."""
    times = results.curve.get("time_s", np.zeros(1))
    if not np.ptp(times):
        return []
    driver = load_name(results)
    beginnings = ("bending_angle", "elongation_mm", "cavity_volume")
    names = [name for name in measures(results) if name.startswith(beginnings)]
    shown = dict.fromkeys(n for n in (driver, *names[:2]) if n)
    return [
        replace(
            _chart(results, f"{labels.column(n).name} in time", "Time (s)", times, [n]),
            y=str(labels.column(n)),
        )
        for n in shown
    ]


def _chart(
    results: Results, title: str, x_label: str, abscissa: np.ndarray, names: Sequence[str]
) -> Chart:
    shown = [labels.column(name) for name in names]
    series = [
        (label.name, abscissa, results.curve[name] * label.factor)
        for name, label in zip(names, shown, strict=True)
    ]
    unit = shown[0].unit
    y = f"{title} ({unit})" if unit else title
    return Chart(title, x_label, y, series, columns=tuple(names))


def _tip_path(results: Results, names: list[str]) -> Chart:
    """The two coordinates of the tip that change most, one against the other."""
    spans = [np.ptp(results.curve[name][np.isfinite(results.curve[name])]) for name in names]
    first, second = sorted(np.argsort(spans)[-2:])
    x, y = (str(labels.column(names[n])) for n in (first, second))
    line = ("Tip", results.curve[names[first]], results.curve[names[second]])
    return Chart("Path of the tip", x, y, [line], equal=True)


def round_loads(low: float, high: float) -> list[float]:
    """Three to six round values strictly between ``low`` and ``high``, in that order."""
    span = high - low
    if span == 0 or not np.isfinite(span):
        return []
    power = 10.0 ** np.floor(np.log10(abs(span) / 4))
    step = min((1, 2, 2.5, 5, 10), key=lambda s: abs(abs(span) / (s * power) - 5)) * power
    step *= np.sign(span)
    first = np.floor(low / step + 1e-9) + 1
    values = step * (first + np.arange(12))
    return [float(v) for v in values if (high - v) * np.sign(span) > 0.02 * abs(span)]


def at_load(results: Results, values: np.ndarray, aim: float) -> float:
    """``values`` where the load first reaches ``aim``, linear between increments; else NaN."""
    loads = load(results)
    for number in range(max(rest_state(results), 0), len(loads) - 1):
        one, other = loads[number], loads[number + 1]
        if one != other and (one - aim) * (other - aim) <= 0:
            part = (aim - one) / (other - one)
            return float((1 - part) * values[number] + part * values[number + 1])
    return float("nan")


def picture(results: Results, most: int = 4) -> bytes:
    """PNG of the first ``most`` charts."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    chosen = charts(results)[:most]
    columns = min(len(chosen), 2)
    rows = -(-len(chosen) // columns)
    wide, tall = 5.2 * columns, 3.9 * rows  # inches
    figure = Figure(figsize=(wide, tall), dpi=160)
    # Given, since finding room for the texts would take as long as drawing.
    figure.subplots_adjust(
        left=0.82 / wide, right=1 - 0.2 / wide, bottom=0.62 / tall, top=1 - 0.4 / tall,
        wspace=1.1 / (5.2 - 1.06), hspace=1.1 / (3.9 - 1.06),
    )  # fmt: skip
    FigureCanvasAgg(figure)
    for place, chart in enumerate(chosen):
        axes = figure.add_subplot(rows, columns, place + 1)
        for colour, (name, x, y) in zip(COLOURS * 3, chart.series, strict=False):
            axes.plot(x, y, "o-", color=colour, markersize=3.5, linewidth=1.8, label=name)
        axes.set_xlabel(chart.x)
        axes.set_ylabel(chart.y)
        axes.set_title(chart.title, loc="left", fontsize=12, fontweight="bold")
        axes.grid(color="#e3e7ea", linewidth=0.8)
        axes.spines[["top", "right"]].set_visible(False)
        if chart.equal:
            axes.set_aspect("equal", adjustable="datalim")
        if chart.logarithmic:
            axes.set_xscale("log")
        if len(chart.series) > 1:
            axes.legend(frameon=False, fontsize=9)
    out = BytesIO()
    figure.savefig(out, format="png", pil_kwargs={"compress_level": 4})
    return out.getvalue()


#: Line colours, told apart by colour-blind readers too (Okabe and Ito 2008).
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")

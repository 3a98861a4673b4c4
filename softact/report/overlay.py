"""A run's curves with measured ones over them, and how far they are apart."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from softact.measured.curve import Measured, predicted, rising
from softact.report import labels
from softact.report.base import Plot, Section, figures, lines, table, xy
from softact.report.base.templates import macros
from softact.results.folder import Results

#: They part where they differ by more than this of the measured range.
PARTING = 0.1


@dataclass(frozen=True)
class Deviation:
    """How far a run is from a measured column, in the run's units.

    compared: measured values within the run's range, of ``count`` there are. rmse, largest:
    of run minus measured (largest with its sign); largest_at: the abscissa there. parts_at: first
    abscissa, in the order in which the load grows, where the two differ by more than a tenth of
    the measured range; None where they never do.
    """

    source: str
    x: str
    name: str
    count: int
    compared: int
    rmse: float
    largest: float
    largest_at: float
    span: float
    parts_at: float | None


def deviations(curve: Mapping[str, np.ndarray], measured: Measured) -> list[Deviation]:
    """Compare each measured column with the run where both are; see ``Deviation``.

    Between increments the run is a monotone cubic. Raises SpecError where the run has no such
    column, or its abscissa turns back within the step in which it changes most.
    """
    x = measured.values[measured.x]
    within = _within(curve, measured)
    order = np.flatnonzero(within)[np.argsort(x[within], kind="stable")]
    if rising_down(curve, measured.x):
        order = order[::-1]
    part = Measured(
        measured.source,
        measured.x,
        {name: values[order] for name, values in measured.values.items()},
    )
    found = predicted(curve, part) if len(order) else None
    said = []
    for name in measured.names:
        span = float(np.ptp(measured.values[name]))
        one: tuple[int, float, float, float, float, float | None]
        if found is None:
            nothing = float("nan")
            one = (0, nothing, nothing, nothing, span, None)
        else:
            apart = found[name] - part.values[name]
            worst = int(np.argmax(np.abs(apart)))
            far = np.flatnonzero(np.abs(apart) > PARTING * span)
            one = (
                len(order), float(np.sqrt(np.mean(apart**2))), float(apart[worst]),
                float(x[order[worst]]), span, float(x[order[far[0]]]) if len(far) else None,
            )  # fmt: skip
        said.append(Deviation(measured.source, measured.x, name, len(x), *one))
    return said


def _within(curve: Mapping[str, np.ndarray], measured: Measured) -> np.ndarray:
    if measured.x not in curve:
        return np.zeros(len(measured.values[measured.x]), bool)
    reached = curve[measured.x][rising(curve, measured.x)]
    x = measured.values[measured.x]
    return (x >= reached.min()) & (x <= reached.max())


def rising_down(curve: Mapping[str, np.ndarray], x: str) -> bool:
    """Whether the abscissa falls in the step in which it changes most (suction)."""
    values = curve[x][rising(curve, x)] if x in curve else np.zeros(1)
    return values[-1] < values[0]


def tell(deviation: Deviation) -> str:
    """One plain line."""
    y, x = labels.column(deviation.name), labels.column(deviation.x)
    name = f"{deviation.name} against {deviation.source}"
    if not deviation.compared:
        return (
            f"{name}: none of {deviation.count} measured points is within the run's {deviation.x}"
        )

    def text(value: float, label: labels.Label) -> str:
        return f"{labels.number(value * label.factor)} {label.unit}".strip().replace(" °", "°")

    parts = "they never part by more than 10 % of the measured range"
    if deviation.parts_at is not None:
        parts = f"apart by more than 10 % of the measured range from {text(deviation.parts_at, x)}"
    outside = deviation.count - deviation.compared
    rest = f"; {outside} of {deviation.count} points beyond the run" if outside else ""
    return (
        f"{name}: RMSE {text(deviation.rmse, y)} ({100 * deviation.rmse / deviation.span:.1f} % of "
        f"range), largest {text(deviation.largest, y)} at {text(deviation.largest_at, x)}; "
        f"{parts}{rest}"
    )


def section(results: Results, several: Sequence[Measured]) -> Section:
    """The part of a report that sets measured curves against the run's."""
    found = [d for measured in several for d in deviations(results.curve, measured)]
    heads = ["Measured", "Figure", "Unit", "Points compared", "RMSE", "RMSE (% of range)",
             "Largest deviation", "… at", "They part at"]  # fmt: skip
    drawn = figures(_plots(results, several))
    rows = [_row(d) for d in found]
    body = macros("report/sections.html").measured(drawn, table(heads, rows, file="deviations.csv"))
    return Section("measured", "Against measurement", body, "Measured")


def _row(d: Deviation) -> list:
    y, x = labels.column(d.name), labels.column(d.x)
    at = f"{labels.number(d.largest_at * x.factor)} {x.unit}"
    parts = "never" if d.compared else "–"
    if d.parts_at is not None:
        parts = f"{labels.number(d.parts_at * x.factor)} {x.unit}"
    numbers = [d.rmse * y.factor, 100 * d.rmse / d.span, d.largest * y.factor]
    compared = f"{d.compared} of {d.count}"
    return [Path(d.source).name, y.name, y.unit, compared, *numbers, at, parts]


def _plots(results: Results, several: Sequence[Measured]) -> list[Plot]:
    """One plot for each pair of columns that was measured."""
    pairs = dict.fromkeys((m.x, name) for m in several for name in m.names)
    return [_plot(results, several, x, y) for x, y in pairs]


def _plot(results: Results, several: Sequence[Measured], x: str, y: str) -> Plot:
    across, along = labels.column(x), labels.column(y)
    curve = results.curve
    run = curve[x] * across.factor, curve[y] * along.factor
    traces = [xy("softact", *run, colour="@c1", line={"width": 3})]
    for number, measured in enumerate(several):
        if measured.x == x and y in measured.names:
            name = Path(measured.source).name
            values = measured.values
            traces.append(
                xy(
                    name, values[x] * across.factor, values[y] * along.factor, mode="markers",
                    colour=f"@c{number + 2}", marker={"size": 5, "opacity": 0.7},
                )
            )  # fmt: skip
    title = f"{along.name}: run and measurement"
    return lines(title, str(across), str(along), traces, wide=True)

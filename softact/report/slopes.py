"""What hangs on what: the derivatives of a run's figures by the numbers of its spec."""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup

from softact.report import base, headline, labels
from softact.report.base import Plot, Section
from softact.report.base.templates import macros
from softact.results.folder import SENSITIVITIES, Results, load, load_name
from softact.sensitivities.stored import Slope, read

#: How many figures have a chart, how many parameters a bar, and how many a curve.
FIGURES, BARS, CURVES = 3, 15, 6
#: Figures that are wanted beside what moves, by the beginning of their column.
OTHERS = ("principal_stress_p999", "blocked_force", "cavity_volume")


def section(results: Results) -> tuple[list[Section], str]:
    """The section of the report, if there is one, and what is wrong with the table."""
    try:
        found = [s for s in read(results.directory) if s.row < len(load(results))]
    except (OSError, ValueError, KeyError, TypeError):
        return [], f"{SENSITIVITIES} cannot be read: softact run --sensitivities writes it"
    measures = _shown(results, found)
    if not measures:
        return [], ""
    last = max(s.row for s in found)
    now = [s for s in found if s.row == last]
    body = macros("report/sections.html").slopes(
        said=[line for name in measures if (line := _said(now, name))],
        state=_state(results, last),
        plots=base.figures([plot for name in measures for plot in _plots(results, found, name)]),
        table=_table(now, measures),
        file=SENSITIVITIES,
    )
    return [Section("slopes", "What to change", body, "Sensitivities")], ""


def _shown(results: Results, found: Sequence[Slope]) -> list[str]:
    there = dict.fromkeys(s.measure for s in found)
    wanted = [name for name in headline.told(results) if name in there]
    wanted += [name for name in there if name.startswith(OTHERS)]
    return list(dict.fromkeys(wanted))[:FIGURES]


def _state(results: Results, row: int) -> str:
    name = load_name(results)
    if not name:
        return f"increment {row}"
    label = labels.column(name)
    return f"{labels.number(float(load(results)[row]) * label.factor)} {label.unit}"


def _ranked(slopes: Sequence[Slope], measure: str) -> list[Slope]:
    """Those of one figure, by how much one percent changes it."""
    found = [s for s in slopes if s.measure == measure and s.elasticity is not None]
    return sorted(found, key=lambda s: -abs(s.elasticity or 0.0))


def _said(now: Sequence[Slope], measure: str) -> str:
    """The strongest one in words."""
    ranked = _ranked(now, measure)
    if not ranked:
        return ""
    first, name = ranked[0], labels.column(measure).name
    name = name[:1].lower() + name[1:]
    by_ten = 10 * (first.elasticity or 0.0)
    change, sign = labels.number(by_ten, 3), "+" if by_ten > 0 else ""
    return f"{first.parameter} larger by 10 %: {sign}{change} % of {name}"


def _plots(results: Results, found: Sequence[Slope], measure: str) -> list[Plot]:
    last = max(s.row for s in found)
    ranked = _ranked([s for s in found if s.row == last], measure)
    if not ranked:
        return []
    label, top = labels.column(measure), ranked[:BARS]
    unit = f"% of {label.name[:1].lower()}{label.name[1:]} per % of the parameter"
    names = [s.parameter for s in top]
    bars = base.bars(
        f"{label.name}: what it hangs on at {_state(results, last)}",
        unit, "parameter", names, [s.elasticity or 0.0 for s in top], wide=True,
    )  # fmt: skip
    return [bars, _along(results, found, measure, names[:CURVES])]


def _along(results: Results, found: Sequence[Slope], measure: str, names: Sequence[str]) -> Plot:
    """How much one percent of each parameter changes a figure, along the load."""
    label, curve = labels.column(measure), results.curve
    name = load_name(results)
    axis = str(labels.column(name)) if name else "state"
    factor = labels.column(name).factor if name else 1.0
    places = load(results)
    traces = []
    for parameter in names:
        own = [s for s in found if (s.measure, s.parameter) == (measure, parameter)]
        x = [float(places[s.row]) * factor if name else s.row for s in own]
        y = [(s.elasticity or 0.0) / 100 * float(curve[measure][s.row]) * label.factor for s in own]
        traces.append(base.xy(parameter, x, y))
    said = f"change by 1 % of the parameter ({label.unit})" if label.unit else "change by 1 %"
    title = f"{label.name}: the same along the load"
    return base.lines(title, axis, said, traces, wide=True)


def _table(now: Sequence[Slope], measures: Sequence[str]) -> Markup:
    heads = ["Parameter", "Value"]
    rows: dict[str, list[str | float | None]] = {}
    for measure in measures:
        name = labels.column(measure).name
        heads += [f"{name}: derivative", "Unit", "% per %"]
    for slope in now:
        rows.setdefault(slope.parameter, [slope.parameter, slope.at])
    for parameter, row in rows.items():
        of = {s.measure: s for s in now if s.parameter == parameter}
        for measure in measures:
            one = of.get(measure)
            row += [one.derivative, one.unit, one.elasticity] if one else [None, "", None]
    return base.table(heads, list(rows.values()), file="sensitivities_last_state.csv")

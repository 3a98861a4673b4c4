"""The text of report.html: one file that needs nothing else, not even a network."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from types import MappingProxyType

from markupsafe import Markup

from softact.report import (
    base,
    curves,
    force_angle,
    headline,
    history,
    key_figures,
    labels,
    mesh_error,
    origin,
    pictures,
    scatter,
    slopes,
)
from softact.report.base import Plot, Section, templates
from softact.report.view import states
from softact.results.folder import (
    COMPLETE,
    MESH_ERROR,
    NO_EQUILIBRIUM,
    Results,
    load,
    load_name,
    load_text,
    place_text,
)
from softact.verdict.judge import AMBER, GREEN, RED, TITLES, Verdict
from softact.verdict.reached import reached

_TEMPLATE = "report/report_page.html"


def prepare() -> None:
    """Compile what ``html`` needs, ahead of it."""
    templates.load(_TEMPLATE, "report/base/layout.html")


def html(
    results: Results,
    verdict: Verdict,
    view: dict | None,
    faults: list[str],
    more: Sequence[Section] = (),
    along: Sequence[Plot] = (),
    pictures: Mapping[str, tuple[bytes, bytes]] = MappingProxyType({}),
) -> str:
    """The whole page. verdict: on the run; view: what ``viewer.pack`` gave; faults: what is missing
    and why; more: sections that were asked for; along: plots over the axis, see ``curvature``;
    pictures: the folder's, each as WebP on a light ground and on a dark one.
    """
    spec = results.spec
    name = str(spec.get("name") or results.directory.resolve().name)
    errors = mesh_error.read(results)
    faults = [*faults, errors.fault] if errors.fault else faults
    bars = {column: mesh_error.text(column, bar) for column, bar in errors.bars.items()}
    hanging, fault = slopes.section(results)
    bands = scatter.read(results)
    faults = [*faults, *filter(None, (fault, bands.fault)), *headline.missing(results)]
    count, state = _count(results), headline.title(results)
    sections = [
        Section("figures", "Key figures", nav="Figures"),
        *mesh_error.section(results, errors),
        *hanging,
        *scatter.section(results, bands),
        *more,
        *([Section("view", "3-D view")] if view else []),
        Section("states", count, nav="States"),
        Section("curves", "Curves"),
        Section("convergence", "Convergence"),
        Section("spec", "Spec and assumptions"),
        Section("provenance", "Provenance"),
        Section("cite", "Reproduce and cite"),
    ]
    return base.page(
        name,
        sections,
        kicker="Data sheet of a soft actuator",
        kind="data sheet",
        data={"view": view},
        template=_TEMPLATE,
        spec={key: str(spec.get(key) or "") for key in ("description", "source")},
        verdict=_banner(results, _worded(verdict, errors), faults),
        notes=_notes(results),
        state=state,
        shape=_image(pictures, "shape.png", f"{name} {state[:1].lower()}{state[1:]}"),
        cards=_cards(results, bars, bands),
        figures=_figures(results, bars),
        count=count.lower(),
        states=_image(pictures, "states.png", f"The actuator: {count.lower()}"),
        curves=base.figures(_with(_plots(results, bands), along)),
        history=history.summary(results),
        assumptions=origin.assumptions(spec),
        resolved=results.spec_yaml,
        provenance=origin.provenance(results),
        cite=origin.cite(results, name),
    )


def _reached(results: Results, row: int) -> str:
    """Words for a state."""
    said = load_text(results, row)
    curve = results.curve
    if load_name(results) and "step" in curve:
        part = f" at {100 * curve['step_fraction'][row]:.4g} %" if "step_fraction" in curve else ""
        said += f" (step “{curve['step'][row]}”{part})"
    doing = headline.state_text(results, row)
    return f"{said}, {doing}" if doing else said


_KINDS = {GREEN: "good", AMBER: "warn", RED: "bad"}


def _worded(verdict: Verdict, errors: mesh_error.MeshErrors) -> Verdict:
    """The same verdict with the names of the study's columns as people say them."""
    reasons = (replace(r, text=errors.worded(r.text)) for r in verdict.reasons)
    return replace(verdict, reasons=tuple(reasons))


def _banner(results: Results, verdict: Verdict, faults: list[str]) -> Markup:
    last = len(load(results)) - 1
    stated = _reached(results, last) if last >= 0 else "no equilibrium state at all"
    if results.status == COMPLETE:
        text = f"All steps were solved; the last state is at {stated}."
    elif results.status == NO_EQUILIBRIUM:
        text = f"The solver reached {stated} and found no further equilibrium."
        largest = reached(results).largest
        if largest not in (None, last):
            stable = _reached(results, largest)
            text = f"The largest stable load is {stable}. The last state found is at {stated}."
    else:
        text = f"The run has not ended, or was stopped; so far: {stated}."
    head = f"{verdict.words[:1].upper()}{verdict.words[1:]}"
    head += " …" if verdict.colour == AMBER else "."
    reasons = [r for r in verdict.reasons if r.kind != "end" or results.status == NO_EQUILIBRIUM]
    items: list[tuple[str, str] | str] = [(TITLES[reason.kind], reason.text) for reason in reasons]
    items += [fault for fault in faults if not any(fault in reason.text for reason in reasons)]
    return base.banner(_KINDS[verdict.colour], head, text, items)


def _notes(results: Results) -> list[str]:
    """What a reader may know, too."""
    notes = [str(note) for note in results.run.get("notes") or []]
    if results.status == COMPLETE and not (results.directory / MESH_ERROR).is_file():
        notes.append(
            "How far the mesh is from converged was not looked at: softact converge SPEC --into DIR"
        )
    return notes


def _image(drawn: Mapping[str, tuple[bytes, bytes]], name: str, alt: str) -> str:
    return base.two_images(*drawn[name], alt) if name in drawn else ""


def _cards(results: Results, bars: dict[str, str], bands: scatter.Bands) -> list[Markup]:
    """The figures that a reader looks for first, as large numbers, of the state that stands for the
    run."""
    main, curve = reached(results).main, results.curve
    if main is None:
        return []
    last = main == len(load(results)) - 1
    head = headline.figures(results)

    def card(figure: headline.Figure) -> Markup:
        told = [figure.note, bands.text(figure.column, main)]
        noted = replace(figure, note=", ".join(filter(None, told)))
        return _card(noted, bars.get(figure.column, "") if last else "")

    cards = [card(figure) for figure in head]
    if headline.chosen(results):
        return cards
    shown = {figure.column for figure in head}
    wanted = [n for n in curve if n.startswith("cavity_volume")]
    wanted += ["max_principal_stress_MPa", "max_principal_stretch"]
    for name in [n for n in wanted if n in curves.measures(results) and n not in shown]:
        cards.append(card(headline.figure(results, name, main, _where(results, name, main))))
    extra = {k: v for k, v in results.summary.items() if k not in curve and "." not in k}
    broken = [f"failure_pressure{by}_kPa" for by in ("", "_nominal", "_cauchy", "_stretch")]
    for name in (*broken, "blocked_force_N"):
        if isinstance(value := extra.get(name), float):
            cards.append(_card(headline.Figure(name, labels.column(name), value)))
    by_mass = headline.by_mass(results, main)
    return cards + [card(figure) for figure in by_mass if figure.column not in shown]


def _card(figure: headline.Figure, error: str = "") -> Markup:
    label = figure.label
    value = labels.number(figure.value * label.factor)
    return base.card(label.name, value, label.unit, figure.note, error)


def _where(results: Results, name: str, row: int) -> str:
    """Where a largest value lies, if the run says."""
    stem = name.removesuffix("_MPa")
    columns = [results.curve.get(f"{stem}_{axis}_mm") for axis in "xyz"]
    places = [column for column in columns if column is not None and column.dtype == float]
    if not name.startswith("max_") or len(places) < len(columns):
        return ""
    return f"at x, y, z = {place_text(p[row] for p in places)} mm (undeformed)"


def _figures(results: Results, bars: dict[str, str]) -> dict | None:
    """The table of key figures: the steps with the number of their columns, the loads, the rows of
    name, unit and texts; and what each figure is. None where there is no state."""
    stops, rows = key_figures.table(results, bars)
    if not rows:
        return None
    path = results.directory / "curve.csv"
    columns = [name for name, _, _ in rows]
    named = {name: labels.column(name).name for name in columns}
    meanings = [(named[name], labels.meaning(name)) for name in columns]
    return {
        "steps": [(step, len(list(some))) for step, some in groupby(stops, lambda stop: stop.step)],
        "loads": [stop.text for stop in stops],
        "rows": [(named[name], unit, texts) for name, unit, texts in rows],
        "errors": bool(bars),
        "download": base.download(path.name, path.read_bytes()) if path.is_file() else "",
        "meanings": [(name, said) for name, said in meanings if said],
    }


def _count(results: Results) -> str:
    """ "Four states"."""
    if not results.increments:
        return "States"
    count = len(states(results, pictures.MOST_STATES))
    return ("One state", "Two states", "Three states", "Four states")[count - 1]


def _with(plots: list[Plot], along: Sequence[Plot]) -> list[Plot]:
    """The curves, and what stands over the axis beside the tip's path."""
    return [*plots[:2], *along, *plots[2:]]


def _plots(results: Results, bands: scatter.Bands) -> list[Plot]:
    return [
        base.lines(
            chart.title, chart.x, chart.y,
            [*(base.xy(name, x, y) for name, x, y in chart.series), *scatter.traces(chart, bands)],
            equal=chart.equal,
            layout={"xaxis": {"type": "log"}} if chart.logarithmic else {},
        )
        for chart in curves.charts(results)
    ] + force_angle.of_run(results)  # fmt: skip

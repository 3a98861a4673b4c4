"""The text of report.html: one file that needs nothing else, not even a network."""

from collections.abc import Sequence
from dataclasses import replace
from html import escape
from importlib.resources import files
from itertools import groupby
from pathlib import Path

from softact.report import (
    base,
    curves,
    headline,
    history,
    key_figures,
    labels,
    mesh_error,
    origin,
    pictures,
)
from softact.report.base import Plot, Section
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

_VIEW = """\
<div id="shape" role="img" aria-label="The deformed actuator; drag to turn it"></div>
<div class="controls">
<button type="button" id="play" aria-label="Play">&#9654;</button>
<input type="range" id="load" min="0" max="0" value="0" step="1" aria-label="Load">
<label>Colour <select id="field"></select></label>
<label id="cutlabel"><input type="checkbox" id="cut"> cut open</label>
</div>
<p id="caption" aria-live="polite"></p>
<p class="note">Drag to turn, wheel or pinch to zoom, right-drag or two fingers to shift;
lengths in mm, displacements to scale. <span id="range"></span></p>"""


def html(
    results: Results,
    verdict: Verdict,
    view: dict | None,
    faults: list[str],
    more: Sequence[Section] = (),
) -> str:
    """The whole page. verdict: on the run; view: what ``viewer.pack`` gave; faults: what is missing
    and why; more: sections that were asked for.
    """
    here = files("softact.report")
    spec = results.spec
    name = str(spec.get("name") or results.directory.resolve().name)
    told = origin.assumptions(spec)
    errors = mesh_error.read(results)
    faults = [*faults, errors.fault] if errors.fault else faults
    bars = {column: mesh_error.text(column, bar) for column, bar in errors.bars.items()}
    sections = [
        Section("figures", "Key figures", _figures(results, bars), "Figures"),
        *mesh_error.section(results, errors),
        *more,
        *([Section("view", "3-D view", _VIEW)] if view else []),
        Section("states", _count(results), _states(results), "States"),
        Section("curves", "Curves", base.figures(_plots(results))),
        Section("convergence", "Convergence", history.section(results)),
        Section("spec", "Spec and assumptions", f"{told}{_resolved(results)}"),
        Section("provenance", "Provenance", origin.provenance(results)),
        Section("cite", "Reproduce and cite", origin.cite(results, name)),
    ]
    return base.page(
        name,
        sections,
        kicker="Data sheet of a soft actuator",
        kind="data sheet",
        lead=_lead(results, _worded(verdict, errors), spec, name, faults, bars),
        data={"view": view},
        style=(here / "style.css").read_text(encoding="utf-8"),
        script=(here / "report.js").read_text(encoding="utf-8"),
    )


def _lead(
    results: Results, verdict: Verdict, spec: dict, name: str, faults: list[str], bars: dict
) -> str:
    """What stands above the contents: description, verdict, picture, cards. bars: column -> the
    error bar's text."""
    lines = []
    if spec.get("description"):
        lines.append(f"<p class='lead'>{escape(str(spec['description']))}</p>")
    if spec.get("source"):
        lines.append(f"<p class='source'>Source: {escape(str(spec['source']))}</p>")
    title = headline.title(results)
    hero = _image(results.directory / "shape.png", f"{name} {title[:1].lower()}{title[1:]}")
    shown = f"<h2 class='state'>{escape(title)}</h2>" if title else ""
    lines += [
        _banner(results, verdict, faults),
        f"<section class='top'><div class='hero'>{hero}</div><div>{shown}"
        f"<div class='cards' aria-label='Figures'>{_cards(results, bars)}</div></div></section>",
    ]
    return "\n".join(lines)


def _resolved(results: Results) -> str:
    return f"<h3>Resolved spec</h3><pre class='spec'>{escape(results.spec_yaml)}</pre>"


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


def _banner(results: Results, verdict: Verdict, faults: list[str]) -> str:
    last = len(load(results)) - 1
    stated = escape(_reached(results, last)) if last >= 0 else "no equilibrium state at all"
    if results.status == COMPLETE:
        text = f"All steps were solved; the last state is at {stated}."
    elif results.status == NO_EQUILIBRIUM:
        text = f"The solver reached {stated} and found no further equilibrium."
        largest = reached(results).largest
        if largest not in (None, last):
            stable = escape(_reached(results, largest))
            text = f"The largest stable load is {stable}. The last state found is at {stated}."
    else:
        text = f"The run has not ended, or was stopped; so far: {stated}."
    head = f"{verdict.words[:1].upper()}{verdict.words[1:]}"
    head += " …" if verdict.colour == AMBER else "."
    reasons = [r for r in verdict.reasons if r.kind != "end" or results.status == NO_EQUILIBRIUM]
    items = [(TITLES[reason.kind], reason.text) for reason in reasons]
    items += [fault for fault in faults if not any(fault in reason.text for reason in reasons)]
    return base.banner(_KINDS[verdict.colour], head, text, items) + _notes(results, verdict)


def _notes(results: Results, verdict: Verdict) -> str:
    """What a reader may know, too."""
    notes = [str(note) for note in results.run.get("notes") or []]
    if results.status == COMPLETE and not (results.directory / MESH_ERROR).is_file():
        notes.append(
            "How far the mesh is from converged was not looked at: softact converge SPEC --into DIR"
        )
    listed = "".join(f"<li>{escape(note)}</li>" for note in notes)
    return f"<ul class='notes'>{listed}</ul>" if listed else ""


def _image(path: Path, alt: str) -> str:
    return base.image(path.read_bytes(), alt) if path.is_file() else ""


def _cards(results: Results, bars: dict[str, str]) -> str:
    """The figures that a reader looks for first, as large numbers, of the state that stands for the
    run."""
    main, curve = reached(results).main, results.curve
    if main is None:
        return ""
    last = main == len(load(results)) - 1
    head = headline.figures(results)
    cards = [_card(f, bars.get(f.column, "") if last else "") for f in head]
    told = {figure.column for figure in head}
    wanted = [n for n in curve if n.startswith("cavity_volume")]
    wanted += ["max_principal_stress_MPa", "max_principal_stretch"]
    for name in [n for n in wanted if n in curves.measures(results) and n not in told]:
        figure = headline.figure(results, name, main, _where(results, name, main))
        cards.append(_card(figure, bars.get(name, "") if last else ""))
    extra = {k: v for k, v in results.summary.items() if k not in curve and "." not in k}
    for name in ("failure_pressure_kPa", "blocked_force_N"):
        if isinstance(extra.get(name), float):
            cards.append(_card(headline.Figure(name, labels.column(name), extra[name])))
    return "".join(cards)


def _card(figure: headline.Figure, error: str = "") -> str:
    label = figure.label
    value = labels.number(figure.value * label.factor)
    return base.card(label.name, value, label.unit, figure.note, error)


def _where(results: Results, name: str, row: int) -> str:
    """Where a largest value lies, if the run says."""
    stem = name.removesuffix("_MPa")
    places = [results.curve.get(f"{stem}_{axis}_mm") for axis in "xyz"]
    if not name.startswith("max_") or any(p is None or p.dtype != float for p in places):
        return ""
    return f"at x, y, z = {place_text(p[row] for p in places)} mm (undeformed)"


def _figures(results: Results, bars: dict[str, str]) -> str:
    stops, rows = key_figures.table(results, bars)
    if not rows:
        return "<p>There is no accepted increment, so there are no figures.</p>"
    body = "".join(
        f"<tr><th scope='row'>{escape(labels.column(name).name)}</th>"
        f"<td class='unit'>{escape(unit)}</td>"
        + "".join(f"<td>{escape(text)}</td>" for text in texts)
        + "</tr>"
        for name, unit, texts in rows
    )
    told = ""
    if bars:
        told = " ± is the <a href='#mesherror'>error bar of the mesh</a>."
    path = results.directory / "curve.csv"
    link = base.download(path.name, path.read_bytes()) if path.is_file() else ""
    return (
        f"<div class='scroll'><table class='figures'><thead>{_heads(stops)}</thead>"
        f"<tbody>{body}</tbody></table></div>"
        "<p class='note'>Figures are of the whole actuator. Between accepted increments they are "
        f"interpolated linearly; the last column is a computed state.{told} {link}</p>"
        f"{_meanings([name for name, _, _ in rows])}"
    )


def _heads(stops: list[key_figures.Stop]) -> str:
    """Rows of heads: the steps, where there are several, and the loads."""
    steps = [(step, len(list(some))) for step, some in groupby(stops, lambda stop: stop.step)]
    above = ""
    if len(steps) > 1:
        spans = "".join(
            f"<th scope='colgroup' colspan='{count}'>{escape(step)}</th>" for step, count in steps
        )
        above = f"<tr class='steps'><td colspan='2'></td>{spans}</tr>"
    loads = "".join(f"<th scope='col'>{escape(stop.text)}</th>" for stop in stops)
    return f"{above}<tr><th scope='col'>Figure</th><th scope='col'>Unit</th>{loads}</tr>"


def _meanings(names: list[str]) -> str:
    """What each figure is, to be opened."""
    told = [(labels.column(name).name, labels.meaning(name)) for name in names]
    listed = "".join(
        f"<dt>{escape(name)}</dt><dd>{escape(said)}</dd>" for name, said in told if said
    )
    if not listed:
        return ""
    return f"<details><summary>What each figure is</summary><dl>{listed}</dl></details>"


def _count(results: Results) -> str:
    """ "Four states"."""
    if not results.increments:
        return "States"
    count = len(states(results, pictures.MOST_STATES))
    return ("One state", "Two states", "Three states", "Four states")[count - 1]


def _states(results: Results) -> str:
    shown = _count(results).lower()
    image = _image(results.directory / "states.png", f"The actuator: {shown}")
    if not image:
        return "<p>There are no pictures; the note at the top of this page says why.</p>"
    return (
        f"<figure><div class='scroll wide'>{image}</div><figcaption>Deformed actuator, {shown}, to "
        "scale, one colour range for all; the grey outline is the undeformed "
        "actuator. The mirrored part is drawn too. Values above the top of the scale have its "
        "last colour.</figcaption></figure>"
    )


def _plots(results: Results) -> list[Plot]:
    return [
        base.lines(
            chart.title, chart.x, chart.y,
            [base.xy(name, x, y) for name, x, y in chart.series], equal=chart.equal,
        )
        for chart in curves.charts(results)
    ]  # fmt: skip

"""The text of report.html: one file that needs nothing else, not even a network."""

from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path

import yaml

from softact.report import base, curves, history, labels, mesh_error, origin
from softact.report.base import Plot, Section
from softact.report.view import load, load_name
from softact.results import COMPLETE, NO_EQUILIBRIUM, Results

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
    results: Results, view: dict | None, faults: list[str], more: Sequence[Section] = ()
) -> str:
    """The whole page. view: what ``viewer.pack`` gave; faults: what is missing and why; more:
    sections that were asked for.
    """
    here = files("softact.report")
    spec = _spec(results)
    name = str(spec.get("name") or results.directory.resolve().name)
    told = origin.assumptions(spec)
    errors = mesh_error.read(results)
    faults = [*faults, errors.remark] if errors.remark else faults
    bars = {column: mesh_error.text(column, bar) for column, bar in errors.bars.items()}
    sections = [
        Section("figures", "Key figures", _figures(results, bars), "Figures"),
        *mesh_error.section(results, errors),
        *more,
        *([Section("view", "3-D view", _VIEW)] if view else []),
        Section("states", "Four loads", _states(results)),
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
        lead=_lead(results, spec, name, faults, bars),
        data={"view": view},
        style=(here / "style.css").read_text(encoding="utf-8"),
        script=(here / "report.js").read_text(encoding="utf-8"),
    )


def _spec(results: Results) -> dict:
    try:
        spec = yaml.safe_load(results.spec_yaml)
    except yaml.YAMLError:
        return {}
    return spec if isinstance(spec, dict) else {}


def _lead(results: Results, spec: dict, name: str, faults: list[str], bars: dict) -> str:
    """What stands above the contents: description, status, picture, cards. bars: column -> the
    error bar's text."""
    lines = []
    if spec.get("description"):
        lines.append(f"<p class='lead'>{escape(str(spec['description']))}</p>")
    if spec.get("source"):
        lines.append(f"<p class='source'>Source: {escape(str(spec['source']))}</p>")
    hero = _image(results.directory / "shape.png", f"{name} in its last state")
    lines += [
        _banner(results, faults),
        f"<section class='top'><div class='hero'>{hero}</div>"
        f"<div class='cards' aria-label='Figures at the last state'>{_cards(results, bars)}</div>"
        "</section>",
    ]
    return "\n".join(lines)


def _resolved(results: Results) -> str:
    return f"<h3>Resolved spec</h3><pre class='spec'>{escape(results.spec_yaml)}</pre>"


def _reached(results: Results) -> str:
    """Words for the last state."""
    if not results.curve or not len(load(results)):
        return "no equilibrium state at all"
    name, value = load_name(results), labels.number(load(results)[-1])
    said = f"{value} {labels.column(name).unit}" if name else f"load {value}"
    curve = results.curve
    if "step" in curve:
        part = f" at {100 * curve['step_fraction'][-1]:.4g} %" if "step_fraction" in curve else ""
        said += f" (step “{curve['step'][-1]}”{part})"
    if "bending_angle_deg" in curve:
        said += f", bending angle {labels.number(curve['bending_angle_deg'][-1])}°"
    return said


def _banner(results: Results, faults: list[str]) -> str:
    reached = escape(_reached(results))
    if results.status == COMPLETE:
        kind, head = "good", "Complete."
        text = f"All steps were solved; the last state is at {reached}."
    elif results.status == NO_EQUILIBRIUM:
        kind, head = "warn", "No equilibrium found beyond this point."
        text = f"The solver reached {reached} and found no further equilibrium."
    else:
        kind, head = "bad", "Incomplete."
        text = f"The run has not ended, or was stopped; so far: {reached}."
    messages = [str(m) for m in results.run.get("messages") or []] + faults
    return base.banner(kind, head, text, messages)


def _image(path: Path, alt: str) -> str:
    return base.image(path.read_bytes(), alt) if path.is_file() else ""


def _cards(results: Results, bars: dict[str, str]) -> str:
    """The last state's figures that a reader looks for first, as large numbers."""
    curve = results.curve
    wanted = [load_name(results)] if load_name(results) else []
    wanted += ["bending_angle_deg", "twist_angle_deg", "elongation_mm"]
    wanted += [n for n in curve if n.startswith("cavity_volume")]
    wanted += ["max_principal_stress_MPa", "max_principal_stretch"]
    shown = [n for n in dict.fromkeys(wanted) if n in curves.measures(results)]
    extra = {k: v for k, v in results.summary.items() if k not in curve and "." not in k}
    shown_extra = [k for k in ("failure_pressure_kPa", "blocked_force_N") if k in extra]
    cards = [_card(n, curve[n][-1], _where(results, n), bars.get(n, "")) for n in shown]
    cards += [_card(n, extra[n], "") for n in shown_extra if isinstance(extra[n], float)]
    return "".join(cards)


def _card(name: str, value: float, note: str, error: str = "") -> str:
    label = labels.column(name)
    return base.card(label.name, labels.number(value * label.factor), label.unit, note, error)


def _where(results: Results, name: str) -> str:
    """Where a largest value lies, if the run says."""
    stem = name.removesuffix("_MPa")
    places = [results.curve.get(f"{stem}_{axis}_mm") for axis in "xyz"]
    if not name.startswith("max_") or any(p is None or p.dtype != float for p in places):
        return ""
    return "at x, y, z = " + ", ".join(f"{p[-1]:.1f}" for p in places) + " mm (undeformed)"


def _figures(results: Results, bars: dict[str, str]) -> str:
    heads, rows = curves.key_figures(results, bars)
    if not rows:
        return "<p>There is no accepted increment, so there are no figures.</p>"
    head = "".join(f"<th scope='col'>{escape(text)}</th>" for text in heads)
    body = "".join(
        f"<tr><th scope='row'>{escape(name)}</th><td class='unit'>{escape(unit)}</td>"
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
        "<div class='scroll'><table class='figures'><thead><tr><th scope='col'>Figure</th>"
        f"<th scope='col'>Unit</th>{head}</tr></thead><tbody>{body}</tbody></table></div>"
        "<p class='note'>Figures are of the whole actuator. Between accepted increments they are "
        f"interpolated linearly; the last column is a computed state.{told} {link}</p>"
    )


def _states(results: Results) -> str:
    image = _image(results.directory / "states.png", "The actuator at four loads")
    if not image:
        return "<p>There are no pictures; the note at the top of this page says why.</p>"
    return (
        f"<figure><div class='scroll wide'>{image}</div><figcaption>Deformed actuator at four "
        "loads, to scale, one colour range for all; the grey outline is the undeformed "
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

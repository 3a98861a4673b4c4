"""The text of report.html: one file that needs nothing else, not even a network."""

import base64
import gzip
import json
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template

import numpy as np
import yaml

from softact.report import curves, labels
from softact.report.view import load, load_name
from softact.results import COMPLETE, NO_EQUILIBRIUM, Results

_RESTS_ON = (
    ("Gmsh", "Geuzaine and Remacle 2009", "10.1002/nme.2579"),
    ("DOLFINx", "Baratta et al. 2023", "10.5281/zenodo.10447666"),
    ("MUMPS", "Amestoy et al. 2001", "10.1137/S0895479899358194"),
)


def html(results: Results, view: dict | None, faults: list[str]) -> str:
    """The whole page. view: what ``viewer.pack`` gave; faults: what is missing and why."""
    here = files("softact.report")
    spec = _spec(results)
    name = str(spec.get("name") or results.directory.resolve().name)
    parts = {
        "title": escape(name),
        "description": _paragraphs(spec),
        "style": (here / "style.css").read_text(encoding="utf-8"),
        "banner": _banner(results, faults),
        "hero": _image(results.directory / "shape.png", f"{name} in its last state"),
        "cards": _cards(results),
        "figures": _figures(results),
        "states": _states(results),
        "history": _history(results),
        "assumptions": _assumptions(spec),
        "spec": escape(results.spec_yaml),
        "provenance": _provenance(results),
        "cite": _cite(results, name),
        "viewer": "" if view else " hidden",
        "data": _json({"view": view, "charts": _charts(results), "history": _convergence(results)}),
        "plotly": _plotly(),
        "script": (here / "report.js").read_text(encoding="utf-8"),
    }
    return Template((here / "page.html").read_text(encoding="utf-8")).substitute(parts)


def _spec(results: Results) -> dict:
    try:
        spec = yaml.safe_load(results.spec_yaml)
    except yaml.YAMLError:
        return {}
    return spec if isinstance(spec, dict) else {}


def _paragraphs(spec: dict) -> str:
    lines = []
    if spec.get("description"):
        lines.append(f"<p class='lead'>{escape(str(spec['description']))}</p>")
    if spec.get("source"):
        lines.append(f"<p class='source'>Source: {escape(str(spec['source']))}</p>")
    return "\n".join(lines)


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
    listed = "".join(f"<li>{escape(message)}</li>" for message in messages)
    more = f"<ul>{listed}</ul>" if listed else ""
    return f"<div class='banner {kind}' role='status'><strong>{head}</strong> {text}{more}</div>"


def _image(path: Path, alt: str) -> str:
    if not path.is_file():
        return ""
    data = base64.b64encode(path.read_bytes()).decode()
    return f"<img src='data:image/png;base64,{data}' alt='{escape(alt, quote=True)}'>"


def _cards(results: Results) -> str:
    """The last state's figures that a reader looks for first, as large numbers."""
    curve = results.curve
    wanted = [load_name(results)] if load_name(results) else []
    wanted += ["bending_angle_deg", "twist_angle_deg", "elongation_mm"]
    wanted += [n for n in curve if n.startswith("cavity_volume")]
    wanted += ["max_principal_stress_MPa", "max_principal_stretch"]
    shown = [n for n in dict.fromkeys(wanted) if n in curves.measures(results)]
    extra = {k: v for k, v in results.summary.items() if k not in curve and "." not in k}
    shown_extra = [k for k in ("failure_pressure_kPa", "blocked_force_N") if k in extra]
    cards = [_card(n, curve[n][-1], _where(results, n)) for n in shown]
    cards += [_card(n, extra[n], "") for n in shown_extra if isinstance(extra[n], float)]
    return "".join(cards)


def _card(name: str, value: float, note: str) -> str:
    label = labels.column(name)
    unit = f"&nbsp;<span class='unit'>{escape(label.unit)}</span>" if label.unit else ""
    unit = "°" if label.unit == "°" else unit
    note = f"<div class='note'>{escape(note)}</div>" if note else ""
    return (
        f"<div class='card'><div class='name'>{escape(label.name)}</div>"
        f"<div class='value'>{labels.number(value * label.factor)}{unit}</div>{note}</div>"
    )


def _where(results: Results, name: str) -> str:
    """Where a largest value lies, if the run says."""
    stem = name.removesuffix("_MPa")
    places = [results.curve.get(f"{stem}_{axis}_mm") for axis in "xyz"]
    if not name.startswith("max_") or any(p is None or p.dtype != float for p in places):
        return ""
    return "at x, y, z = " + ", ".join(f"{p[-1]:.1f}" for p in places) + " mm (undeformed)"


def _figures(results: Results) -> str:
    heads, rows = curves.key_figures(results)
    if not rows:
        return "<p>There is no accepted increment, so there are no figures.</p>"
    head = "".join(f"<th scope='col'>{escape(text)}</th>" for text in heads)
    body = "".join(
        f"<tr><th scope='row'>{escape(name)}</th><td class='unit'>{escape(unit)}</td>"
        + "".join(f"<td>{escape(text)}</td>" for text in texts)
        + "</tr>"
        for name, unit, texts in rows
    )
    download = _download(results.directory / "curve.csv", "text/csv")
    return (
        "<div class='scroll'><table class='figures'><thead><tr><th scope='col'>Figure</th>"
        f"<th scope='col'>Unit</th>{head}</tr></thead><tbody>{body}</tbody></table></div>"
        "<p class='note'>Figures are of the whole actuator. Between accepted increments they are "
        f"interpolated linearly; the last column is a computed state. {download}</p>"
    )


def _download(path: Path, kind: str) -> str:
    if not path.is_file():
        return ""
    data = base64.b64encode(path.read_bytes()).decode()
    return f"<a download='{path.name}' href='data:{kind};base64,{data}'>Download {path.name}</a>"


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


def _charts(results: Results) -> list[dict]:
    def numbers(values: np.ndarray) -> list[float | None]:
        return [float(f"{v:.7g}") if np.isfinite(v) else None for v in values]

    return [
        {
            "title": chart.title, "x": chart.x, "y": chart.y, "equal": chart.equal,
            "series": [
                {"name": name, "x": numbers(x), "y": numbers(y), "colour": colour}
                for colour, (name, x, y) in zip(curves.COLOURS * 3, chart.series, strict=False)
            ],
        }
        for chart in curves.charts(results)
    ]  # fmt: skip


def _convergence(results: Results) -> list[dict]:
    """Attempted increments, as run.json has them, for the script."""
    return [
        {
            "step": str(item.get("step", "")),
            "fraction": item.get("fraction"),
            "iterations": int(item.get("iterations") or 0),
            "converged": bool(item.get("converged")),
            "residuals": [r for r in item.get("residuals") or [] if r],
        }
        for item in results.run.get("history") or []
    ]


def _history(results: Results) -> str:
    history = _convergence(results)
    if not history:
        return "<p>This run recorded no history of its iterations.</p>"
    failed = sum(not item["converged"] for item in history)
    total = sum(item["iterations"] for item in history)
    return (
        f"<p>{len(history)} increments were tried, {failed} of them without success (cut back or "
        f"given up); {total} Newton iterations in all.</p>"
    )


def _assumptions(spec: dict) -> str:
    items = spec.get("assumptions") or []
    if not isinstance(items, list) or not items:
        return ""
    listed = "".join(f"<li>{escape(str(item))}</li>" for item in items)
    return (
        "<div class='assumptions'><h3>Assumptions</h3><p>What the source leaves open and the spec "
        f"had to fill in:</p><ul>{listed}</ul></div>"
    )


def _provenance(results: Results) -> str:
    run = results.run
    plain = {k: v for k, v in run.items() if not isinstance(v, dict | list) and v is not None}
    tables = [_table("Run", plain)]
    heads = {"times_s": "Times (s)", "mesh": "Mesh", "counts": "Counts", "versions": "Versions"}
    for key, value in run.items():
        if isinstance(value, dict) and value:
            tables.append(_table(heads.get(key, key.replace("_", " ").capitalize()), value))
    return f"<div class='tables'>{''.join(tables)}</div>"


def _table(title: str, items: dict) -> str:
    rows = "".join(
        f"<tr><th scope='row'>{escape(str(key).replace('_', ' '))}</th>"
        f"<td>{escape(_text(value))}</td></tr>"
        for key, value in items.items()
    )
    return f"<div><h3>{escape(title)}</h3><table>{rows}</table></div>"


def _text(value) -> str:
    if isinstance(value, float):
        return labels.number(value)
    if isinstance(value, int) and not isinstance(value, bool):
        return f"{value:,}".replace(",", " ")
    return value if isinstance(value, str) else json.dumps(value)


def _cite(results: Results, name: str) -> str:
    run = results.run
    version = run.get("softact") or run.get("softact_version") or run.get("version") or ""
    commit = run.get("git_commit") or run.get("commit") or ""
    which = " ".join(filter(None, [f"softact {version}".strip(), commit and f"({commit})"]))
    mark = f", spec hash {run['spec_hash']}" if run.get("spec_hash") else ""
    rests = "; ".join(f"{tool}: {who}, doi:{doi}" for tool, who, doi in _RESTS_ON)
    processes = f" -n {run['processes']}" if run.get("processes") else ""
    command = f"softact run spec.yaml{processes} -o results/{name}"
    return (
        f"<p>Compute it again from the spec on this page "
        f"({_download(results.directory / 'spec.yaml', 'text/yaml')}):</p>"
        f"<pre class='command'>{escape(command)}</pre>"
        f"<p>Cite as: “{escape(name)}”, computed with {escape(which)}{escape(mark)}. "
        f"Cite also what it rests on: {escape(rests)}.</p>"
    )


def _json(data: dict) -> str:
    """JSON that may stand in a script element."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _plotly() -> str:
    """plotly.js as base64 of gzip: 2 MB instead of 5."""
    source = files("plotly") / "package_data" / "plotly.min.js"
    return base64.b64encode(gzip.compress(source.read_bytes(), 9, mtime=0)).decode()

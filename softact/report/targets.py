"""Published applications beside an actuator: which of their requirements does it meet?"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np

from softact.errors import SpecError
from softact.files import document
from softact.nearest import nearest
from softact.report import base, body, labels
from softact.report.base import Plot, Section
from softact.report.base.templates import macros
from softact.report.curves import at_load
from softact.report.targets_file import Asked, TargetsFile, in_unit_of
from softact.results.folder import Results, load, load_name
from softact.spec.faults import validated

if TYPE_CHECKING:
    from softact.results.folder import Results

MET, NOT_MET, UNKNOWN = "met", "not met", "not known"
_DERIVED = {
    "size_mm": labels.Label("Largest dimension, undeformed", "mm"),
    "profile_mm": labels.Label("Profile, undeformed", "mm"),
    "whole_bending_deg": labels.Label("Bending of the whole length", "°"),
    "mass_kg": labels.Label("Mass without layers", "kg"),
    "extension_percent": labels.Label("Extension of the length", "%"),
    "contraction_percent": labels.Label("Contraction of the length", "%"),
}


@dataclass(frozen=True)
class Requirement:
    """A published requirement. text: as printed. figure: what of a run tells it, "" where nothing
    does; bound: in the unit of the figure; least: whether it is a lower bound; at: kPa or None;
    together: figures and values to be reached in the same state.
    """

    text: str
    source: str
    figure: str = ""
    bound: float = 0.0
    least: bool = True
    at: float | None = None
    together: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class Verdict:
    """What a run says of a requirement. found: in the unit of the figure, NaN if unknown."""

    requirement: Requirement
    verdict: str
    found: float
    why: str

    @property
    def fulfilment(self) -> float:
        """Percent of what is asked; 100 is just met. NaN where the run does not tell."""
        r = self.requirement
        if not r.bound or not np.isfinite(self.found):
            return float("nan")
        return 100 * (self.found / r.bound if r.least else r.bound / max(self.found, 1e-12))


@cache
def _file() -> TargetsFile:
    text = (files("softact.report") / "targets.yaml").read_text(encoding="utf-8")
    return validated(document.parse(text, "targets.yaml"), TargetsFile)


def names() -> list[str]:
    """Names of the applications that are known."""
    return list(_file().targets)


def check(wanted: Sequence[str]) -> None:
    """Raise SpecError, a line for each name that is no application."""
    unknown = [name for name in wanted if name not in names()]
    if unknown:
        raise SpecError(*(f"--targets {name}: {nearest(name, names())}" for name in unknown))


def title(name: str) -> str:
    """What an application is called."""
    return _file().targets[name].title


def requirements(name: str) -> list[Requirement]:
    """The requirements of an application."""
    return [_requirement(entry) for entry in _file().targets[name].requirements]


def _requirement(asked: Asked) -> Requirement:
    source, figure, bound = _file().sources[asked.source].short, asked.figure, asked.bound
    if bound is None:
        return Requirement(asked.text, source)
    return Requirement(
        asked.text, source, figure, in_unit_of(figure, bound), asked.at_least is not None,
        in_unit_of("pressure_kPa", asked.at) if asked.at else None,
        tuple((name, in_unit_of(name, text)) for name, text in asked.together.items()),
    )  # fmt: skip


def judge(results: Results, requirement: Requirement) -> Verdict:
    """Whether a run shows that a requirement is met."""
    r, nothing = requirement, float("nan")
    if not r.figure:
        return Verdict(r, UNKNOWN, nothing, "no figure of a run tells this")
    values = figure_values(results, r.figure)
    if values is None:
        return Verdict(r, UNKNOWN, nothing, f"the run has no {label(r.figure).name.lower()}")
    if not isinstance(values, np.ndarray) or values.ndim == 0:
        return _verdict(r, float(values), "")
    states, where = _states(results, r)
    if where and not len(states):
        return Verdict(r, UNKNOWN, nothing, where)
    found, at = _found(results, r, values, states)
    short = where or f"the most in this run, {at}"
    verdict = _verdict(r, found, short if found < r.bound else at)
    if verdict.verdict == NOT_MET and where:
        return Verdict(r, UNKNOWN, found, where)
    return verdict


def _verdict(r: Requirement, found: float, why: str) -> Verdict:
    met = found >= r.bound * (1 - 1e-9) if r.least else found <= r.bound * (1 + 1e-9)
    return Verdict(r, MET if met else NOT_MET, found, why)


def _states(results: Results, r: Requirement) -> tuple[np.ndarray, str]:
    """Rows that may show the requirement, and why they may not be enough."""
    loads, why = load(results), ""
    rows = np.arange(len(loads))
    for name, bound in r.together:
        beside = figure_values(results, name)
        if beside is None or np.max(beside) < bound:
            most = "unknown" if beside is None else f"{np.max(beside):.0f}"
            return rows[:0], f"asked for at {bound:g}°; the run bends to {most}°"
        rows = rows[np.broadcast_to(beside, loads.shape)[rows] >= bound]
    if r.at is not None:
        if load_name(results) is None:
            return rows[:0], f"asked for at {r.at:g} kPa; the run has no pressure"
        if loads.max() < r.at * (1 - 1e-9):
            why = f"asked for at {r.at:g} kPa; the run ends at {loads.max():.4g} kPa"
        rows = rows[loads[rows] <= r.at * (1 + 1e-9)]
        if not len(rows) and not why:
            why = f"at {r.at:g} kPa the run has not reached what is asked beside it"
    return rows, why


def _found(
    results: Results, r: Requirement, values: np.ndarray, states: np.ndarray
) -> tuple[float, str]:
    """The largest value in those states, or at the very pressure between two of them."""
    loads = load(results)
    best = states[np.argmax(values[states])]
    found, at = float(values[best]), float(loads[best])
    if r.at is not None and not r.together:
        there = at_load(results, values, r.at)
        if np.isfinite(there) and there > found:
            found, at = there, r.at
    name = load_name(results)
    unit = labels.column(name).unit if name else ""
    return found, f"at {labels.number(at)} {unit}".strip()


def figure_values(results: Results, name: str) -> np.ndarray | float | None:
    """A column of the curve, or a figure of the undeformed body; None where it is not there."""
    if name == "size_mm":
        size = body.extent(results)
        return None if size is None else float(size.max())
    if name == "profile_mm":
        return body.profile(results)
    if name == "mass_kg":
        return body.mass(results)
    if name == "whole_bending_deg":
        return body.whole_bending(results)
    if name in ("extension_percent", "contraction_percent"):
        length = results.layout.length
        if not length or "elongation_mm" not in results.curve:
            return None
        sign = 1 if name.startswith("extension") else -1
        return sign * 100 * results.curve["elongation_mm"] / length
    values = results.curve.get(name)
    return None if values is None or values.dtype != float else values


def label(figure: str) -> labels.Label:
    """How a figure is called, and in which unit it is shown."""
    return _DERIVED.get(figure) or labels.column(figure)


def tell(name: str, verdicts: Sequence[Verdict]) -> list[str]:
    """Plain lines: a head and a line for each requirement."""
    counts = {kind: sum(v.verdict == kind for v in verdicts) for kind in (MET, NOT_MET, UNKNOWN)}
    said = ", ".join(f"{count} {kind}" for kind, count in counts.items() if count)
    lines = [f"{title(name)}: {said}"]
    for v in verdicts:
        found = f": {found_text(v)}" if np.isfinite(v.found) else ""
        why = f" ({v.why})" if v.why else ""
        lines.append(f"  {v.verdict}: {v.requirement.text}{found}{why}")
    return lines


def found_text(v: Verdict) -> str:
    """What was found, with its unit."""
    shown = label(v.requirement.figure)
    return f"{labels.number(v.found * shown.factor)} {shown.unit}".strip().replace(" °", "°")


def section(results: Results, wanted: Sequence[str]) -> Section:
    """The part of a report that sets the actuator among published requirements."""
    parts = []
    for name in wanted:
        verdicts = [judge(results, r) for r in requirements(name)]
        heads = ["Requirement", "Verdict", "Found", "Remark", "Source"]
        rows = [
            [v.requirement.text, v.verdict, found_text(v) if np.isfinite(v.found) else "",
             v.why, v.requirement.source]
            for v in verdicts
        ]  # fmt: skip
        marks = [{MET: "good", NOT_MET: "bad"}.get(v.verdict, "") for v in verdicts]
        table = base.table(heads, rows, file=f"targets_{name}.csv", marks=marks)
        plots = [_fulfilment(name, verdicts), _space(results, name)]
        parts.append((title(name), base.figures([plot for plot in plots if plot]), table))
    body = macros("report/sections.html").requirements(
        "What published applications ask for, in their words, and what this run shows. “Not known” "
        "is what the run does not tell, or not up to the pressure that is asked for.",
        parts,
        sources="; ".join(source.full for source in _file().sources.values()),
    )
    return Section("targets", "Published requirements", body, "Requirements")


def _fulfilment(name: str, verdicts: Sequence[Verdict]) -> Plot | None:
    known = [v for v in verdicts if np.isfinite(v.fulfilment)]
    if not known:
        return None
    texts = [textwrap.shorten(v.requirement.text, 36, placeholder=" …") for v in known]
    colours = [{MET: "@good", NOT_MET: "@bad"}.get(v.verdict, "@warn") for v in known]
    line = {
        "type": "line", "x0": 100, "x1": 100, "yref": "paper", "y0": 0, "y1": 1,
        "line": {"color": "@ink", "width": 1.5, "dash": "dot"},
    }  # fmt: skip
    ticks = {"type": "log", "tickvals": [1, 10, 30, 100, 300, 1000, 3000, 10000]}
    names_of_bars = {"title": {"text": ""}, "type": "category", "autorange": "reversed"}
    return base.bars(
        f"{title(name)}: how far each is met", "% of what is asked", "Requirement",
        texts, [v.fulfilment for v in known], colours=colours, wide=True,
        layout={"shapes": [line], "xaxis": ticks, "yaxis": names_of_bars},
        note="100 % is just met; for an upper bound, what is allowed over what there is.",
    )  # fmt: skip


def _space(results: Results, name: str) -> Plot | None:
    """Blocked force over size, as Agarwal's Fig. 3g has it, with what Fig. 1a asks for."""
    force, size = (figure_values(results, f) for f in ("blocked_force_N", "size_mm"))
    traces = []
    for other in names():
        asked = {r.figure: r.bound for r in requirements(other)}
        if not {"blocked_force_N", "size_mm"} <= set(asked):
            continue
        colour = "@c2" if other == name else "@c8"
        marker = {"size": 11 if other == name else 8, "symbol": "circle"}
        point = [asked["size_mm"]], [asked["blocked_force_N"]]
        more: dict[str, Any] = {
            "showlegend": False, "text": [title(other)], "marker": marker,
            "hovertemplate": "%{text}: %{y:.3~g} N, %{x:.3~g} mm<extra></extra>",
        }  # fmt: skip
        traces.append(base.xy(title(other), *point, colour=colour, mode="markers", **more))
    note = "Grey: other applications of Agarwal’s Fig. 1a (point at one for its name)."
    if force is not None and size is not None:
        marker = {"size": 13, "symbol": "star"}
        traces.append(
            base.xy("This actuator", [np.max(size)], [np.max(force)], colour="@c1", mode="markers",
                    marker=marker, showlegend=False)
        )  # fmt: skip
        note += " The star is this actuator, at its largest blocked force."
    else:
        note += " This run has no blocked force, so the actuator is not among them."
    axes = "Largest dimension (mm)", "Blocked force (N)"
    return base.lines("Blocked force and size asked for", *axes, traces, note=note, wide=True)

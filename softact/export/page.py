"""reduced.html: the reduced model over the states that it is compared with."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from markupsafe import Markup

from softact.export import FORMATS, reduced, statement
from softact.export.errors import Deviation
from softact.export.job import Job
from softact.export.to_json import document
from softact.files.text import write_atomic
from softact.report import base
from softact.report.base import Plot, Section
from softact.report.base.templates import macros
from softact.results.own_folder import Output

PAGE = "reduced.html"
TITLES = {"bending_y": "bending", "bending_z": "bending across", "twist": "twist",
          "stretch": "stretch"}  # fmt: skip
#: What turns by less is straight (degrees).
STRAIGHT = 1.0


def files(job: Job, formats: Sequence[str]) -> dict[str, str | bytes]:
    """Name -> content of a model in formats, and of its page. Raises SpecError."""
    found: dict[str, str | bytes] = {}
    for name in dict.fromkeys(formats):
        found |= FORMATS[name].files(job)
    return found | {PAGE: html(job)}


def write(made: Mapping[str, str | bytes], folder: Output) -> list[Path]:
    """Write files into a folder that is held; their paths. Raises SpecError."""
    for name, content in made.items():
        write_atomic(folder.file(name), content)
    return [folder.directory / name for name in made]


def html(job: Job) -> str:
    """The text of the page."""
    model, pieces = job.model, macros("export/reduced_page.html")
    warned = statement.warnings(model)
    first = "bending angle" if _bends(job) else "tip's place"
    (shown,) = [deviation for deviation in job.seen if deviation.name == first]
    told = f"From the {model.origin.beside}, {shown.text()}."
    made = "Fitted." if model.origin.fitted else "Of the module, nothing fitted."
    kind, head = ("warn", "Not all of it is fitted.") if warned else ("good", made)
    shown_states = pieces.states(base.figures(_over_states(job)), model.origin.beside)
    sections = [
        Section(
            "states",
            "Model and states",
            shown_states,
            "States",
        ),
        Section("deviations", "Deviations", _deviations(job), "Deviations"),
        Section("law", "What follows the pressure", base.figures(_law(job)), "Law"),
        Section("about", "What it is and what is assumed", pieces.about(job.about), "About"),
    ]
    return base.page(
        model.data["name"],
        sections,
        kicker="Reduced model of a soft actuator",
        kind="reduced model",
        lead=base.banner(kind, head, told, warned),
    )


def _bends(job: Job) -> bool:
    return bool(np.degrees(np.abs(job.model.states.turned[:, 1:])).max() > STRAIGHT)


def _cases(job: Job) -> Iterator[tuple[str, np.ndarray]]:
    """Name and states of each run, by the force on the tip in its last state."""
    found = job.model.states
    seen: Counter[str] = Counter()
    for number in np.unique(found.run):
        chosen = np.flatnonzero(found.run == number)
        if not len(chosen):
            continue
        force = found.force[chosen[-1]]
        name = "no force on the tip"
        if np.any(force):
            name = "tip force " + ", ".join(f"{v:.3g}" for v in force) + " N"
        seen[name] += 1
        yield (f"{name} ({seen[name]})" if seen[name] > 1 else name), chosen


def _over_states(job: Job) -> list[Plot]:
    model, found = job.model, job.model.states
    shapes = reduced.shapes(model.rod, found, reduced.strains(found, model.data))
    seen = model.rod.figures(found.pressure, shapes)
    turned = np.degrees(found.turned)
    angle = turned[:, 1]
    if "bending_z" in model.data["components"]:
        angle = np.hypot(turned[:, 1], turned[:, 2])
    pairs = []
    if _bends(job):
        pairs.append(("Bending angle", "Bending angle (°)", angle, seen["bending_angle_deg"]))
    pairs += [
        ("Tip along x", "x (mm)", found.tip[:, 0], seen["tip_x_mm"]),
        ("Tip along z", "z (mm)", found.tip[:, 2], seen["tip_z_mm"]),
        ("Cavity volume", "Volume (mL)", 1e-3 * found.volume, 1e-3 * seen["cavity_volume_mm3"]),
    ]
    if "twist" in model.data["components"]:
        pairs.append(("Twist", "Twist (°)", turned[:, 0], seen["twist_angle_deg"]))
    return [_plot(job, *pair) for pair in pairs]


def _plot(job: Job, title: str, label: str, solved: np.ndarray, model: np.ndarray) -> Plot:
    traces, beside = [], job.model.origin.beside
    for number, (name, chosen) in enumerate(_cases(job)):
        colour, x = f"@c{number % 6 + 1}", job.model.states.pressure[chosen]
        traces.append(
            base.xy(f"{name}: {beside}", x, solved[chosen], colour=colour, mode="markers",
                    showlegend=False)
        )  # fmt: skip
        traces.append(base.xy(name, x, model[chosen], colour=colour, mode="lines"))
    return base.lines(title, "Pressure (kPa)", label, traces)


def _law(job: Job) -> list[Plot]:
    table, plots = document(job)["table"], []
    for name in job.model.data["components"]:
        if name == "stretch":
            wanted = [("elongation_mm", "Elongation without a load", "mm")]
        else:
            wanted = [
                (f"{name}_angle_deg", f"Angle of {TITLES[name]} without a load", "°"),
                (f"{name}_stiffness_Nmm_per_rad", f"Stiffness of {TITLES[name]}", "N·mm/rad"),
                (f"{name}_blocked_moment_Nmm", f"Moment that holds it: {TITLES[name]}", "N·mm"),
            ]
        if name.startswith("bending"):
            wanted.append((f"{name}_blocked_force_N", "Force that holds its tip", "N"))
        for column, title, unit in wanted:
            trace = base.xy(title, table["pressure_kPa"], table[column], mode="lines")
            plots.append(base.lines(title, "Pressure (kPa)", unit, [trace]))
    return plots


def _deviations(job: Job) -> Markup:
    origin = job.model.origin
    states = "the states it was fitted to" if origin.fitted else origin.beside
    groups: list[tuple[str, Sequence[Deviation]]] = [(states, job.seen)]
    if job.unseen:
        groups.append((job.unseen[0], job.unseen[1]))
    rows: list[list[str | float | None]] = [
        [which, d.name, d.largest, d.rms, d.unit, f"{d.percent:.2g} % of {d.of}"]
        for which, found in groups
        for d in found
    ]
    return base.table(
        ["Compared with", "Figure", "Largest", "Root mean square", "Unit", "Largest, relative"],
        rows, file="reduced_deviations.csv",
    )  # fmt: skip

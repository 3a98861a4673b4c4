"""Error bars of the mesh in a data sheet, which ``softact converge --into`` carried into it."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field

from markupsafe import Markup

from softact.report import base, labels
from softact.report.base import Section
from softact.report.base.templates import macros
from softact.results.folder import MESH_ERROR, Results
from softact.verdict.judge import NOT_CONVERGED, NOT_KNOWN, WITHIN

#: Colour and head of what a study says: see ``softact.converge.study``.
HEADS = {
    WITHIN: ("good", "Converged."),
    NOT_KNOWN: ("warn", "Not known."),
    NOT_CONVERGED: ("bad", "Not converged."),
}


@dataclass(frozen=True)
class MeshErrors:
    """bars: column -> error bar of the last state's value, in the column's unit, of those that are
    known. story: what mesh_error.json holds. fault: why the file is there and cannot be used, ""
    otherwise."""

    bars: Mapping[str, float] = field(default_factory=dict)
    story: Mapping = field(default_factory=dict)
    fault: str = ""

    def worded(self, text: str) -> str:
        """A text with the names of the study's columns as people say them."""
        for name in self.story.get("measures", ()):
            text = text.replace(name, spoken(name))
        return text


def read(results: Results) -> MeshErrors:
    """The error bars of a result folder; none where no study was carried into it."""
    path = results.directory / MESH_ERROR
    if not path.is_file():
        return MeshErrors()
    try:
        story = json.loads(path.read_text(encoding="utf-8"))
        if "verdict" not in story and "levels" in story:
            return MeshErrors(fault=f"{MESH_ERROR} is of an older softact; carry a study in again")
        bars = {str(name): float(bar) for name, bar in story["error_bars"].items()}
        spec_hash = story["levels"][story["level"]]["spec_hash"]
        found = MeshErrors(bars, story)
        _body(results, story)
        found.worded("")
    except (OSError, ValueError, KeyError, IndexError, TypeError, AttributeError):
        return MeshErrors(fault=f"{MESH_ERROR} cannot be read: softact converge --into writes it")
    if spec_hash != results.run.get("spec_hash"):
        return MeshErrors(fault=f"{MESH_ERROR} belongs to another spec; it is left out")
    return found


def text(name: str, bar: float) -> str:
    """``± 0.52`` in the unit in which the column is shown."""
    return f"± {labels.number(bar * labels.column(name).factor, digits=2)}"


def spoken(column: str) -> str:
    """What a column is called in a sentence: "bending angle"."""
    name = labels.column(column).name
    return name[:1].lower() + name[1:]


def words(verdict: str, tolerance: float) -> str:
    """A verdict in a table: "not known", "not converged", "within 5 % of the limit"."""
    if verdict != WITHIN:
        return verdict
    return f"within {labels.number(100 * tolerance)} % of the limit"


def section(results: Results, errors: MeshErrors) -> list[Section]:
    """What is known of the mesh's error and what that rests on; no section without a study."""
    if not errors.story:
        return []
    body = _body(results, errors.story)
    return [Section("mesherror", "Error bars of the mesh", body, "Mesh error")]


def _body(results: Results, story: Mapping) -> Markup:
    rows = [_row(results, story, name) for name in story["measures"]]
    heads = ["Figure", "Unit", "This mesh", "Error bar", "Limit", "Order", "This mesh is", "Note"]
    levels = [str(level["mesh"]) for level in story["levels"]]
    advice = "No mesh of the study is known to be within it for every figure."
    if story["recommended"] is not None:
        advice = f"The coarsest mesh within it for every figure: {levels[story['recommended']]}."
    return macros("report/sections.html").mesh_error(
        level=levels[story["level"]],
        levels=levels,
        tolerance=labels.number(100 * story["tolerance"]),
        advice=advice,
        table=base.table(heads, rows, file="mesh_error.csv"),
        safety=labels.number(story["safety"]),
    )


def note(safety: float) -> Markup:
    """What an error bar is, as a paragraph. safety: the factor in it."""
    return macros("report/sections.html").error_bar(labels.number(safety))


def _row(results: Results, story: Mapping, name: str) -> list[str | float]:
    label, found = labels.column(name), story["measures"][name]
    value = float(results.curve[name][-1]) * label.factor
    order = "none" if found["order"] is None else f"{found['order']:.2f}"
    bar, limit = (
        "not known" if x is None else x * label.factor
        for x in (story["error_bars"].get(name), found["limit"])
    )
    verdict = words(found["verdict"], story["tolerance"])
    return [label.name, label.unit, value, bar, limit, order, verdict, str(found["note"])]

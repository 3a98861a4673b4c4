"""Error bars of the mesh in a data sheet, which ``softact converge --into`` carried into it."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from html import escape

from softact.report import base, labels
from softact.report.base import Section
from softact.results import MESH_ERROR, Results


@dataclass(frozen=True)
class MeshErrors:
    """bars: column -> error bar of the last state's value, in the column's unit. story: what
    mesh_error.json holds. fault: why the file is there and cannot be used, "" otherwise."""

    bars: Mapping[str, float] = field(default_factory=dict)
    story: Mapping = field(default_factory=dict)
    fault: str = ""


def read(results: Results) -> MeshErrors:
    """The error bars of a result folder; none where no study was carried into it."""
    path = results.directory / MESH_ERROR
    if not path.is_file():
        return MeshErrors()
    try:
        story = json.loads(path.read_text(encoding="utf-8"))
        bars = {str(name): float(bar) for name, bar in story["error_bars"].items()}
        spec_hash = story["levels"][story["level"]]["spec_hash"]
        _body(results, bars, story)
    except (OSError, ValueError, KeyError, IndexError, TypeError, AttributeError):
        return MeshErrors(fault=f"{MESH_ERROR} cannot be read: softact converge --into writes it")
    if spec_hash != results.run.get("spec_hash"):
        return MeshErrors(fault=f"{MESH_ERROR} belongs to another spec; it is left out")
    return MeshErrors(bars, story)


def text(name: str, bar: float) -> str:
    """``± 0.52`` in the unit in which the column is shown."""
    return f"± {labels.number(bar * labels.column(name).factor, digits=2)}"


def section(results: Results, errors: MeshErrors) -> list[Section]:
    """The error bars with what they rest on; no section where there are none."""
    if not errors.bars:
        return []
    body = _body(results, errors.bars, errors.story)
    return [Section("mesherror", "Error bars of the mesh", body, "Mesh error")]


def _body(results: Results, bars: Mapping[str, float], story: Mapping) -> str:
    rows = [_row(results, story, name) for name in bars]
    heads = ["Figure", "Unit", "This mesh", "Error bar", "Limit", "Order", "Note"]
    own = _sizes(story["levels"][story["level"]]["sizes_mm"])
    meshes = "; ".join(_sizes(level["sizes_mm"]) for level in story["levels"])
    advice = "No mesh of the study is within it for every figure."
    if story["recommended_mm"]:
        advice = f"The coarsest mesh within it for every figure: {_sizes(story['recommended_mm'])}."
    said = (
        f"<p>Last state, on the mesh of this run ({escape(own)}). From {len(story['levels'])} "
        f"meshes ({escape(meshes)}) that <code>softact converge</code> computed; wanted was "
        f"{labels.number(100 * story['tolerance'])} %. {escape(advice)}</p>"
    )
    return said + base.table(heads, rows, file="mesh_error.csv") + note(story["safety"])


def note(safety: float) -> str:
    """What an error bar is, as a paragraph. safety: the factor in it."""
    factor = labels.number(safety)
    return (
        f"<p class='note'>An error bar is {factor} times the distance to the limit on an "
        "infinitely fine mesh (Richardson's, with the observed order; Celik et al. 2008, J. Fluids "
        f"Eng. 130:078001). Where there is no order, it is {factor} times the largest distance to "
        "a finer mesh, and the limit is the finest mesh's value. It tells of the mesh alone, not "
        "of the material's constants or the geometry.</p>"
    )


def _row(results: Results, story: Mapping, name: str) -> list[str | float]:
    label, told = labels.column(name), story["measures"][name]
    value = float(results.curve[name][-1])
    order = "none" if told["order"] is None else f"{told['order']:.2f}"
    shown = [x * label.factor for x in (value, story["error_bars"][name], told["limit"])]
    return [label.name, label.unit, *shown, order, str(told["note"])]


def _sizes(sizes: Mapping[str, float]) -> str:
    return ", ".join(f"{name.replace('_', ' ')} {size:.4g} mm" for name, size in sizes.items())

"""The figures of a preview as rows of text, for the page, the picture and the terminal."""

from __future__ import annotations

from collections.abc import Iterator

from softact.geometry.walls import ENOUGH
from softact.preview.figures import POOR, Figures
from softact.preview.look import Preview


def rows(preview: Preview) -> Iterator[tuple[str, str]]:
    """Names and values, the most wanted first."""
    f = preview.figures
    if f is None:
        return
    yield "size", " x ".join(f"{side:.4g}" for side in f.size) + " mm"
    yield "mesh", f"{f.cells} {f.kind}, {f.nodes} nodes, {f.unknowns} unknowns"
    yield "quality", _quality(f)
    for name, value in f.volumes.items():
        unit = "mm^3" if f.kind == "tetrahedra" else "mm^2"
        yield f"{'volume' if unit == 'mm^3' else 'area'} of {name}", f"{value:.4g} {unit}"
    if f.walls:
        thin = min(f.walls, key=lambda wall: wall.thickness)
        yield (
            "thinnest wall",
            f"{thin.name}, {thin.thickness:g} mm, {_elements(thin.elements)} through it",
        )
    for t in f.thickness:
        lengths = "" if f.walls else f", {t.elements:.1f} edges of elements there"
        said = f"{t.thinnest:.3g} mm at least{lengths}, median {t.median:.3g} mm"
        yield f"walls of {t.cavity}", said
    if preview.cost is not None:
        yield "a run takes", preview.cost.said


def _quality(f: Figures) -> str:
    poor = f"; {f.poor} elements below {POOR:g}" if f.poor else ""
    return f"median {f.typical:.2f}, worst {f.worst:.2f} of 1 (a regular element){poor}"


def _elements(count: int) -> str:
    few = " (two are wanted where it bends)" if count < ENOUGH else ""
    return f"{count} element{'s' if count != 1 else ''}{few}"

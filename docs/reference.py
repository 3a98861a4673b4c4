"""Writes docs/reference.md from the code: what a spec may hold, geometries, measures.

Called by `make docs`; a test sees to it that the page in the repository is the current one.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from softact import catalogue
from softact.bodies.constraints import Constraint
from softact.contact.obstacles import OBSTACLES
from softact.geometry.step_faces import Selection
from softact.loads import LOADS
from softact.materials.mullins import Mullins
from softact.materials.viscoelastic import Shift, Viscoelastic
from softact.spec.contact import SurfaceContactSpec
from softact.spec.films import LayerSpec, PlySpec, SheetOfLayers
from softact.spec.models import Spec, Step
from softact.spec.plausible import RANGES
from softact.spec.solver import Solver
from softact.spec.supports import LineSpec, SupportSpec
from softact.spec.timing import AmplitudeSpec, SineSpec, TriangleSpec
from softact.spec.tolerances import ToleranceSpec
from softact.units import DIMENSIONS

LOADED = {key: catalogue.model_in(load.annotation) for key, load in LOADS.items()}
PAGE = Path(__file__).with_name("reference.md")

PARTS = (
    (Spec, "The spec"),
    (LayerSpec, "An entry of `layers`"),
    (SheetOfLayers, "An entry of `sheets`"),
    (PlySpec, "An entry of a sheet's `plies`"),
    (ToleranceSpec, "An entry of `tolerances`"),
    (SupportSpec, "An entry of `supports`"),
    (LineSpec, "A value of `lines`"),
    (Constraint, "An entry of `constraints`"),
    (Step, "An entry of `steps`"),
    *((part, f"A step's `{key}`") for key, part in LOADED.items() if part and key != "obstacles"),
    *((model, f"An entry of `obstacles`: type `{name}`") for name, model in OBSTACLES.items()),
    (AmplitudeSpec, "A step's `amplitude`"),
    (SineSpec, "`sine` of an amplitude"),
    (TriangleSpec, "`triangle` of an amplitude"),
    (Viscoelastic, "A material's `viscoelastic`"),
    (Shift, "`wlf` of `viscoelastic`"),
    (Mullins, "A material's `mullins`"),
    (SurfaceContactSpec, "An entry of `contact`"),
    (LOADED["obstacles"], "An entry of a step's `obstacles`"),
    (Solver, "`solver`"),
    (Selection, "A value of `select`, of geometry `from_step`"),
)


def table(titles: Iterable[str], rows: Iterable[Iterable[Any]]) -> list[str]:
    """Lines of a Markdown table."""
    titles = list(titles)
    lines = [titles, ["---"] * len(titles), *rows]
    return [
        "| " + " | ".join(text(cell).replace("|", "\\|") for cell in line) + " |" for line in lines
    ]


def text(value: Any) -> str:
    """A value as one would write it in a spec; nothing for None."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)


def parameters(records: Iterable[dict[str, Any]]) -> list[str]:
    """A table of the keys of a part of a spec."""
    return table(
        ("key", "value", "default", "meaning"),
        (
            (
                f"`{record['name']}`",
                record["value"],
                "**needed**" if record["needed"] else record["default"],
                record["meaning"],
            )
            for record in records
        ),
    )


def units() -> list[str]:
    """The dimensions and the units in which a value of each may be written."""
    rows = ((d.name, f"`{d.example}`", ", ".join((*d.shown, *d.other))) for d in DIMENSIONS)
    return table(("value", "for example", "units, and all that pint converts to them"), rows)


def usual() -> list[str]:
    """The ranges outside of which a value is warned of."""
    rows = (
        (of(kind), f"{r.text(r.low)} to {r.text(r.high)}", r.evidence) for kind, r in RANGES.items()
    )
    return table(("what", "usual", "what spans it"), rows)


def of(kind: str) -> str:
    """What a range is about, in words."""
    quantity = {"rubber": "initial shear modulus", "softest": "shear modulus", "solid": "Young's "
                "modulus", "sheet": "Young's modulus", "fibres": "stiffness k1", "poisson":
                "Poisson's ratio", "rubber_poisson": "Poisson's ratio"}  # fmt: skip
    return f"{quantity[kind]} of {RANGES[kind].what}" if kind in quantity else RANGES[kind].what


def geometries() -> Iterable[str]:
    """A section per geometry: its parameters and the names that a spec may use."""
    for record in catalogue.geometries():
        yield from ("", f"### {record['name']}", "", record["use"], "")
        yield from parameters(record["parameters"])
        yield ""
        yield from names(record)
        for other in record["others"]:
            yield from (f"- with `{other['with']}` also", *names(other, "  "))
        if record["example"]:
            yield f"- what its sheets are made of: `{record['example']}`"


def names(record: dict[str, Any], indent: str = "") -> Iterable[str]:
    """An item for each kind of names that a spec may use with a geometry."""
    for key in catalogue.NAMES:
        if record.get(key):
            yield f"{indent}- {key}: " + ", ".join(f"`{name}`" for name in record[key])


def measures() -> Iterable[str]:
    """A table per measure: its columns in curve.csv."""
    for record in catalogue.measures():
        yield from ("", f"### {record['name']}", "", f"The {record['use']}.", "")
        rows = ((f"`{column}`", meaning) for column, meaning in record["columns"].items())
        yield from table(("column", "what it is"), rows)


def page() -> str:
    """The whole page."""
    lines = [
        "# What a spec may hold",
        "",
        "This page is written by `make docs` from the code; do not edit it.",
        "",
        "A value with a dimension carries its unit. Unknown keys are errors.",
        "",
        "## Units",
        "",
        *units(),
        "",
        "An exponent is written `mm^2`, `mm²` or `mm2`. A pressure counts from the ambient, as "
        "that of a gauge does (`psig`, `barg`).",
    ]
    for model, title in PARTS:
        sentence = " ".join((model.__doc__ or "").split())
        lines += ["", f"## {title}", "", sentence, "", *parameters(catalogue.parameters(model))]
    lines += [
        "",
        "## What is usual",
        "",
        "A value outside is no fault: `softact validate` and `softact run` warn of it, since most "
        "such values are a unit wrong.",
        "",
        *usual(),
    ]
    lines += ["", "## Geometries", *geometries()]
    lines += ["", "## Materials", "", "[materials.md](materials.md) shows every law and card."]
    lines += [
        "",
        "## Measures",
        "",
        "Columns of `curve.csv`. Where a title holds `<cavity>`, there is one column per cavity; "
        "that part is left out where there is only one.",
        *measures(),
        "",
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(f"wrote {PAGE}")

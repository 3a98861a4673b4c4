"""Writes docs/reference.md from the code: what a spec may hold, laws, cards, geometries.

Called by `make docs`; a test sees to it that the page in the repository is the current one.
"""

import types
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from softact.geometries import GEOMETRIES
from softact.geometry import Geometry
from softact.materials import CARDS, LAWS, Law, card_data
from softact.spec.models import Layer, Solver, Spec, Step, Support, Traction
from softact.units import DIMENSIONS, dimension_of

PAGE = Path(__file__).with_name("reference.md")

PARTS = (
    (Spec, "The spec"),
    (Layer, "An entry of `layers`"),
    (Support, "An entry of `supports`"),
    (Step, "An entry of `steps`"),
    (Traction, "A step's `traction`"),
    (Solver, "`solver`"),
)


def table(titles: Iterable[str], rows: Iterable[Iterable[str]]) -> list[str]:
    """Lines of a Markdown table."""
    titles = list(titles)
    lines = [titles, ["---"] * len(titles), *rows]
    return [
        "| " + " | ".join(str(cell).replace("|", "\\|") for cell in line) + " |" for line in lines
    ]


def kind(annotation: Any) -> str:
    """What to write for a value of a field, in words."""
    if dimension := dimension_of(annotation):
        name = dimension.name
        return f"{name} of each" if get_origin(annotation) is dict else name
    origin = get_origin(annotation)
    if origin is Annotated:
        return kind(get_args(annotation)[0])
    if origin is Literal:
        return ", ".join(f"`{choice}`" for choice in get_args(annotation))
    if origin in (Union, types.UnionType):
        parts = [kind(part) for part in get_args(annotation) if part is not type(None)]
        return " or ".join(parts)
    if origin in (tuple, list):
        inner = [kind(part) for part in get_args(annotation) if part is not Ellipsis]
        return "list of " + ", ".join(dict.fromkeys(inner))
    if origin is dict:
        return "mapping to " + kind(get_args(annotation)[1])
    if isinstance(annotation, type) and issubclass(annotation, Geometry):
        return "geometry"
    if isinstance(annotation, type) and issubclass(annotation, Law):
        return "material"
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation.__name__.lower()
    names = {str: "text", float: "number", int: "whole number", bool: "true or false"}
    return names.get(annotation, str(annotation))


def default(entry: FieldInfo) -> str:
    """The default of a field as one would write it in a spec."""
    value = entry.get_default(call_default_factory=False)
    if entry.is_required():
        return "**needed**"
    if value is None or isinstance(value, BaseModel) or value in ((), {}, ""):
        return ""
    if (dimension := dimension_of(entry)) and isinstance(value, float):
        return dimension.format(value)
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)


def fields(model: type[BaseModel], leave_out: Iterable[str] = ()) -> list[str]:
    """A table of the fields of a pydantic model."""
    return table(
        ("key", "value", "default", "meaning"),
        (
            (f"`{name}`", value_of(entry), default(entry), entry.description or "")
            for name, entry in model.model_fields.items()
            if name not in leave_out
        ),
    )


def value_of(entry: FieldInfo) -> str:
    """What to write for a field; pydantic keeps a dimension beside the annotation."""
    dimension = dimension_of(entry)
    bare = entry.annotation in (float, float | None)
    return dimension.name if dimension and bare else kind(entry.annotation)


def units() -> list[str]:
    """The dimensions and the units in which a value of each may be written."""
    rows = ((d.name, f"`{d.example}`", ", ".join((*d.shown, *d.other))) for d in DIMENSIONS)
    return table(("value", "for example", "units, and all that pint converts to them"), rows)


def geometries() -> Iterable[str]:
    """A section per geometry: its parameters and the names that a spec may use."""
    for name, geometry in GEOMETRIES.items():
        yield from ("", f"### {name}", "", *paragraphs(geometry.__doc__), "")
        yield from fields(geometry, leave_out=("type",))
        layout = geometry().layout()
        yield ""
        for title, names in (
            ("regions", layout.regions),
            ("cavities", layout.cavities),
            ("surfaces", layout.surfaces),
            ("surfaces meant for layers", layout.layers),
        ):
            if names:
                yield f"- {title}: " + ", ".join(f"`{n}`" for n in names)


def laws() -> Iterable[str]:
    """A section per law: its energy, its constants and when to use it."""
    for name, law in LAWS.items():
        yield from ("", f"### {name}", "", f"`{law.formula}`", "", law.use, "")
        yield f"Source: {law.reference}."
        yield ""
        yield from fields(law, leave_out=("law", *Law.model_fields))


def cards() -> list[str]:
    """A table of the material cards."""
    rows = []
    for name in CARDS:
        data = card_data(name)
        constants = [
            f"{key} {data[key]}" for key in LAWS[data["law"]].model_fields
            if key in data and key not in ("law", "convention") and key not in CARD_FIELDS
        ]  # fmt: skip
        rows.append((f"`{name}`", data["law"], ", ".join(constants), data.get("source", "")))
    return table(("card", "law", "constants", "source"), rows)


CARD_FIELDS = {"name", "source", "test", "stretch_range", "strength", "notes"}


def paragraphs(docstring: str | None) -> list[str]:
    """The lines of a docstring without their common indentation."""
    return [line.strip() for line in (docstring or "").strip().splitlines()]


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
    ]
    for model, title in PARTS:
        lines += ["", f"## {title}", "", *paragraphs(model.__doc__), "", *fields(model)]
    lines += ["", "## Geometries", *geometries()]
    lines += ["", "## Laws", "", "Every law also takes these keys:", ""]
    lines += [*fields(Law), *laws(), "", "## Material cards", "", *cards(), ""]
    return "\n".join(lines)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(f"wrote {PAGE}")

"""A first spec of a family as text, with a comment for whoever changes it."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from softact.catalogue import parameters
from softact.errors import SpecError
from softact.files import document
from softact.geometries import GEOMETRIES
from softact.materials.cards import parse_material
from softact.spec import Spec, spec_at
from softact.spec.building import find_files
from softact.spec.card_files import is_file, read_card
from softact.starter.families import MOTIONS, Family
from softact.units import LENGTH, PRESSURE

if TYPE_CHECKING:
    from jinja2 import Environment

    from softact.geometry.base import Geometry

_DIGITS = 4
_MOST = 50  # chambers, folds, pouches: more would take long


@dataclass(frozen=True)
class Wanted:
    """What is wanted of a family; None: what is usual for it.

    does: of its motions. length, width: mm. material: a card's name or file. pressure: MPa, by
    default the family's times the ratio of the materials' shear moduli. file: of one's own part.
    """

    does: str | None = None
    length: float | None = None
    width: float | None = None
    material: str | None = None
    pressure: float | None = None
    file: Path | None = None


def write(family: Family, wanted: Wanted, path: Path) -> str:
    """The text of a first spec that will stand in ``path``; it has been read once as ``validate``
    does.

    Raises SpecError with a line for each fault of what is wanted.
    """
    does = wanted.does or family.does[0]
    if does not in family.does:
        able = " or ".join(family.does)
        raise SpecError(f"a {family.name} does not {does}, it can {able}; leave the family out")
    length, width = wanted.length or family.length, wanted.width or family.width
    pressure = _pressure(family, wanted)
    head = f"# {GEOMETRIES[family.name].__name__}: {family.about}.\n"
    head += "# A first spec with a coarse mesh: 'softact converge' says what finer ones change.\n"
    if does in MOTIONS and does != "own":
        head += f"# It shall {does}: {MOTIONS[does][0]}.\n"
    template = family.template or "\n".join(_defaults(GEOMETRIES[family.name]))
    body = _environment().from_string(template).render(
        does=does,
        length=length,
        width=width,
        s=width / family.width,
        material=_material_text(family, wanted, path),
        pressure=PRESSURE.format(pressure),
        pressure_part=lambda part: PRESSURE.format(part * pressure),
        file=_file_text(family, wanted, path),
    )  # fmt: skip
    text = head + _aligned(body)
    _check(text, path, family, (length, width))
    return text


def _check(text: str, path: Path, family: Family, size: tuple[float, float]) -> None:
    """Read the text once. Raises SpecError."""
    source = document.parse(text, str(path))
    source.folder = path.parent
    try:
        find_files(source, Spec)
        spec_at(source)
    except SpecError as error:
        if size == (family.length, family.width):
            raise
        is_so, usual = (
            f"{_length(long)} long and {_length(wide)} wide"
            for long, wide in (size, (family.length, family.width))
        )
        raise SpecError(
            f"no {family.name} can be {is_so} with walls in proportion; usual is {usual}",
            *error.lines,
        ) from None


def _pressure(family: Family, wanted: Wanted) -> float:
    """MPa: softer material needs less, in proportion."""
    if wanted.pressure is not None:
        return wanted.pressure
    if wanted.material is None:
        return family.pressure
    usual = parse_material(family.material).shear_modulus
    own = read_card(Path(wanted.material)) if is_file(wanted.material) else wanted.material
    return float(f"{family.pressure * parse_material(own).shear_modulus / usual:.2g}")


def _material_text(family: Family, wanted: Wanted, path: Path) -> str:
    if wanted.material is None:
        usual = family.material
        if isinstance(usual, str):
            return usual
        return "{" + ", ".join(f"{key}: {value}" for key, value in usual.items()) + "}"
    if is_file(wanted.material):
        return json.dumps(_seen_from(path, Path(wanted.material)), ensure_ascii=False)
    return wanted.material


def _file_text(family: Family, wanted: Wanted, path: Path) -> str:
    if "{{ file }}" in family.template and wanted.file is None:
        raise SpecError(f"a {family.name} is made out of a file of yours; name it with --file")
    return json.dumps(_seen_from(path, wanted.file), ensure_ascii=False) if wanted.file else ""


def _seen_from(path: Path, file: Path) -> str:
    """The name of a file as a spec writes it: from the folder of the spec."""
    return os.path.relpath(file.expanduser(), path.parent)


def _defaults(geometry: type[Geometry]) -> Iterator[str]:
    """The template of a geometry without a file in ``specs``."""
    layout = geometry.model_construct(**{}).layout()  # a file's name has no default
    yield "geometry:"
    yield f"  type: {geometry.model_fields['type'].default}"
    for entry in parameters(geometry, leave_out=("type",)):
        if entry["default"] is not None:
            yield f"  {entry['name']}: {json.dumps(entry['default'])}  # {entry['meaning']}"
    yield "materials:"
    yield from (f"  {region}: {{{{ material }}}}" for region in layout.regions)
    yield "steps:"
    load = "pressure: {{ pressure }}" if layout.cavities else "gravity: [0, 0, -1]"
    yield f"  - {{name: load, {load}}}"


def _length(value: float) -> str:
    """A length in mm with few digits, as a spec writes it."""
    return LENGTH.format(float(f"{value:.{_DIGITS}g}"))


def _count(value: float) -> int:
    return min(max(1, round(value)), _MOST)


def _aligned(text: str) -> str:
    """The same with comments in one column, where their lines leave room."""
    lines = []
    for line in text.splitlines():
        code, mark, comment = line.partition("  # ")
        lines.append(f"{code.rstrip():<26} # {comment}" if mark else line.rstrip())
    return "\n".join(lines) + "\n"


@cache
def _environment() -> Environment:
    from jinja2 import Environment, StrictUndefined

    environment = Environment(undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.globals |= {"mm": _length, "count": _count}
    return environment

"""`softact new`: a first spec."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from softact.cli._force import force_file_option

if TYPE_CHECKING:
    from softact.starter import Family
    from softact.units import Dimension


_OF_FILES = {".step": "from_step", ".stp": "from_step", ".py": "from_script", ".geo": "from_script"}


def _families(context: click.Context, parameter: click.Parameter, begun: str) -> list[str]:
    from softact.geometries import GEOMETRIES

    return [name for name in GEOMETRIES if name.startswith(begun)]


def _motions(context: click.Context, parameter: click.Parameter, begun: str) -> list[str]:
    from softact.starter import MOTIONS

    return [name for name in MOTIONS if name.startswith(begun)]


def _cards(context: click.Context, parameter: click.Parameter, begun: str) -> list[str]:
    from softact.materials.cards import card_names

    return [name for name in card_names() if name.startswith(begun)]


@click.command(short_help="Write a first spec: from what it shall do, its size and its material.")
@click.argument("family", required=False, shell_complete=_families)
@click.option(
    "--does",
    metavar="WORD",
    shell_complete=_motions,
    help="bend, stretch, contract, twist, grip, press, ...",
)
@click.option("--length", metavar="LENGTH", help="How long it is, such as '80 mm'.")
@click.option("--width", metavar="LENGTH", help="How wide, or its diameter, such as '20 mm'.")
@click.option(
    "--material",
    metavar="CARD",
    shell_complete=_cards,
    help="A card (softact list materials) or a card file.",
)
@click.option("--pressure", metavar="PRESSURE", help="Such as '20 kPa'.")
@click.option(
    "--file",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="Your own part: a STEP file, a mesh, closed surfaces, a gmsh script.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="[default: <family>.yaml]",
)
@click.option("-y", "--yes", is_flag=True, help="Ask nothing; take what is usual.")
@force_file_option
def new(
    family: str | None,
    does: str | None,
    length: str | None,
    width: str | None,
    material: str | None,
    pressure: str | None,
    file: Path | None,
    output: Path | None,
    yes: bool,
    force: bool,
) -> None:
    """Write a first spec that runs as it is, with comments on what you may change.

    FAMILY is a geometry (softact list geometries). On a terminal it asks for what no option says.
    The mesh is coarse, so that a run takes less than a minute on two cores; the pressure is chosen
    for the size and the material.

    \b
    Examples:
      softact new
      softact new --does twist --length "120 mm" -o twister.yaml
      softact new bellows --material ecoflex-00-30 --width "30 mm"
      softact new from_step --file part.step
    """
    from softact.files.text import write_atomic
    from softact.results.own_folder import check_file
    from softact.starter import Wanted, write
    from softact.units import LENGTH, PRESSURE

    asks = sys.stdin.isatty() and sys.stdout.isatty() and not yes
    long, wide = _value(length, LENGTH, "--length"), _value(width, LENGTH, "--width")
    given = _value(pressure, PRESSURE, "--pressure")
    chosen, does = _family(family, does, asks, file)
    if asks:
        long = long or _ask("How long is it?", chosen.length)
        wide = wide or _ask("How wide is it, or its diameter?", chosen.width)
        if material is None and isinstance(chosen.material, str):
            material = _ask_material(chosen.material)
    path = output or Path(f"{chosen.name}.yaml")
    check_file(path, force, [file] if file else [])
    text = write(chosen, Wanted(does, long, wide, material, given, file), path)
    write_atomic(path, text)
    click.echo(f"wrote {path}: {chosen.about}")
    click.echo(f"look at it: softact preview {path}\nsolve it:   softact run {path}")


def _value(text: str | None, dimension: Dimension, option: str) -> float | None:
    """The value of an option in internal units, above 0."""
    if text is None:
        return None
    try:
        value = dimension.parse(text)
    except ValueError as error:
        raise click.UsageError(f"{option}: {error}") from None
    if value <= 0 and option != "--pressure":
        raise click.UsageError(f"{option}: '{text}' is not above 0")
    return value


def _family(
    name: str | None, does: str | None, asks: bool, file: Path | None
) -> tuple[Family, str | None]:
    """The family, and what it shall do where that was said."""
    from softact.starter import MOTIONS, family, for_motion

    if name is None and does is None and file is not None:
        name = _OF_FILES.get(file.suffix.lower(), "from_mesh")
    if name is not None:
        return family(name), does
    if does is None and not asks:
        raise click.UsageError(
            f"say what it shall do, such as --does bend ({', '.join(MOTIONS)}), or name a family"
        )
    does = does or _choose(
        "What shall it do?", list(MOTIONS), [words for words, _ in MOTIONS.values()]
    )
    able = for_motion(does)
    if not asks or len(able) == 1:
        return able[0], does
    names = [entry.name for entry in able]
    return family(_choose("Which kind?", names, [entry.about for entry in able])), does


def _choose(question: str, names: Sequence[str], words: Sequence[str]) -> str:
    width = max(map(len, names))
    for number, (name, said) in enumerate(zip(names, words, strict=True), 1):
        click.echo(f"  {number:2d}  {name:{width}s}  {said}")

    def read(text: str) -> str:
        if text in names:
            return text
        if text.isdecimal() and 1 <= int(text) <= len(names):
            return names[int(text) - 1]
        raise click.UsageError(f"write a number from 1 to {len(names)}, or a name")

    return click.prompt(question, default="1", value_proc=read)


def _ask(question: str, usual: float) -> float:
    from softact.units import LENGTH

    def read(text: str) -> float:
        return _value(text, LENGTH, "a length") or usual

    return click.prompt(question, default=LENGTH.format(usual), value_proc=read)


def _ask_material(usual: str) -> str:
    from softact.errors import SpecError
    from softact.materials.cards import card_data
    from softact.spec.card_files import is_file, read_card

    def read(text: str) -> str:
        try:
            read_card(Path(text)) if is_file(text) else card_data(text)
        except SpecError as error:
            raise click.UsageError("; ".join(error.lines)) from None
        return text

    return click.prompt("Which material? (softact list materials)", default=usual, value_proc=read)

"""`softact module`: one module of a chain instead of the whole actuator."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from softact.cli._force import force_option
from softact.cli._options import set_option
from softact.errors import SpecError

if TYPE_CHECKING:
    from softact.results.own_folder import Output
    from softact.spec import Spec


@click.command(short_help="One module of a chain: angle, stretch, air, stiffness, in seconds.")
@click.argument("spec", metavar="SPEC", type=click.Path(path_type=Path))
@set_option
@click.option(
    "--hold",
    multiple=True,
    metavar="COMPONENT=VALUE",
    help="Hold a component of the right face, such as turn_y='10 deg' or shift_x='9 mm'. May be "
    "repeated.",
)
@click.option(
    "--modules",
    type=click.FloatRange(min=0, min_open=True),
    metavar="N",
    help="Modules of the whole actuator.  [default: those of the geometry]",
)
@click.option("--no-weight", is_flag=True, help="Leave the spec's gravity out.")
@click.option(
    "--no-contact",
    is_flag=True,
    help="Leave the spec's contact out: walls and modules pass through each other.",
)
@click.option(
    "--table",
    is_flag=True,
    help="Instead of the runs: table.json and table.h5, the energy of a module over curvatures, "
    "forces and pressures.",
)
@click.option("-o", "--output", metavar="DIR", help="[default: results/<name>-module]")
@force_option
def module(
    spec: Path,
    overrides: tuple[str, ...],
    hold: tuple[str, ...],
    modules: float | None,
    no_weight: bool,
    no_contact: bool,
    table: bool,
    output: str | None,
    force: bool,
) -> None:
    """Solve one module of an actuator that is a chain of equal ones, free and blocked.

    The module lies between two faces that a rigid motion relates, so it stands for all inner
    modules. Writes module.csv, module.html and chain.png: angle, stretch and air of a module over
    the load, its moment, force and stiffness as the cross-section of a rod, what it exerts where it
    is blocked, and the angle of the whole actuator. The runs stay in folders beside them.

    \b
    Examples:
      softact module benchmarks/pneunet8.yaml
      softact module benchmarks/pneunet8.yaml --hold turn_y='10 deg'
      softact module benchmarks/pneunet8.yaml --table
      softact module configs/pneunet_glove.yaml --no-weight
    """
    from softact import spec as specs
    from softact.modules import output as files
    from softact.modules.module_spec import module_specs
    from softact.modules.study import study
    from softact.results.own_folder import Output

    loaded = specs.load(spec, overrides)
    directory = Path(output) if output else Path("results") / f"{loaded.name}-module"
    folder = Output(directory, "module", force, [spec])
    if table:
        if hold or modules or no_weight or no_contact:
            raise SpecError("--table walks over the pressures alone; leave the other options out")
        _write_table(loaded, folder)
        return
    held = dict(_split(text) for text in hold)
    pair = module_specs(loaded, held, not no_weight, not no_contact)
    if len(loaded.geometry.in_segments()) > 1:
        click.echo("of several segments: the one at the clamp, under its pressures")
    with folder.opened(files.FILES):
        for name in pair.runs:
            folder.file(name)
        found = study(pair, directory, modules or pair.pitches or 0.0, click.echo)
        page = files.write(found, loaded.name, folder)
    for line in files.lines(found):
        click.echo(line)
    click.echo(f"page: {page}")


def _write_table(spec: Spec, folder: Output) -> None:
    from softact.modules.rod_page import law
    from softact.modules.table_file import FILES, JSON, made_or_read

    with folder.opened(FILES):
        known = folder.directory / JSON
        found = made_or_read(spec, known, given=False, tell=click.echo)
        found.write(*map(folder.file, FILES))
    click.echo(law(found.table))
    click.echo(f"table: {known}")


def _split(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals or not value.strip():
        raise SpecError(f"--hold {text}: write a component and a value, such as turn_y='10 deg'")
    return name.strip(), value.strip()

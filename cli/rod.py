"""`softact rod`: the whole actuator as a rod whose cross-section is its module."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from softact.cli._force import force_option
from softact.cli._options import set_option
from softact.errors import NoEquilibriumError
from softact.export import FORMATS


@click.command(short_help="The whole actuator as a rod of its modules, in milliseconds a load.")
@click.argument("spec", metavar="SPEC", type=click.Path(path_type=Path))
@set_option
@click.option(
    "--table",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="A table.json of 'softact module --table' or of an earlier rod.  [default: that in the "
    "output folder, else a new one]",
)
@click.option(
    "--increments",
    type=click.IntRange(1),
    default=10,
    show_default=True,
    help="States in each step.",
)
@click.option(
    "--to",
    "formats",
    multiple=True,
    type=click.Choice(list(FORMATS)),
    help="Also write a reduced model for a simulator, as 'softact export' does of runs. May be "
    "repeated.",
)
@click.option("-o", "--output", metavar="DIR", help="[default: results/<name>-rod]")
@force_option
def rod(
    spec: Path,
    overrides: tuple[str, ...],
    table: Path | None,
    increments: int,
    formats: tuple[str, ...],
    output: str | None,
    force: bool,
) -> None:
    """Solve a spec on a rod whose law is the table of the actuator's module.

    Weight, payload, pressures, obstacles and motion are those of the spec. Writes
    curve.csv, rod.html and the table, which the next call in the same folder takes again: only
    the first one solves finite elements. With --to also a model for simulators, and reduced.html,
    which sets it beside the rod.

    Exits with 4 where the rod stops before the last load.

    \b
    Examples:
      softact rod benchmarks/pneunet8.yaml
      softact rod benchmarks/pneunet8.yaml --set steps.inflate.pressure='15 kPa'
      softact rod benchmarks/pneunet8.yaml --to mujoco --to json
    """
    from softact import spec as specs
    from softact.export import page as model_page
    from softact.modules import rod_page, rod_run, twin
    from softact.modules.table_file import FILES, JSON, made_or_read
    from softact.results.own_folder import Output

    loaded = specs.load(spec, overrides)
    rod_run.check(loaded)
    if formats:
        twin.check(loaded)
    directory = Path(output) if output else Path("results") / f"{loaded.name}-rod"
    folder = Output(directory, "rod", force, [spec, *([table] if table else [])])
    with folder.opened([*FILES, *rod_page.FILES]):
        known = table or directory / JSON
        law = made_or_read(loaded, known, given=table is not None, tell=click.echo)
        law.write(*map(folder.file, FILES))
        chain = rod_run.Chain(loaded, law.table)
        found = rod_run.run(chain, increments)
        page = rod_page.write(found, law.table, loaded.name, folder)
        made = model_page.files(twin.prepare(chain, found), formats) if formats else {}
        twins = model_page.write(made, folder)
    for line in rod_page.lines(found, law.table):
        click.echo(line)
    click.echo(f"page: {page}")
    for path in twins:
        click.echo(f"wrote {path}")
    if found.stopped:
        sys.exit(NoEquilibriumError.exit_code)

"""`softact export`: a reduced model of runs, for simulators."""

from pathlib import Path

import click

from softact.cli._force import force_option
from softact.export import FORMATS


@click.command(short_help="Write a reduced model of runs for a simulator.")
@click.argument("folders", nargs=-1, required=True, metavar="DIR|SWEEP...")
@click.option(
    "--to",
    "formats",
    multiple=True,
    required=True,
    type=click.Choice(list(FORMATS)),
    help="; ".join(f"{name}: {found.description}" for name, found in FORMATS.items())
    + ". May be repeated.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Folder for the files.  [default: results/<name of the first folder>-export]",
)
@click.option(
    "--pieces",
    type=click.IntRange(1, 200),
    help="Pieces of constant curvature.  [default: so many that none turns by more than 8°]",
)
@click.option(
    "--damping-ratio",
    type=click.FloatRange(0.0, 2.0, min_open=True),
    default=0.1,
    show_default=True,
    help="Of critical damping in the first bending vibration; no run tells it.",
)
@click.option(
    "--cache",
    "cache_folder",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Where the runs of a sweep are kept.  [default: results/.runs]",
)
@force_option
def export(
    folders: tuple[str, ...],
    formats: tuple[str, ...],
    output: Path | None,
    pieces: int | None,
    damping_ratio: float,
    cache_folder: Path | None,
    force: bool,
) -> None:
    """Fit a reduced model to the states of runs and write it for simulators.

    A rod of pieces of constant curvature with stretch (and twist): rest shape, stiffness and volume
    follow the pressure. Give result folders of one actuator, or the folder of a sweep: runs under
    several payloads tell how stiff it is. Writes the model, reduced.html with its deviations from
    the finite-element states, and says them.

    \b
    Examples:
      softact export results/pneunet_small --to json
      softact sweep configs/sweeps/pneunet_tip_loads.yaml
      softact export results/pneunet_tip_loads --to mujoco --to fmu
    """
    from softact.export import page, sources, statement
    from softact.export.job import prepare
    from softact.results.own_folder import Output

    first = Path(folders[0]).resolve().name
    folder = Output(output or Path("results") / f"{first}-export", "export", force)
    folder.check()  # before anything is fitted
    job = prepare(sources.runs(folders, cache_folder), pieces, damping_ratio)
    made = page.files(job, formats)
    with folder.opened(list(made)):
        written = page.write(made, folder)
    for line in job.about:
        click.echo(line)
    for line in statement.warnings(job.model):
        click.echo(f"warning: {line}", err=True)
    for path in written:
        click.echo(f"wrote {path}")

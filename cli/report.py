"""`softact report`: the report of a result folder, built anew."""

from pathlib import Path

import click

from softact.cli._measured import measured_options, read_all, sections, tell


@click.command(short_help="Rebuild the report of a result folder.")
@click.argument("directory", metavar="DIR", type=click.Path(path_type=Path))
@measured_options
def report(directory: Path, measured: tuple[Path, ...], columns: str | None) -> None:
    """Rebuild report.html and the pictures of a result folder from the files in it.

    With --measured, the report sets the run against measured curves: RMSE, the largest deviation
    and the load from which they differ by more than 10 % of the measured range.

    \b
    Examples:
      softact report results/pneunet_glove
      softact report results/finger --measured angle.csv
    """
    from softact.report import write_report
    from softact.results import read

    read_in = read_all(measured, list(read(directory).curve), columns)
    path = write_report(directory, sections(read_in))
    tell(directory, read_in)
    click.echo(f"wrote {path}")

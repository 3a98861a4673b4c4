"""`softact calibrate`: constants of a spec from a measured curve of the actuator."""

from pathlib import Path

import click

from softact.cli._force import force_option
from softact.cli._options import set_option


@click.command(short_help="Adjust constants of a spec to a measured curve of the actuator.")
@click.argument("spec", type=click.Path(path_type=Path))
@click.option(
    "--data",
    type=click.Path(path_type=Path),
    required=True,
    metavar="FILE",
    help="CSV with headings such as 'pressure_kPa, bending_angle_deg' (softact list measures).",
)
@click.option(
    "--vary",
    multiple=True,
    required=True,
    metavar="PATH[=LOW..HIGH]",
    help="A value of the spec to adjust; default bounds: a tenth to ten times. May be repeated.",
)
@click.option(
    "--columns",
    metavar="NAMES",
    help="Headings of the data in order, where the file has none or others; '-' skips a column.",
)
@click.option("--x", metavar="COLUMN", help="Abscissa among the columns; default: the first.")
@set_option
@click.option(
    "--max-runs", type=click.IntRange(2, 1000), default=30, show_default=True, help="Runs at most."
)
@click.option(
    "-n",
    "--processes",
    type=click.IntRange(1, 1024),
    default=1,
    show_default=True,
    metavar="PROCS",
    help="MPI processes of each run.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Folder for the outcome.  [default: results/<name of the spec>-calibrated]",
)
@click.option("--cache", "cache_folder", envvar="SOFTACT_CACHE", metavar="DIR",
              help="Folder of the finished runs.  [default: results/.runs]")  # fmt: skip
@force_option
def calibrate(
    spec: Path,
    data: Path,
    vary: tuple[str, ...],
    columns: str | None,
    x: str | None,
    overrides: tuple[str, ...],
    max_runs: int,
    processes: int,
    output: Path | None,
    cache_folder: str | None,
    force: bool,
) -> None:
    """Adjust named constants of a spec so that its run meets a measured curve.

    Every row of the data is a point of the curve; the first column is the abscissa, all others are
    to be met. Each run is told; the calibrated spec, the curves, a plot and the best run go into
    the folder. Finished runs are kept: after a kill the same command goes on where it was. Exits
    with 2 for wrong data, 4 where the run of the spec as it is finds no equilibrium before the data
    end.

    \b
    Examples:
      softact calibrate finger.yaml --data angle.csv --vary materials.body.c10
      softact calibrate finger.yaml --data angle.csv \\
        --vary materials.body.c10='0.05 MPa..0.3 MPa' --vary materials.body.c20
    """
    from softact.fit.calibrate import run_request
    from softact.fit.calibration import CalibrationRequest
    from softact.sweep.cache import DEFAULT, Cache

    cache = Cache(Path(cache_folder or DEFAULT), warn=lambda line: click.echo(line, err=True))
    request = CalibrationRequest(
        spec=spec,
        data=data,
        vary=vary,
        overrides=overrides,
        x=x,
        columns=columns,
        processes=processes,
        max_runs=max_runs,
        force=force,
    )
    run_request(request, output, cache, click.echo)

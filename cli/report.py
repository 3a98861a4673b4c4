"""`softact report`: the report of a result folder, built anew."""

import shlex
from functools import partial
from pathlib import Path

import click

from softact.cli._measured import measured_options, read_all, tell
from softact.cli._targets import targets_option


@click.command(short_help="Rebuild the report of a result folder.")
@click.argument("directory", metavar="DIR", type=click.Path(path_type=Path))
@measured_options
@click.option(
    "--forget-measured",
    "forget",
    is_flag=True,
    help="Leave out the measured curves that stay in DIR from earlier calls.",
)
@targets_option
@click.option(
    "--animate",
    type=click.Choice(["gif", "mp4"]),
    help="Write a film of the motion too; mp4 needs the package imageio-ffmpeg.",
)
def report(
    directory: Path,
    measured: tuple[Path, ...],
    columns: str | None,
    forget: bool,
    targets: tuple[str, ...],
    animate: str | None,
) -> None:
    """Rebuild report.html and the pictures of a result folder from the files in it.

    With --measured, the report sets the run against measured curves: RMSE, the largest deviation
    and the load from which they differ by more than 10 % of the measured range. The curves stay in
    the folder, and every later report shows them too.

    \b
    Examples:
      softact report results/pneunet_glove
      softact report results/finger --measured angle.csv
      softact report results/pneunet_glove --targets glove
      softact report results/pneunet_glove --animate gif
    """

    def tell_error(line: str) -> None:
        click.echo(line, err=True)

    from softact.files.lock import held
    from softact.report import animation, write_report
    from softact.report import targets as published
    from softact.report.remembered import remember, remembered
    from softact.results.folder import MEASURED, read
    from softact.spec.kinds import expect_results

    expect_results(directory)
    published.check(targets)
    if animate:
        animation.check(animate)
    results = read(directory)
    called = shlex.join(["softact", "report", str(directory)])
    read_in = read_all(measured, list(results.curve), columns, called)
    more = [partial(published.section, wanted=targets)] if targets else []
    with held(directory, "report"):
        if animate:  # first, since a machine may be unable to draw it
            film = animation.write_animation(directory, animate)
        if forget:
            (directory / MEASURED).unlink(missing_ok=True)
        remember(directory, read_in)
        path = write_report(directory, more, tell_error)
    tell(directory, remembered(directory))
    for name in targets:
        verdicts = [published.judge(results, asked) for asked in published.requirements(name)]
        for line in published.tell(name, verdicts):
            click.echo(line)
    click.echo(f"wrote {path}")
    if animate:
        click.echo(f"wrote {film}")

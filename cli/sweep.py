"""`softact sweep`: many runs over the values of a spec."""

import os
import sys
import time
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from softact.cli._files import tell_scripts
from softact.cli._force import force_option

if TYPE_CHECKING:
    from softact.sweep.study import Runner, Study
    from softact.sweep.table import Row


@click.command(short_help="Runs over values of a spec, each computed once; table and page.")
@click.argument("sweep", metavar="SWEEP")
@click.option(
    "-o",
    "--output",
    metavar="DIR",
    help="Folder for table and page.  [default: results/<name of the sweep>]",
)
@click.option(
    "-j",
    "--jobs",
    type=click.IntRange(1, 1024),
    default=lambda: len(os.sched_getaffinity(0)),
    metavar="N",
    help="Runs at a time, one thread each.  [default: the number of cores]",
)
@click.option(
    "--cache",
    "cache_folder",
    envvar="SOFTACT_CACHE",
    metavar="DIR",
    help="Folder of the finished runs.  [default: $SOFTACT_CACHE or results/.runs]",
)
@click.option(
    "--sensitivity",
    type=click.Choice(["sobol", "morris"]),
    help="Sample the axes for sensitivity indices and compute them.",
)
@click.option("--list", "only_list", is_flag=True, help="List the points; compute nothing.")
@click.option("--scheduler", metavar="tcp://HOST:PORT", help="Compute on a Dask cluster.")
@click.option("--slurm", is_flag=True, help="Start -j Dask workers as SLURM jobs.")
@click.option(
    "--interface",
    metavar="NAME",
    help="Network interface, such as ib0, that --slurm's scheduler and workers use.  [default: "
    "that of the route out of this machine]",
)
@click.option(
    "--slurm-option",
    multiple=True,
    metavar="NAME=VALUE",
    help="Of dask_jobqueue.SLURMCluster, such as queue=short or walltime=02:00:00.",
)
@force_option
def sweep(
    sweep: str,
    output: str | None,
    jobs: int,
    cache_folder: str | None,
    sensitivity: Literal["sobol", "morris"] | None,
    only_list: bool,
    scheduler: str | None,
    slurm: bool,
    interface: str | None,
    slurm_option: tuple[str, ...],
    force: bool,
) -> None:
    """Compute all points of a sweep file: a base spec, axes over its paths, a design.

    Finished runs are kept and never done again, by this sweep or another; stopped at any moment,
    the same command goes on where it was. Writes sweep.csv, sweep.parquet, curves.h5 and
    sweep.html. Exits with 1 when a run failed that another try may save (a solver that was
    killed), else with 0: a point without equilibrium is a row like any other.

    \b
    Examples:
      softact sweep configs/sweeps/pneunet_wall.yaml -j 4
      softact sweep thick.yaml --sensitivity sobol
    """
    from softact.cli._points import Points
    from softact.results.own_folder import Output
    from softact.sweep import output as files
    from softact.sweep import trends
    from softact.sweep.cache import DEFAULT, Cache
    from softact.sweep.confirm import lines
    from softact.sweep.sensitivity import sample_of
    from softact.sweep.spec import Sweep, read
    from softact.sweep.study import open_study

    started = time.monotonic()
    study, base = read(Path(sweep), Sweep)
    tell_scripts(base.data, study.axes)
    directory = Path(output) if output else Path("results") / study.name
    reads, kept = [Path(sweep), Path(base.name)], "the runs are kept in the cache"
    folder = Output(directory, "sweep", force, reads, kept)
    if not only_list:
        folder.check(files.FILES)
    cache = Cache(Path(cache_folder or DEFAULT), warn=lambda line: click.echo(line, err=True))
    sample = sample_of(sensitivity, study) if sensitivity else None
    design = sample.points if sample else None
    opened = open_study(study, base, cache, directory / files.PLAN, design)
    trends.check(Path(sweep), opened)
    known, total = len(opened.points) - _open(opened), len(opened.points)
    click.echo(f"{total} points, {known} of them known; runs in {cache.directory}")
    if only_list:
        _list(opened)
        return
    to_do = opened.missing() or study.confirm
    with (
        _runner(opened, jobs, scheduler, slurm, interface, slurm_option) as runner,
        folder.opened(files.FILES),
        Points(total + study.confirm, known) if to_do else nullcontext() as progress,
    ):
        rows, seen, notes = files.carry_out(
            opened, runner, sample, folder, progress or (lambda point, answer: None)
        )
    for note in notes:
        click.echo(note, err=True)
    for verdict in seen:
        click.echo(f"trend: {verdict.text}")
    if study.objectives:
        click.echo(f"{len(opened.front())} points that none beats: column unbeaten of sweep.csv")
    for line in lines(opened.confirmed, opened.compared):
        click.echo(f"modules beside whole actuators: {line}")
    _sum_up(opened, rows, directory, time.monotonic() - started)


def _open(study: "Study") -> int:
    missing = set(study.missing())
    return sum(point.key in missing for point in study.points)


def _list(study: "Study") -> None:
    for number, point in enumerate(study.points):
        answer = study.answer(point)
        status = answer.status.replace("_", " ") if answer else "not computed"
        click.echo(f"{number:5d}  {point.key or '-':32s}  {status:14s}  {point.text()}")


def _runner(
    study: "Study",
    jobs: int,
    scheduler: str | None,
    slurm: bool,
    interface: str | None,
    options: tuple[str, ...],
) -> AbstractContextManager["Runner"]:
    """What computes, as a context: a cluster is found or started before anything is written."""
    wanted = study.missing() or study.sweep.confirm
    if wanted and slurm:
        from softact.sweep.cluster import on_slurm

        return on_slurm(jobs, interface, options, study.cache)
    if wanted and scheduler:
        from softact.sweep.cluster import on_scheduler

        return on_scheduler(scheduler)
    from softact.sweep.study import locally

    return nullcontext(locally(jobs))


def _sum_up(study: "Study", rows: "list[Row]", directory: Path, seconds: float) -> None:
    from softact.cli._points import duration

    counts = {name: sum(row["status"] == name for row in rows) for name in
              ("complete", "no_equilibrium", "failed", "invalid_spec")}  # fmt: skip
    said = ", ".join(f"{n} {name.replace('_', ' ')}" for name, n in counts.items() if n)
    click.echo(f"{said}; {study.computed} computed now, in {duration(seconds)}")
    click.echo(f"page: {directory / 'sweep.html'}")
    again = [a for a in study.answers.values() if a.transient]
    if again:
        click.echo(
            f"{len(again)} runs failed in a way that may not come again, such as: "
            f"{again[0].cause}; the same command tries them once more",
            err=True,
        )
        sys.exit(1)

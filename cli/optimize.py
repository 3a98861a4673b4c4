"""`softact optimize`: the best design within constraints."""

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from softact.cli._files import tell_scripts
from softact.cli._force import force_option

if TYPE_CHECKING:
    from optuna.trial import FrozenTrial

    from softact.sweep.compute import Answer
    from softact.sweep.points import DesignPoint


@click.command(short_help="Find the best designs within constraints (Optuna, gradients).")
@click.argument("file", metavar="OPT")
@click.option("-o", "--output", metavar="DIR", help="[default: results/<name of the file>]")
@click.option(
    "-j",
    "--jobs",
    type=click.IntRange(1, 1024),
    default=lambda: len(os.sched_getaffinity(0)),
    metavar="N",
    help="Trials at a time, one thread each.  [default: the number of cores]",
)
@click.option("--trials", type=click.IntRange(1, 100_000), help="Instead of the file's.")
@click.option("--cache", "cache_folder", envvar="SOFTACT_CACHE", metavar="DIR",
              help="Folder of the finished runs.  [default: results/.runs]")  # fmt: skip
@force_option
def optimize(
    file: str,
    output: str | None,
    jobs: int,
    trials: int | None,
    cache_folder: str | None,
    force: bool,
) -> None:
    """Vary parameters of a spec for the best measures, with constraints on others.

    With method: gradient in the file, parameters follow the derivatives that each run carries;
    there --trials is a limit, and -j makes nothing faster.

    Trials are kept in trials.db and their runs in the cache of the sweeps: the same command goes
    on where it was stopped, and with more --trials it adds to what there is. A run that fails is a
    failed trial with its cause. Writes trials.csv, optimise.html and best/, the data sheet of the
    best design. Exits with 4 when no trial holds all constraints.

    \b
    Example:
      softact optimize configs/sweeps/pneunet_optimise.yaml -j 2
    """
    from softact.cli._points import outcome
    from softact.optimise import optimise_page
    from softact.optimise.check import check
    from softact.optimise.gradient import Descent
    from softact.optimise.spec import Optimisation
    from softact.optimise.store import DATABASE
    from softact.optimise.study import Trials, feasible
    from softact.results.own_folder import Output
    from softact.sweep.cache import DEFAULT, Cache
    from softact.sweep.confirm import lines
    from softact.sweep.spec import read

    wanted, base = read(Path(file), Optimisation)
    tell_scripts(base.data, wanted.parameters)
    check(Path(file), wanted, base)
    if trials:
        wanted = wanted.model_copy(update={"trials": trials})
    directory = Path(output) if output else Path("results") / wanted.name
    cache = Cache(Path(cache_folder or DEFAULT), warn=lambda line: click.echo(line, err=True))

    def tell(trial: "FrozenTrial", answer: "Answer") -> None:
        values = ", ".join(
            f"{o.title} {v:.5g}" for o, v in zip(wanted.objectives, trial.values or [],
                                                 strict=False)
        )  # fmt: skip
        said = values or f"{answer.status.replace('_', ' ')} ({answer.cause})"
        broken = "" if feasible(trial) or not values else ", breaks a constraint"
        click.echo(f"{len(study.done)}/{wanted.trials}  trial {trial.number}: {said}{broken}")

    def tell_whole(point: "DesignPoint", answer: "Answer") -> None:
        click.echo(f"whole actuator, {point.text()}: {outcome(answer)}")

    reads, kept = [Path(file), Path(base.name)], "the runs are kept in the cache"
    folder = Output(directory, "optimize", force, reads, kept)
    with folder.opened(optimise_page.FILES):
        folder.file(DATABASE)
        study = Trials(wanted, base, cache, directory)
        click.echo(f"{wanted.trials} trials, {len(study.done)} of them done")
        try:
            if wanted.method == "gradient":
                Descent(study, tell, lambda line: click.echo(line, err=True)).run()
            else:
                study.run(jobs, tell)
            if wanted.confirm:
                study.confirm(jobs, tell_whole)
        finally:
            if study.done:
                path = optimise_page.write(study, folder)
    for line in lines(study.confirmed, study.compared):
        click.echo(f"modules beside whole actuators: {line}")
    for trial in study.best():
        texts = [f"{name} {value}" for name, value in study.coordinates(trial).items()]
        values = [f"{o.title} {v:.5g}" for o, v in zip(wanted.objectives, trial.values,
                                                       strict=True)]  # fmt: skip
        click.echo(f"best: trial {trial.number}: {', '.join(values)} at {', '.join(texts)}")
    click.echo(f"page: {path}")
    if not study.best():
        click.echo("no trial holds all constraints", err=True)
        sys.exit(4)

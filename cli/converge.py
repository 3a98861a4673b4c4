"""`softact converge`: how fine a mesh has to be."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import click

from softact.cli._force import force_option
from softact.cli._options import set_option
from softact.errors import SpecError

if TYPE_CHECKING:
    from softact.converge.study import Level
    from softact.spec import Spec
    from softact.sweep.compute import Answer


@click.command(short_help="Refine the mesh until the measures are right; error bars.")
@click.argument("spec")
@click.option(
    "-m",
    "--measure",
    "measures",
    multiple=True,
    metavar="COLUMN",
    help="Column that has to be right; may be repeated.  [default: bending_angle_deg and "
    "max_principal_stress_MPa]",
)
@click.option("--tolerance", default="5 %", show_default=True, help="Largest relative error.")
@click.option(
    "--factor",
    type=click.FloatRange(1.1, 4.0),
    default=1.5,
    show_default=True,
    help="From one mesh size to the next.",
)
@click.option(
    "--most",
    type=click.IntRange(2, 10),
    default=5,
    show_default=True,
    metavar="N",
    help="Meshes at most.",
)
@click.option("-o", "--output", metavar="DIR", help="[default: results/<name>-converge]")
@click.option(
    "--into",
    metavar="DIR",
    help="Result folder of 'softact run' that gets the error bars of its mesh; its report is "
    "built anew.",
)
@click.option(
    "-j",
    "--jobs",
    type=click.IntRange(1, 64),
    default=lambda: len(os.sched_getaffinity(0)),
    metavar="N",
    help="Runs at a time.  [default: the number of cores]",
)
@click.option("--cache", "cache_folder", envvar="SOFTACT_CACHE", metavar="DIR",
              help="Folder of the finished runs.  [default: results/.runs]")  # fmt: skip
@set_option
@force_option
def converge(
    spec: str,
    measures: tuple[str, ...],
    tolerance: str,
    factor: float,
    most: int,
    output: str | None,
    into: str | None,
    jobs: int,
    cache_folder: str | None,
    overrides: tuple[str, ...],
    force: bool,
) -> None:
    """Refine the mesh of a spec until the measures are within the tolerance of their limits.

    Mesh sizes are divided by the factor, and as many elements more lie through each wall, one more
    at least. Says which mesh to use, what the limit is (Richardson's estimate, with the observed
    order) and how large the error of the spec's own mesh is, or that it is not known. Writes
    converge.csv, converge.json and converge.html. Exits with 1 unless the measures are known to be
    within the tolerance on one of so many meshes.

    \b
    Example:
      softact converge configs/pneunet_small.yaml -m bending_angle_deg --into results/pneunet_small
    """
    from softact.converge import carry
    from softact.converge import output as files
    from softact.converge.study import converge as study_of
    from softact.files.lock import held
    from softact.results.own_folder import Output
    from softact.spec import load
    from softact.sweep.cache import DEFAULT, Cache

    loaded = load(spec, overrides)
    for line in loaded.geometry.notes():
        click.echo(line, err=True)
    wanted = measures or ("bending_angle_deg", "max_principal_stress_MPa")
    cache = Cache(Path(cache_folder or DEFAULT), warn=lambda line: click.echo(line, err=True))
    directory = Path(output) if output else Path("results") / f"{loaded.name}-converge"
    folder = Output(directory, "converge", force, [Path(spec)], "the runs are kept in the cache")
    with ExitStack() as stack:
        if into:  # before hours of computing, not after
            carry.check_folder(Path(into), [spec.hash for spec in _meshes(loaded, factor, most)])
            stack.enter_context(held(Path(into), "converge"))
        stack.enter_context(folder.opened(files.FILES))
        study = study_of(
            loaded, wanted, cache, _part(tolerance), factor, most, jobs, tell=_teller(wanted)
        )
        page = files.write(study, loaded.name, folder)
        for line in [*files.limit_lines(study), files.advice(study)]:
            click.echo(line)
        if into:
            click.echo(carry.carry_into(study, Path(into)))
    click.echo(f"page: {page}")
    sys.exit(0 if study.converged else 1)


def _meshes(spec: "Spec", factor: float, most: int) -> Iterator["Spec"]:
    """The specs that a study may come to; fewer where they become too large."""
    from softact.converge.study import refined

    for times in range(most):
        try:
            yield refined(spec, factor, times)
        except SpecError:
            return


def _part(text: str) -> float:
    """5 %, 5% or 0.05 as 0.05."""
    percent = text.strip().endswith("%")
    try:
        value = float(text.strip().removesuffix("%")) / (100 if percent else 1)
    except ValueError:
        value = 0.0
    if not 0 < value < 1:
        raise click.BadParameter(f"'{text}' is no part such as '5 %' or 0.05")
    return value


def _teller(measures: tuple[str, ...]) -> Callable[["Level", "Answer"], None]:
    """What prints a line for each mesh."""

    def tell(level: "Level", answer: "Answer") -> None:
        values = ", ".join(
            f"{m} {level.record.measures[m]:.5g}" for m in measures if m in level.record.measures
        )
        known = "known" if answer.cached else f"{level.record.seconds:.1f} s"
        kind = "tetrahedra" if level.spec.geometry.layout().regions else "triangles"
        click.echo(f"{level}: {level.record.cells} {kind}, {values} ({known})")

    return tell

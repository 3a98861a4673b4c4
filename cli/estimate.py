"""`softact estimate`: a first answer in a second, by beams and moments."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from softact.cli._force import force_file_option
from softact.cli._options import set_option

if TYPE_CHECKING:
    from softact.estimate import Estimate
    from softact.spec import Spec


@click.command(short_help="Estimate what an actuator does, without a run.")
@click.argument("spec", metavar="SPEC", type=click.Path(path_type=Path))
@set_option
@click.option(
    "--beside",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Say how far the estimate is from the run in a result folder.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="CSV",
    help="Write the whole table, with the columns' names of curve.csv.",
)
@force_file_option
def estimate(
    spec: Path,
    overrides: tuple[str, ...],
    beside: Path | None,
    output: Path | None,
    force: bool,
) -> None:
    """Estimate angle or elongation, and what blocks it, over the pressure of a spec.

    A beam whose walls balance the pressure on its cavities (Polygerinos et al. 2013, generalised),
    for PneuNets, bellows, reinforced tubes; thick spheres and tubes exactly. It takes a second and
    is an estimate: coarse runs differ by up to 30 % at half of the pressure, and by more where the
    output says so. `softact run` decides.

    \b
    Examples:
      softact estimate configs/pneunet_glove.yaml
      softact estimate configs/xavier_three_cavities.yaml --set geometry.pitch="12 mm"
      softact estimate configs/pneunet_small.yaml --beside results/pneunet_small
    """
    from softact import spec as specs
    from softact.estimate import estimate as estimated
    from softact.files.text import csv_text, write_atomic
    from softact.results.own_folder import check_file

    loaded = specs.load(spec, overrides)
    if output:
        check_file(output, force, [spec])
    found = estimated(loaded)
    said = _beside(loaded, found, beside) if beside else []
    if output:
        rows = zip(*found.columns.values(), strict=True)
        write_atomic(output, csv_text([dict(zip(found.columns, row, strict=True)) for row in rows]))
    click.echo(f"{found.name}: an estimate, not a solution. {found.method}.")
    for line in _table(found):
        click.echo(line)
    for line in found.reservations:
        click.echo(f"poor here: {line}")
    for line in found.notes:
        click.echo(f"note: {line}")
    for line in said:
        click.echo(f"beside {beside}: {line}")
    if output:
        click.echo(f"wrote {output}")


def _beside(spec: Spec, found: Estimate, directory: Path) -> list[str]:
    from softact.estimate.beside import is_of_another, verdict
    from softact.results.folder import read
    from softact.spec.kinds import expect_results

    expect_results(directory)
    results = read(directory)
    for line in (*results.faults, *results.spec_faults):
        click.echo(line, err=True)
    other = is_of_another(spec, results)
    said = [f"the run is of a spec with other {', '.join(other)}"] if other else []
    return said + verdict(found, results)


def _table(found: Estimate) -> list[str]:
    """Some rows, with the columns right below their heads."""
    from softact.report.labels import column, number

    heads = [str(column(name)) for name in found.columns]
    every = max(1, (len(found.columns[found.pressure]) - 1) // 5)
    rows = [
        [
            number(value * column(name).factor)
            for name, value in zip(found.columns, row, strict=True)
        ]
        for row in list(zip(*found.columns.values(), strict=True))[::every]
    ]
    widths = [max(len(row[n]) for row in [heads, *rows]) for n in range(len(heads))]
    return ["  ".join(text.rjust(w) for text, w in zip(row, widths, strict=True))
            for row in [heads, *rows]]  # fmt: skip

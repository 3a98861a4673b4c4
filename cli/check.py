"""`softact check`: reference cases against stored values."""

import os
import sys
from pathlib import Path

import click

from softact.cli._force import force_file_option


@click.command(short_help="Run reference cases and compare them with stored values.")
@click.argument("cases", nargs=-1, metavar="[CASE]...")
@click.option("--junit", "junit_file", metavar="FILE", help="Write JUnit XML for a CI server.")
@click.option("--update", is_flag=True, help="Store what was found, where softact computed it.")
@click.option("--reason", metavar="TEXT", help="Why values change; goes into the case's file.")
@click.option(
    "-j",
    "--jobs",
    type=click.IntRange(1, 1024),
    default=lambda: len(os.sched_getaffinity(0)),
    metavar="N",
    help="Cases at a time, one thread each.  [default: the number of cores]",
)
@force_file_option
def check(
    cases: tuple[str, ...],
    junit_file: str | None,
    update: bool,
    reason: str | None,
    jobs: int,
    force: bool,
) -> None:
    """Run cases and say in words where a figure is not as stored.

    CASE is a file, or the name of one in configs/reference; by default all of these. Exits with
    1 when anything deviates.

    \b
    Examples:
      softact check
      softact check thick_sphere_yeoh --junit check.xml
      softact check my_finger.yaml --update --reason 'mesh of 1 mm instead of 2 mm'
    """
    from softact.check.cases import find, read
    from softact.check.compare import check_all
    from softact.check.junit import SIGN, junit
    from softact.check.update import update as store
    from softact.errors import SpecError
    from softact.files.text import write_atomic
    from softact.results.own_folder import begins_with, check_file

    if update and not (reason and reason.strip()):
        raise SpecError("--update: say why the values change: --reason 'TEXT'")
    if junit_file and not Path(junit_file).absolute().parent.is_dir():
        raise SpecError(f"--junit {junit_file}: there is no such folder")
    if junit_file:
        path = Path(junit_file)
        check_file(path, force or begins_with(path, SIGN), other="--junit FILE")
    chosen, faults = [], []
    for path in find(cases):
        try:
            chosen.append(read(path))
        except SpecError as error:
            faults += error.lines
    if faults:
        raise SpecError(*faults)
    for line in dict.fromkeys(line for case in chosen for line in case.spec.geometry.notes()):
        click.echo(line, err=True)
    outcomes = []
    for outcome in check_all(chosen, jobs):
        outcomes.append(outcome)
        word = "ok  " if outcome.passed else "FAIL"
        click.echo(f"{word}  {outcome.case.name}  ({outcome.seconds:.1f} s)")
        for line in outcome.lines():
            click.echo(f"      {outcome.case.name}: {line}")
    if junit_file:
        write_atomic(Path(junit_file), junit(sorted(outcomes, key=lambda o: o.case.name)))
    failed = [o for o in outcomes if not o.passed]
    if update:
        for outcome in failed:
            for change in store(outcome, (reason or "").strip()):
                click.echo(f"stored  {outcome.case.name}: {change}")
        failed = [o for o in failed if o.fault or any(d.value.kind != "computed"
                                                      for d in o.differences)]  # fmt: skip
    click.echo(f"{len(outcomes) - len(failed)} of {len(outcomes)} cases are as stored")
    sys.exit(1 if failed else 0)

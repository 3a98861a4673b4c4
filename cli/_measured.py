"""The options ``--measured`` and ``--columns`` of commands that write a report."""

import shlex
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

if TYPE_CHECKING:
    from softact.measured.curve import Measured

Command = TypeVar("Command", bound=Callable[..., object] | click.Command)


def measured_options(command: Command) -> Command:
    """Add ``--measured FILE`` (several) and ``--columns NAMES`` to a command."""
    files = click.option(
        "--measured",
        multiple=True,
        type=click.Path(path_type=Path),
        metavar="FILE",
        help="Set the run against a measured curve, which stays in the result folder. Headings "
        "name columns of curve.csv, in any unit that fits: 'Pressure (bar), Bending angle (rad)'. "
        "May be repeated.",
    )
    headings = click.option(
        "--columns",
        metavar="NAMES",
        help="Headings of the measured files, where they have none or others: "
        "'pressure MPa, chord_angle deg'; '-' skips a column.",
    )
    return files(headings(command))


def read_all(
    files: Sequence[Path], known: Sequence[str], headings: str | None, command: str
) -> list["Measured"]:
    """Read the measured files; say what was left out of them.

    known: columns of the run. command: what the user called, without options. Raises SpecError, a
    line per fault.
    """
    from softact.errors import SpecError
    from softact.measured.curve import read_measured

    if headings is not None and not files:
        raise SpecError("--columns names the columns of --measured FILE, which is not given")
    names = [name.strip() for name in headings.split(",")] if headings else None
    found, faults = [], []
    for file in files:
        try:
            call = f"{command} --measured {shlex.quote(str(file))}"
            found.append(read_measured(file, known, headings=names, command=call))
        except SpecError as error:
            faults += error.lines
    if faults:
        raise SpecError(*faults)
    for measured in found:
        for message in measured.messages:
            click.echo(f"{measured.source}: {message}")
    return found


def tell(directory: Path, measured: Sequence["Measured"]) -> None:
    """Print how far the run in a folder is from measured curves."""
    if not measured:
        return
    from softact.report.overlay import deviations, tell
    from softact.results.folder import read

    curve = read(directory).curve
    for curves in measured:
        for deviation in deviations(curve, curves):
            click.echo(tell(deviation))

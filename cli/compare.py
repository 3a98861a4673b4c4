"""`softact compare`: several result folders in one page."""

from pathlib import Path

import click

from softact.cli._force import force_option
from softact.cli._targets import targets_option


@click.command(short_help="Set two or more result folders against each other.")
@click.argument("folders", nargs=-1, required=True, metavar="DIR DIR...")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    default=Path("results/comparison"),
    show_default=True,
    metavar="DIR",
    help="Folder for compare.html, measures.csv and curves.csv.",
)
@targets_option
@force_option
def compare(folders: tuple[str, ...], output: Path, targets: tuple[str, ...], force: bool) -> None:
    """Set two or more result folders against each other.

    One page: the curves over each other, the measures at the largest load that all reach with
    their differences to the first run, what is different in the specs, and the last states.

    \b
    Example:
      softact compare results/finger results/thin -o results/finger_or_thin
      softact compare results/finger results/finger_blocked --targets index_finger
    """
    from softact.report.compare import write_comparison

    def tell_error(line: str) -> None:
        click.echo(line, err=True)

    paths = [Path(folder) for folder in folders]
    click.echo(f"wrote {write_comparison(paths, output, targets, force, tell_error)}")

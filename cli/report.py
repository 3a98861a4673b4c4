"""`softact report`: the report of a result folder, built anew."""

import click


@click.command(short_help="Rebuild the report of a result folder.")
@click.argument("directory", metavar="DIR")
def report(directory: str) -> None:
    """Rebuild report.html and the pictures of a result folder from the files in it.

    \b
    Example:
      softact report results/pneunet_glove
    """
    from softact.report import write_report

    click.echo(f"wrote {write_report(directory)}")

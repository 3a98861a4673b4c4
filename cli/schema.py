"""`softact schema`: the JSON schemas of a spec and of other files."""

import click

from softact.cli._force import force_file_option

KINDS = ("spec", "sweep", "optimise", "case", "card", "tests")


@click.command(short_help="Print the JSON schema of a spec or another file, for editors.")
@click.option(
    "--kind",
    type=click.Choice(KINDS),
    default="spec",
    show_default=True,
    help="Of a spec, a sweep, an optimisation, a reference case, a material card, or a list of "
    "test data for 'softact fit'.",
)
@click.option(
    "-o", "--output", type=click.Path(dir_okay=False), metavar="FILE", help="Write it to a file."
)
@force_file_option
def schema(kind: str, output: str | None, force: bool) -> None:
    """Print a JSON schema, so that an editor completes and checks the YAML.

    In VS Code and other editors with the YAML language server, put the second line below at the
    top of a spec.

    \b
    Example:
      softact schema -o softact.schema.json
      # yaml-language-server: $schema=softact.schema.json
      softact schema --kind sweep -o sweep.schema.json
    """
    import json
    from pathlib import Path

    from softact.errors import SpecError
    from softact.files.text import write_atomic
    from softact.inputs import schema as schema_of
    from softact.results.own_folder import check_file

    text = json.dumps(schema_of(kind), indent=2, ensure_ascii=False) + "\n"
    if output is None:
        click.echo(text, nl=False)
        return
    if not Path(output).parent.is_dir():
        raise SpecError(f"{output}: there is no folder '{Path(output).parent}'")
    check_file(Path(output), force)
    write_atomic(Path(output), text)
    click.echo(f"wrote {output}")

"""`softact schema`: the JSON schema of a spec."""

import click

from softact.cli._force import force_file_option


@click.command(short_help="Print the JSON schema of a spec, for editors.")
@click.option(
    "-o", "--output", type=click.Path(dir_okay=False), metavar="FILE", help="Write it to a file."
)
@force_file_option
def schema(output: str | None, force: bool) -> None:
    """Print the JSON schema of a spec, so that an editor completes and checks the YAML.

    In VS Code and other editors with the YAML language server, put the second line below at the
    top of a spec.

    \b
    Example:
      softact schema -o softact.schema.json
      # yaml-language-server: $schema=softact.schema.json
    """
    import json
    from pathlib import Path

    from softact.errors import SpecError
    from softact.files import write_atomic
    from softact.output import check_file
    from softact.spec import json_schema

    text = json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n"
    if output is None:
        click.echo(text, nl=False)
        return
    if not Path(output).parent.is_dir():
        raise SpecError(f"{output}: there is no folder '{Path(output).parent}'")
    check_file(Path(output), force)
    write_atomic(Path(output), text)
    click.echo(f"wrote {output}")

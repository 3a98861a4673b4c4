"""`softact doctor`: what this machine has for softact, and what it lacks."""

import json
import sys

import click

from softact.doctor import as_records, as_text, examine, usable


@click.command()
@click.option("--json", "as_json", is_flag=True, help="Print JSON for a program to read.")
def doctor(as_json: bool) -> None:
    """Print versions, the BLAS in use, the solvers, and how to mend what is missing.

    Exits with 2 when no spec could be solved on this machine.
    """
    findings = examine()
    if as_json:
        click.echo(json.dumps({"usable": usable(findings), "findings": as_records(findings)}))
    else:
        click.echo(as_text(findings))
    sys.exit(0 if usable(findings) else 2)

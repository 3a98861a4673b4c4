"""What a study runs as code, said before its first run."""

from collections.abc import Sequence
from typing import Any

import click


def tell_scripts(base: Any, axes: Sequence[Any]) -> None:
    """Say which scripts run where the runs of a study do.

    base: the plain data of its base spec. axes: those of a sweep or an optimisation.
    """
    from softact.scripts import told

    files = [
        file
        for axis in axes
        if "geometry.file" in axis.path
        for file in axis.values or getattr(axis, "choices", None) or ()
    ]
    for line in told(base, files):
        click.echo(line, err=True)

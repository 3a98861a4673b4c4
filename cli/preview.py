"""`softact preview`: what will be solved, drawn before it is."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import click

from softact.cli._force import force_file_option
from softact.cli._options import set_option, timeout_option


@click.command(short_help="Draw and count what a spec will solve, or number a STEP file's faces.")
@click.argument("file", metavar="SPEC|STEP", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help=".html, .png or .inp.  [default: <name>_preview.html]",
)
@set_option
@click.option(
    "--unit",
    type=click.Choice(["um", "mm", "cm", "in", "ft", "m"]),
    help="In which a STEP file is drawn, where it says it wrong or not at all.",
)
@timeout_option
@force_file_option
def preview(
    file: Path,
    output: Path | None,
    overrides: tuple[str, ...],
    unit: str | None,
    timeout: float,
    force: bool,
) -> None:
    """Mesh the actuator of a spec and show it before anything is solved.

    The page shows it cut open, with its named surfaces, supports, loads, obstacles and cavities in
    colours; counts, the quality of the elements, how thick the walls are and how many elements lie
    through them; and about how long a run takes. .png is a picture of the same, .inp the mesh with
    its names for Abaqus or CalculiX. Of a STEP file (.step, .stp) it shows the faces with their
    numbers, which a spec of from_step may name, its size and its solids.

    \b
    Examples:
      softact preview finger.yaml
      softact preview finger.yaml -o finger.png --set geometry.mesh_size="2 mm"
      softact preview part.step
    """
    from softact.geometry.step_part import STEP
    from softact.preview import SUFFIXES, Preview, of_spec, of_step, write
    from softact.preview.words import rows
    from softact.results.own_folder import begins_with, check_file
    from softact.spec import load

    if file.suffix.lower() in STEP:
        if overrides:
            raise click.UsageError(f"--set replaces values of a spec; {file.name} is a STEP file")
        path = output or Path(f"{file.stem}_preview.html")
        look: Callable[[], Preview] = partial(of_step, file, timeout, unit)
    else:
        spec = load(str(file), overrides)
        path = output or Path(f"{spec.name}_preview.html")
        look = partial(of_spec, spec, timeout)
    if path.suffix.lower() not in SUFFIXES:
        raise click.UsageError(f"{path}: write one of {', '.join(SUFFIXES)}")
    own = begins_with(path, b'content="softact"') and path.suffix == ".html"
    check_file(path, force or own, [file])
    found = look()
    write(found, path)
    for name, value in rows(found):
        click.echo(f"{name + ':':18s} {value}")
    for note in found.notes:
        click.echo(f"note: {note}")
    click.echo(f"wrote {path}")

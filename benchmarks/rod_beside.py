"""How far a rod is from the whole actuator: ``python -m benchmarks.rod_beside [SPEC ...]``.

Each spec (by default all of ``benchmarks/rods``) is solved as a rod, with a table of its own, and
as a whole, on the same mesh density. Printed are angle, place of the tip and forces at the end of
each step, of the whole and of the rod, and how far apart the tips are, in percent of the length;
and how long the rod takes. Takes some minutes for each.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import click
import numpy as np

from softact.modules import rod_run
from softact.modules.chain import Chain
from softact.modules.table_file import made_or_read
from softact.results.folder import read
from softact.run.start import run
from softact.spec import load

SPECS = Path(__file__).with_name("rods")
TIP = ("tip_x_mm", "tip_y_mm", "tip_z_mm")
SHOWN = ("bending_angle_deg", *TIP, "blocked_force_N", "reaction_z_N")
INCREMENTS = 10


@click.command()
@click.argument("specs", nargs=-1, type=click.Path(path_type=Path))
@click.option("--set", "overrides", multiple=True, metavar="KEY=VALUE")
def main(specs: tuple[Path, ...], overrides: tuple[str, ...]) -> None:
    """Solve all of them."""
    for path in specs or sorted(SPECS.glob("*.yaml")):
        beside(path, overrides)


def beside(path: Path, overrides: tuple[str, ...]) -> None:
    """One spec as a whole and as a rod."""
    spec = load(path, overrides)
    with tempfile.TemporaryDirectory(prefix="softact-") as scratch:
        started = time.process_time()
        table = made_or_read(spec, Path(scratch) / "none", False, lambda text: None).table
        took = time.process_time() - started
        begun = time.process_time()
        rod = rod_run.run(Chain(spec, table), INCREMENTS)
        states = time.process_time() - begun
        run(spec, Path(scratch) / "run", report=False)
        curve = read(Path(scratch) / "run").curve
    worst = ", ".join(
        f"{name} {100 * off:.2g} %"
        for name, off in zip(table.energy.names, table.errors, strict=True)
    )
    click.echo(
        f"{spec.name}: table {took:.1f} s, {len(table.walked.samples.places)} states, degree "
        f"{table.degree}, held out: {worst}"
    )
    moved = float(rod.rows[-1].get("time_s", 0.0)) if rod.rows else 0.0
    in_time = f" for {moved:g} s of motion" if moved else ""
    click.echo(f"  rod: {len(rod.rows)} states in {states:.2f} s of processor time{in_time}")
    if rod.stopped:
        click.echo(f"  rod: {rod.stopped}")
    for step in spec.steps:
        rows = [row for row in rod.rows if row["step"] == step.name]
        at = [i for i, name in enumerate(curve["step"]) if name == step.name]
        if not rows or not at:
            continue
        row, last = rows[-1], at[-1]
        pairs = ", ".join(
            f"{name} {float(curve[name][last]):.3f} / {float(row[name]):.3f}"
            for name in SHOWN
            if name in row and name in curve
        )
        apart = [float(curve[name][last]) - float(row[name]) for name in TIP]
        far = 100 * np.linalg.norm(apart) / spec.geometry.layout().length
        click.echo(f"  {step.name}, whole / rod: {pairs}; tips {far:.2f} % of the length apart")


if __name__ == "__main__":
    main()

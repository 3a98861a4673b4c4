"""A rod of modules beside the whole finger: ``python -m benchmarks.rod``.

A finger of ``rods/finger.yaml`` goes through its steps as a whole and as a rod, the table of the
rod's law is made before, each as many times as asked, in turn, in one process. Timed is processor
time, so the machine may be busy: of the table with its short actuator and the masses of the
actuator's mesh, of the rod's states, of the whole finger's load steps alone. Prints the medians,
the ratios, and how far off the rod is at the ends of the steps.

The finger with the mesh of ``benchmarks.module``:
``python -m benchmarks.rod --spec benchmarks/rods/finger14.yaml``.
"""

from __future__ import annotations

import resource
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import click

from benchmarks.module import steps as whole_steps
from softact.geometry.base import make_mesh
from softact.modules import rod_run
from softact.modules.rod_run import Chain
from softact.modules.table_file import MadeTable, made_or_read
from softact.results.folder import read
from softact.run.start import run
from softact.spec import Spec, load

SPEC = Path(__file__).with_name("rods") / "finger.yaml"
INCREMENTS = 10
SHOWN = ("bending_angle_deg", "tip_x_mm", "tip_z_mm", "reaction_z_N")


def spent() -> float:
    """Processor time, s, of this process and of those that it started and that have ended."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def timed(work: Callable[[], object]) -> tuple[float, object]:
    """How long some work takes, and what comes of it."""
    started = spent()
    found = work()
    return spent() - started, found


@click.command()
@click.option("--spec", "path", type=click.Path(path_type=Path), default=SPEC)
@click.option("--rounds", type=click.IntRange(1), default=3, show_default=True)
def main(path: Path, rounds: int) -> None:
    """Time all in turn."""
    spec = load(path)
    times: dict[str, list[float]] = {name: [] for name in ("table", "rod", "whole")}
    with tempfile.TemporaryDirectory(prefix="softact-") as scratch:
        mesh = Path(scratch) / "finger.msh"
        make_mesh(spec.geometry, mesh)
        for number in range(rounds):
            took, made = timed(lambda: made_or_read(spec, Path(scratch) / "none", False, _silent))
            times["table"].append(took)
            assert isinstance(made, MadeTable)
            table = made.table
            took, rod = timed(lambda table=table: rod_run.run(Chain(spec, table), INCREMENTS))
            times["rod"].append(took)
            times["whole"].append(whole_steps(spec, mesh)[0])
            said = ", ".join(f"{name} {values[-1]:.2f} s" for name, values in times.items())
            click.echo(f"round {number + 1}: {said}")
        medians = {name: statistics.median(values) for name, values in times.items()}
        for name, value in medians.items():
            click.echo(f"median {name} {value:.3g} s")
        first = medians["table"] + medians["rod"]
        click.echo(f"ratio whole_vs_first {medians['whole'] / first:.2f}")
        click.echo(f"ratio whole_vs_rod {medians['whole'] / medians['rod']:.0f}")
        _beside(spec, rod, Path(scratch))


def _silent(text: str) -> None:
    """Says nothing."""


def _beside(spec: Spec, rod: object, folder: Path) -> None:
    assert isinstance(rod, rod_run.RodRun)
    run(spec, folder / "run", report=False)
    curve = read(folder / "run").curve
    for step in spec.steps:
        at = max(i for i, name in enumerate(curve["step"]) if name == step.name)
        row = [row for row in rod.rows if row["step"] == step.name][-1]
        pairs = (f"{name} {curve[name][at]:.3f} / {float(row[name]):.3f}" for name in SHOWN)
        click.echo(f"{step.name}, whole / rod: " + ", ".join(pairs))


if __name__ == "__main__":
    main()

"""A module's steps beside those of the whole finger: ``python -m benchmarks.module``.

The finger of ``pneunet8.yaml`` with chambers of three steps along x, so that both have the same
mesh (the period is even), and its module go to 20 kPa, in turn, in one process. Timed is the
processor time of the load steps alone, without meshing, set-up and measures, so the machine may be
busy. Prints the median of each and their ratio.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from pathlib import Path

import click
from mpi4py import MPI

from softact.geometry.base import make_mesh
from softact.model import Model
from softact.run.from_spec import build_model, load_steps, supports_of
from softact.solve.stepping import Stepper
from softact.spec import Spec, load

SPEC = Path(__file__).with_name("pneunet8.yaml")


def steps(spec: Spec, mesh: Path) -> tuple[float, Model]:
    """Seconds of this process in the steps of a spec, and the model. Raises RuntimeError."""
    model = build_model(MPI.COMM_SELF, spec, mesh)
    stepper = Stepper(model, spec.solver.settings, lambda state, attempt, number: None)
    supports, all_steps = supports_of(spec.supports or ()), load_steps(spec, model)
    started = time.process_time()
    progress = stepper.run(all_steps, supports)
    took = time.process_time() - started
    if progress.stopped:
        raise RuntimeError(progress.stopped)
    return took, model


@click.command()
@click.option("--chambers", type=click.IntRange(2), default=8, show_default=True)
@click.option("--rounds", type=click.IntRange(1), default=3, show_default=True)
def main(chambers: int, rounds: int) -> None:
    """Time both in turn."""
    whole = load(SPEC, (f"geometry.chambers={chambers}", "geometry.cavity_mesh_size=2 mm"))
    changes = {"supports": [], "geometry.module_alone": True}
    specs = {"finger": whole, "module": whole.with_(changes)}
    times: dict[str, list[float]] = {name: [] for name in specs}
    with tempfile.TemporaryDirectory(prefix="softact-") as scratch:
        for name, spec in specs.items():
            make_mesh(spec.geometry, Path(scratch) / f"{name}.msh")
        for number in range(rounds):
            for name, spec in specs.items():
                took, model = steps(spec, Path(scratch) / f"{name}.msh")
                times[name].append(took)
                click.echo(
                    f"round {number + 1} {name}: {model.unknowns.owned} unknowns, {took:.2f} s"
                )
    medians = {name: statistics.median(values) for name, values in times.items()}
    for name, value in medians.items():
        click.echo(f"median {name} {value:.2f} s")
    click.echo(f"ratio finger_vs_module {medians['finger'] / medians['module']:.1f}")


if __name__ == "__main__":
    main()

"""A module's steps beside those of the whole finger: ``python -m benchmarks.module``.

The finger of ``pneunet8.yaml`` with chambers of three steps along x, so that both have the same
mesh (the period is even), and its module go to 20 kPa, in turn, in one process: the module by the
same load steps (module), and as a table walks it (walker), in as many states as the finger's run
has, each with the stiffness of its cross-section. Timed is the processor time of the states alone,
without meshing, set-up and measures, so the machine may be busy. Prints the median of each, the
ratios, and how far the walker's angle is from that of the load steps. ``--ccx``: CalculiX on the
finger's mesh, too, on one thread: the part of its processor time that its load steps take of its
wall time.
"""

from __future__ import annotations

import resource
import statistics
import tempfile
import time
from pathlib import Path

import click
import numpy as np
from mpi4py import MPI

from benchmarks.calculix import run_ccx
from benchmarks.ccx import quadratic
from softact.geometry.base import make_mesh
from softact.mesh.msh_file import read_msh
from softact.modules.driven import driven
from softact.modules.walker import Held, Walker
from softact.run.from_spec import build_model, load_steps, supports_of
from softact.solve.stepping import Stepper
from softact.spec import Spec, load

SPEC = Path(__file__).with_name("pneunet8.yaml")


def steps(spec: Spec, mesh: Path) -> tuple[float, Stepper]:
    """Seconds of this process in the steps of a spec, and the stepper. Raises RuntimeError."""
    model = build_model(MPI.COMM_SELF, spec, mesh)
    stepper = Stepper(model, spec.solver.settings, lambda state, attempt, number: None)
    supports, all_steps = supports_of(spec.supports or ()), load_steps(spec, model)
    started = time.process_time()
    progress = stepper.run(all_steps, supports)
    took = time.process_time() - started
    if progress.stopped:
        raise RuntimeError(progress.stopped)
    return took, stepper


def walked(spec: Spec, mesh: Path, states: int) -> tuple[float, Held]:
    """The same of a module's walker in so many equal steps of the pressure, and its last state."""
    loads = driven(spec)
    walker = Walker(build_model(MPI.COMM_SELF, spec, mesh), loads.groups)
    started = time.process_time()
    held = walker.begin()
    for part in range(1, states + 1):
        held = walker.released(held, loads.high * part / states)
    return time.process_time() - started, held


def by_calculix(spec: Spec, mesh: Path, folder: Path) -> float:
    """Seconds of CalculiX's process in the steps of a spec, on one thread."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    nodes = quadratic(read_msh(mesh, spec.layout()))
    found = run_ccx(spec, nodes, folder, threads=1)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    return spent * found.solve / found.command


@click.command()
@click.option("--chambers", type=click.IntRange(2), default=8, show_default=True)
@click.option("--rounds", type=click.IntRange(1), default=3, show_default=True)
@click.option("--ccx", is_flag=True, help="CalculiX too; minutes a round.")
def main(chambers: int, rounds: int, ccx: bool) -> None:
    """Time all in turn."""
    whole = load(SPEC, (f"geometry.chambers={chambers}", "geometry.cavity_mesh_size=2 mm"))
    changes = {"supports": [], "geometry.module_alone": True}
    specs = {"finger": whole, "module": whole.with_(changes)}
    times: dict[str, list[float]] = {name: [] for name in (*specs, "walker")}
    with tempfile.TemporaryDirectory(prefix="softact-") as scratch:
        meshes = {name: Path(scratch) / f"{name}.msh" for name in specs}
        for name, spec in specs.items():
            make_mesh(spec.geometry, meshes[name])
        for number in range(rounds):
            found = {}
            for name, spec in specs.items():
                took, found[name] = steps(spec, meshes[name])
                times[name].append(took)
                unknowns = found[name].model.unknowns.owned
                click.echo(f"round {number + 1} {name}: {unknowns} unknowns, {took:.2f} s")
            states = sum(a.converged for a in found["finger"].progress.attempts) - 1
            took, held = walked(specs["module"], meshes["module"], states)
            times["walker"].append(took)
            click.echo(f"round {number + 1} walker: {states} states, {took:.2f} s")
            if ccx:
                folder = Path(scratch) / f"ccx{number}"
                folder.mkdir()
                took = by_calculix(whole, meshes["finger"], folder)
                times.setdefault("ccx", []).append(took)
                click.echo(f"round {number + 1} ccx: {took:.1f} s")
    repeat = found["module"].model.repeat
    assert repeat is not None
    turn = np.linalg.norm(repeat.motion(found["module"].state.x)[0])
    click.echo(f"angle {np.degrees(turn):.5f} degrees by the steps")
    click.echo(f"walker off by {held.strain[0] * repeat.length / turn - 1:.1e}")
    medians = {name: statistics.median(values) for name, values in times.items()}
    for name, value in medians.items():
        click.echo(f"median {name} {value:.2f} s")
    for name in ("module", "walker"):
        click.echo(f"ratio finger_vs_{name} {medians['finger'] / medians[name]:.1f}")
    if ccx:
        click.echo(f"ratio ccx_vs_module {medians['ccx'] / medians['module']:.0f}")


if __name__ == "__main__":
    main()

"""What must hold of every accepted state, over specs and drawn specs: see ``benchmarks.watch``.

``python -m benchmarks.invariants [SPEC ...] [--random 100] [--coarse 2] [--limit 300]`` solves each
spec, and the first so many of ``benchmarks.random_specs``, in a process of its own and tells how
many states were looked at and what is wrong with them. A run that is stopped by the limit counts
with the states that it came to.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import click
import yaml

from benchmarks.random_specs import SEED, draw
from benchmarks.watch import Watch
from softact.errors import SoftactError
from softact.spec import Spec, load


def watched(spec: Spec, told=lambda watch: None) -> Watch:
    """Solve a spec in this process and watch its accepted states.

    told: called after each of them. Raises SoftactError as a run does.
    """
    from mpi4py import MPI

    from softact.geometry.base import make_mesh
    from softact.run.from_spec import build_model, load_steps, supports_of
    from softact.solve.stepping import Stepper

    with tempfile.TemporaryDirectory() as folder:
        mesh = Path(folder) / "mesh.msh"
        make_mesh(spec.geometry, mesh, curved=spec.solver.curved)
        model = build_model(MPI.COMM_SELF, spec, mesh)
    watch = Watch(model)

    def see(state, attempt, number) -> None:
        watch(state, attempt, number)
        told(watch)

    Stepper(model, spec.solver.settings, see).run(
        load_steps(spec, model), supports_of(spec.supports)
    )
    watch.end()
    return watch


def coarse(path: Path, factor: float) -> Spec:
    """A spec with edges so many times as long, and no more elements through its walls than one."""
    spec = load(str(path))
    geometry = spec.geometry
    changes = {"mesh_size": factor * geometry.mesh_size} if factor != 1 else {}
    return spec.model_copy(update={"geometry": geometry.model_copy(update=changes)})


def tell(watch: Watch) -> None:
    """A line of JSON on how far a run is."""
    print(json.dumps({"states": watch.states, "faults": watch.faults}), flush=True)


def judged(path: Path, factor: float, limit: float) -> dict:
    """states, faults and how a run in a process of its own ended."""
    command = [sys.executable, "-m", "benchmarks.invariants", "--one", str(path)]
    command += ["--coarse", str(factor)]
    began, end = time.perf_counter(), ""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit, check=False)
        out, end = done.stdout, done.stderr.strip()[-200:] if done.returncode else ""
    except subprocess.TimeoutExpired as stopped:
        out, end = (stopped.stdout or b"").decode(), f"stopped after {limit:g} s"
    lines = [line for line in out.splitlines() if line.startswith("{")]
    found = json.loads(lines[-1]) if lines else {"states": 0, "faults": []}
    return {**found, "end": end, "seconds": time.perf_counter() - began}


def drawn(count: int, folder: Path) -> Iterator[Path]:
    """Files of the first drawn specs."""
    for number in range(count):
        path = folder / f"drawn_{number:03d}.yaml"
        path.write_text(yaml.safe_dump(draw(number, SEED)[0], sort_keys=False), encoding="utf-8")
        yield path


@click.command(help=__doc__)
@click.argument("specs", nargs=-1, type=click.Path(path_type=Path, exists=True))
@click.option("--random", "count", type=click.IntRange(0), default=0, show_default=True)
@click.option("--coarse", "factor", type=float, default=1.0, show_default=True)
@click.option("--limit", default=300.0, show_default=True, help="Seconds for one run.")
@click.option("--one", is_flag=True, hidden=True)
def main(specs, count, factor, limit, one) -> None:
    """Look at all, and end with 1 where something is wrong."""
    if one:
        tell(watched(coarse(specs[0], factor), tell))
        return
    states = faults = 0
    with tempfile.TemporaryDirectory() as folder:
        for path in [*specs, *drawn(count, Path(folder))]:
            found = judged(path, factor if path in specs else 1.0, limit)
            states, faults = states + found["states"], faults + len(found["faults"])
            click.echo(
                f"{path.stem}: {found['states']} states, {len(found['faults'])} faults, "
                f"{found['seconds']:.0f} s {found['end']}"
            )
            for fault in found["faults"]:
                click.echo(f"  {fault}")
    click.echo(f"{states} states, {faults} faults")
    sys.exit(bool(faults))


if __name__ == "__main__":
    try:
        main()
    except SoftactError as error:
        sys.exit(str(error))

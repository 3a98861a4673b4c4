"""softact and CalculiX side by side: ``python -m benchmarks.calculix``.

Both solve the problem of ``pneunet8.yaml`` on the same mesh, one after the other and alternating,
on an otherwise idle machine. See README.md for what is timed.
"""

from __future__ import annotations

import csv
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import click
import numpy as np

from benchmarks import ccx, hexahedra
from softact.errors import SoftactError
from softact.files.text import write_atomic
from softact.geometry.base import make_mesh
from softact.mesh.msh_file import read_msh
from softact.solve import pardiso
from softact.spec import load

SPEC = Path(__file__).with_name("pneunet8.yaml")
SMALL = ("geometry.chambers=4", "geometry.cavity_mesh_size=4 mm", "steps.0.pressure=15 kPa")
RESULTS = Path("results/benchmark_calculix")
THREADS = 2
RACE = 20
PARDISO = "softact_n2_pardiso"


@dataclass(frozen=True)
class Measured:
    """One run. Times in s: of the whole command, and of the load steps alone. iterations: all,
    also of increments that were cut; increments: accepted ones. tip: displacement (x, z) of the
    centre of the tip's face, mm; volume: change of the cavity's volume, whole actuator, mm³."""

    command: float
    solve: float
    increments: int
    iterations: int
    tip: tuple[float, float]
    volume: float


def run_ccx(spec, mesh, folder: Path, threads: int = THREADS, limit=None) -> Measured:
    """Solve a spec with CalculiX at its default tolerances, in at most ``limit`` seconds."""
    job = folder / "job.inp"
    ccx.write_input(job, mesh, spec)
    found = ccx.run(job, len(mesh.points), threads, limit)
    tip, volume = measures(spec, mesh, found.displacement[-1])
    return Measured(
        found.wall_time, found.solve_time, found.increments, found.iterations, tip, volume
    )


def measures(spec, mesh: ccx.QuadraticMesh, displacement) -> tuple[tuple[float, float], float]:
    """Tip displacement (x, z) and volume change of the whole actuator, as in ``Measured``."""
    layout = spec.geometry.layout()
    walls = [name for names in layout.cavities.values() for name in names]
    change = ccx.cavity_volume(mesh, displacement, walls) - ccx.cavity_volume(
        mesh, np.zeros_like(displacement), walls
    )
    x, _, z = ccx.surface_mean(mesh, displacement, layout.tip)
    return (float(x), float(z)), layout.copies * change


def run_softact(spec_file: Path, cells: int, processes: int, folder: Path) -> Measured:
    """Solve a spec with ``softact run``, as a user would.

    Raises SoftactError where it fails or where its mesh has not ``cells`` tetrahedra.
    """
    environment = {k: v for k, v in os.environ.items() if not k.endswith("_NUM_THREADS")}
    softact = Path(sys.executable).with_name("softact")
    command = [softact, "run", spec_file, "-n", str(processes), "-o", folder]
    started = time.perf_counter()
    done = subprocess.run(
        list(map(str, command)), env=environment, capture_output=True, text=True, check=False
    )
    wall = time.perf_counter() - started
    if done.returncode:
        raise SoftactError(f"softact run ended with {done.returncode}", done.stderr.strip())
    told = json.loads((folder / "run.json").read_text())
    if told["mesh"]["cells"] != cells:
        raise SoftactError(f"softact meshed {told['mesh']['cells']} tetrahedra, not {cells}")
    return Measured(
        wall,
        told["times_s"]["solve"],
        told["counts"]["increments"],
        told["counts"]["newton_iterations"],
        *read_curve(folder),
    )


def read_curve(folder: Path) -> tuple[tuple[float, float], float]:
    """Tip displacement (x, z) and volume change of a result folder, as in ``Measured``."""
    with (folder / "curve.csv").open() as file:
        rows = list(csv.DictReader(file))
    x, z, volume = (
        float(rows[-1][name]) - float(rows[0][name])
        for name in ("tip_x_mm", "tip_z_mm", "cavity_volume_mm3")
    )
    return (x, z), volume


def deviation(one: Measured, other: Measured) -> tuple[float, float]:
    """Relative difference of the tip's displacement (as vectors) and of the volume change."""
    gap = np.subtract(one.tip, other.tip)
    return (
        float(np.linalg.norm(gap) / np.linalg.norm(other.tip)),
        abs(one.volume / other.volume - 1),
    )


def median(runs: list[Measured]) -> Measured:
    """The last run with the medians of all times."""
    times = {n: statistics.median(getattr(r, n) for r in runs) for n in ("command", "solve")}
    return Measured(**{**asdict(runs[-1]), **times})


def table(results: dict[str, Measured], reference: Measured) -> str:
    """Markdown table of the medians; deviations are from ``reference``."""
    head = (
        "| | command s | solve s | increments | iterations | tip x mm | tip z mm "
        "| cavity mm³ | tip differs | cavity differs |"
    )
    lines = [head, "|---" * 10 + "|"]
    for name, m in results.items():
        gap, volume = deviation(m, reference)
        lines.append(
            f"| {name} | {m.command:.1f} | {m.solve:.1f} | {m.increments} | {m.iterations} "
            f"| {m.tip[0]:.3f} | {m.tip[1]:.3f} | {m.volume:.1f} | {gap:.2%} | {volume:.2%} |"
        )
    return "\n".join(lines)


def ratios(results: dict[str, Measured]) -> dict[str, float]:
    """How many times faster than CalculiX: whole commands, and the load steps alone."""
    reference, found = results["ccx"], {}
    for name in ("softact_n2", "softact_n1", *({PARDISO} & set(results))):
        found[f"{name}_vs_ccx"] = reference.command / results[name].command
        found[f"{name}_solve_vs_ccx"] = reference.solve / results[name].solve
    return found


@click.command()
@click.option("--rounds", type=click.IntRange(1), default=1, show_default=True)
@click.option("--small", is_flag=True, help="Four chambers on a coarse mesh, for a quick look.")
@click.option("--same-element", is_flag=True, help="Also run softact's P2; slow at full size.")
@click.option("--bricks", is_flag=True, help="Also run CalculiX's C3D20R on the same grid; slow.")
@click.option("--race", metavar="LOAD", help="softact, then CalculiX for 20 times as long.")
@click.option("-o", "--output", type=click.Path(path_type=Path), default=RESULTS)
def main(
    rounds: int, small: bool, same_element: bool, bricks: bool, race: str | None, output: Path
) -> None:
    """Time softact beside CalculiX on the same mesh; medians of the rounds."""
    try:
        if race:
            run_race(race)
            return
        compare(rounds, small, same_element, bricks, output)
    except SoftactError as error:
        click.echo("\n".join(error.lines), err=True)
        sys.exit(error.exit_code)


def compare(rounds: int, small: bool, same_element: bool, bricks: bool, output: Path) -> None:
    """Run all, print the table and the ratios, write results.json and results.md."""
    output.mkdir(parents=True, exist_ok=True)
    load_before = os.getloadavg()[0]
    if load_before > 0.5:
        click.echo(f"the load is {load_before:.1f}: these times say nothing about an idle machine")
    specs = {
        element: load(str(SPEC), (*(SMALL if small else ()), f"solver.element={element}"))
        for element in ("P2/P1", "P2")
    }
    spec = specs["P2/P1"]
    with tempfile.TemporaryDirectory(prefix="softact-") as scratch:
        folder = Path(scratch)
        make_mesh(spec.geometry, folder / "mesh.msh")
        mesh = ccx.quadratic(read_msh(folder / "mesh.msh", spec.geometry.layout()))
        files = {element: folder / f"{element.replace('/', '')}.yaml" for element in specs}
        for element, file in files.items():
            file.write_text(specs[element].to_yaml())
        cells = len(mesh.cells)
        click.echo(f"{cells} tetrahedra, {len(mesh.points)} displacement nodes")
        _warm_up(folder)
        jobs = {
            "ccx": lambda: run_ccx(spec, mesh, folder),
            "softact_n1": lambda: run_softact(files["P2/P1"], cells, 1, folder / "n1"),
            "softact_n2": lambda: run_softact(files["P2/P1"], cells, 2, folder / "n2"),
        }
        if pardiso.library() is not None:
            by_pardiso = folder / "pardiso.yaml"
            solver = spec.solver.model_copy(update={"factor": "pardiso"})
            by_pardiso.write_text(spec.model_copy(update={"solver": solver}).to_yaml())
            jobs[PARDISO] = lambda: run_softact(by_pardiso, cells, 2, folder / "n2_pardiso")
        runs: dict[str, list[Measured]] = {name: [] for name in jobs}
        for _ in range(rounds):
            for name, job in jobs.items():
                runs[name].append(job())
                last = runs[name][-1]
                click.echo(f"{name}: command {last.command:.1f} s, solve {last.solve:.1f} s")
        results = {name: median(found) for name, found in runs.items()}
        if same_element:
            # CalculiX's element in softact: what is left then is no matter of elements.
            results["softact_n2_P2"] = run_softact(files["P2"], cells, 2, folder / "p2")
        if bricks:
            # A CalculiX element that does not lock, on the grid that the tetrahedra were cut from.
            g = spec.geometry
            grid = g.solid().mesh(g.mesh_size, g.cavity_mesh_size or g.mesh_size)
            results["ccx_C3D20R"] = run_ccx(spec, hexahedra.bricks(grid), folder)
    faster = ratios(results)
    text = (
        table(results, results.get("ccx_C3D20R", results["ccx"]))
        + "\n\n"
        + "\n".join(f"ratio {n} {v:.1f}" for n, v in faster.items())
    )
    click.echo(text)
    write_atomic(output / "results.md", text + "\n")
    told = {
        "small": small,
        "rounds": rounds,
        "cells": cells,
        "nodes": len(mesh.points),
        "machine": {
            "platform": platform.platform(),
            "cores": len(os.sched_getaffinity(0)),
            "load_before": load_before,
        },
        "medians": {name: asdict(m) for name, m in results.items()},
        "runs": {name: [asdict(m) for m in found] for name, found in runs.items()},
        "ratios": faster,
    }
    write_atomic(output / "results.json", json.dumps(told, indent=1) + "\n")


def run_race(pressure: str) -> None:
    """Medians of three of softact, and whether CalculiX arrives within RACE times as long."""
    spec = load(str(SPEC), (f"steps.0.pressure={pressure}",))
    with tempfile.TemporaryDirectory(prefix="softact-") as scratch:
        folder = Path(scratch)
        make_mesh(spec.geometry, folder / "mesh.msh")
        mesh = ccx.quadratic(read_msh(folder / "mesh.msh", spec.geometry.layout()))
        (folder / "spec.yaml").write_text(spec.to_yaml())
        _warm_up(folder)
        cells = len(mesh.cells)
        runs = [run_softact(folder / "spec.yaml", cells, 2, folder / "n2") for _ in range(3)]
        ours = median(runs)
        click.echo(f"softact_n2: command {ours.command:.1f} s, solve {ours.solve:.1f} s")
        try:
            theirs = run_ccx(spec, mesh, folder, limit=RACE * ours.command)
        except SoftactError as error:
            click.echo(f"{error.lines[0].split(';')[0]}, after {RACE * ours.command:.0f} s")
            click.echo(f"ratio softact_n2_vs_ccx more than {RACE}")
            return
        click.echo(f"ratio softact_n2_vs_ccx {theirs.command / ours.command:.1f}")


def _warm_up(folder: Path) -> None:
    """Have softact compile its forms: that happens once per machine, not once per run."""
    spec = load(str(SPEC), (*SMALL, "geometry.chambers=1", "steps.0.pressure=1 kPa"))
    file = folder / "warm.yaml"
    for element in ("P2/P1", "P2"):
        solver = spec.solver.model_copy(update={"element": element})
        file.write_text(spec.model_copy(update={"solver": solver}).to_yaml())
        subprocess.run(
            [Path(sys.executable).with_name("softact"), "run", file, "-o", folder / "warm"],
            capture_output=True,
            check=True,
        )


if __name__ == "__main__":
    main()

"""Cost against size: ``python -m benchmarks.size``.

The finger of ``pneunet8.yaml`` on finer and finer meshes, one load step in one increment with
``softact run -n 2``: seconds per factorisation, memory of all solver processes, and the exponents
of power laws fitted to them. The machine must be idle.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import click
import numpy as np

SPEC = Path(__file__).with_name("pneunet8.yaml")
# Edge lengths in mm (elsewhere, around the cavity) and the unknowns that they give.
MESHES = {
    "20k": (6.0, 3.0),
    "80k": (4.0, 1.6),
    "300k": (2.4, 0.95),
    "700k": (1.5, 0.55),
    "1M": (1.3, 0.48),
}
LOAD = "2 kPa"


def measure(sizes: tuple[float, float], folder: Path, options: tuple[str, ...]) -> dict:
    """Run one mesh; figures of its run.json."""
    mesh, cavity = sizes
    command = [
        Path(sys.executable).with_name("softact"), "run", SPEC, "-n", "2", "-o", folder,
        "--set", f"geometry.mesh_size={mesh} mm", "--set", f"geometry.cavity_mesh_size={cavity} mm",
        "--set", f"steps.0.pressure={LOAD}", "--set", "steps.0.max_increment=1",
        "--set", "solver.initial_increment=1", "--set", "solver.max_increment=1",
        "--set", "measures=[bending]", *options,
    ]  # fmt: skip
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stderr.strip()[-600:]}")
    told = json.loads((folder / "run.json").read_text())
    times, counts = told["times_s"], told["counts"]
    return {
        "unknowns": told["mesh"]["unknowns"],
        "iterations": counts["newton_iterations"],
        "factorisations": counts["factorisations"],
        "factorisation_s": times["linear_solves"] / counts["factorisations"],
        "assembly_s": times["assembly"] / counts["factorisations"],
        "step_s": times["solve"],
        "memory_MB": told["memory_MB"],
    }


def exponent(rows: list[dict], name: str) -> float:
    """b of ``name`` ~ unknowns^b, by least squares of the logarithms."""
    x, y = (np.log([row[key] for row in rows]) for key in ("unknowns", name))
    return float(np.polyfit(x, y, 1)[0])


@click.command()
@click.option("--up-to", type=click.Choice(list(MESHES)), default="1M", show_default=True)
@click.option("--set", "settings", multiple=True, help="Further settings of the spec.")
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("results/size"))
def main(up_to: str, settings: tuple[str, ...], output: Path) -> None:
    """Measure all sizes, print the table and the exponents."""
    options = tuple(part for setting in settings for part in ("--set", setting))
    rows = []
    click.echo("| unknowns | factorisations | s each | assembly s | step s | memory MB |")
    click.echo("|" + "---|" * 6)
    for name, sizes in MESHES.items():
        row = measure(sizes, output / name, options)
        rows.append(row)
        click.echo(
            f"| {row['unknowns']:,} | {row['factorisations']} | {row['factorisation_s']:.3g} "
            f"| {row['assembly_s']:.3g} | {row['step_s']:.4g} | {row['memory_MB']:,} |"
        )
        if name == up_to:
            break
    for name in ("factorisation_s", "assembly_s", "memory_MB"):
        click.echo(f"exponent {name} {exponent(rows, name):.2f}")


if __name__ == "__main__":
    main()

"""What a law costs in the solver: ``python -m benchmarks.laws``.

Matrix and force of one Newton iteration are assembled for several laws on the same mesh and at the
same states, in turn. Times are processor time of this process, which must have one thread, so that
other work on the machine disturbs little.
"""

from __future__ import annotations

import os
import statistics
import tempfile
import time
from pathlib import Path

import click
import numpy as np

from softact.spec import load

SPEC = Path(__file__).with_name("pneunet8.yaml")
LAWS = {
    "yeoh": {"law": "yeoh", "c10": 0.11, "c20": 0.02, "c30": 1e-3},
    "neo_hookean": {"law": "neo_hookean", "c10": 0.14},
    "mooney_rivlin": {"law": "mooney_rivlin", "c10": 0.11, "c01": 0.03},
    "ogden": {
        "law": "ogden",
        "mu": [1.887e-3, 2.225e-2, 3.574e-3],
        "alpha": [-3.848, 0.663, 4.225],
    },
    "arruda_boyce": {"law": "arruda_boyce", "mu": 0.2, "lambda_m": 3.0},
    "gent": {"law": "gent", "mu": 0.3, "jm": 60.0},
    "linear": {"law": "linear", "youngs_modulus": 0.9, "poissons_ratio": 0.49},
    "holzapfel": {
        "law": "holzapfel",
        "c10": 0.3,
        "k1": 0.6,
        "k2": 0.4,
        "kappa": 0.1,
        "angle": 30.0,
    },
}


class Assembly:
    """A model of one law and the states at which it is assembled."""

    def __init__(self, mesh, name: str, wall_normal):
        from softact.bodies.last_few import COUNT
        from softact.materials import LAWS as CLASSES
        from softact.model import Model
        from softact.system.term import State

        constants = {key: value for key, value in LAWS[name].items() if key != "law"}
        law = CLASSES[LAWS[name]["law"]].of(**constants)
        self.model = Model(mesh, {"body": law.material()}, wall_normal=wall_normal)
        self.solid = self.model.solids["body"]
        rng = np.random.default_rng(1)
        self.states = []
        for _ in range(COUNT + 1):  # in turn: a solid remembers what it evaluated last
            state = State(np.zeros(self.model.unknowns.local))
            dofs = self.model.displacement_dofs
            state.x[dofs] = 0.02 * rng.standard_normal(dofs.shape)
            self.states.append(state)

    def once(self, number: int) -> dict[str, float]:
        """Seconds of the law alone, the force and the matrix."""
        state, times = self.states[number % len(self.states)], {}
        out = np.zeros(self.model.unknowns.local)
        actions = {
            "law": lambda: self.solid._evaluate(state),
            "force": lambda: self.solid.add_force(state, out),
            "matrix": lambda: (
                self.model.assembler.clear(),
                self.solid.add_tangent(state, None),
                self.model.assembler.finish_matrix(),
            ),
        }
        for what, action in actions.items():
            started = time.process_time()
            action()
            times[what] = time.process_time() - started
        return times


def measure(names: list[str], rounds: int) -> tuple[int, dict[str, dict[str, float]]]:
    """Cells of the mesh, and law -> medians in seconds."""
    from mpi4py import MPI

    from softact.geometry.base import make_mesh
    from softact.mesh.msh_file import read_msh
    from softact.mesh.tetrahedra import distribute

    geometry = load(SPEC).geometry
    layout = geometry.layout()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mesh.msh"
        make_mesh(geometry, path)
        mesh = distribute(MPI.COMM_SELF, lambda: read_msh(path, layout), layout)
    assemblies = {name: Assembly(mesh, name, geometry.wall_normal) for name in names}
    times: dict[str, list[dict[str, float]]] = {name: [] for name in names}
    for number in range(rounds + 1):
        for name, assembly in assemblies.items():
            times[name].append(assembly.once(number))
    medians = {
        name: {what: statistics.median(t[what] for t in ts[1:]) for what in ts[0]}
        for name, ts in times.items()
    }
    return mesh.cell_count, medians


@click.command()
@click.option("--rounds", default=15, show_default=True, help="Assemblies of each law.")
@click.option("--law", "names", multiple=True, type=click.Choice(list(LAWS)), help="Default: all.")
def main(rounds: int, names: tuple[str, ...]) -> None:
    """Print milliseconds per law, and the ratio of Ogden with three terms to Yeoh."""
    if os.environ.get("OPENBLAS_NUM_THREADS") != "1":
        click.echo("warning: set OPENBLAS_NUM_THREADS=1, or threads count as time", err=True)
    cells, found = measure(list(dict.fromkeys(("yeoh", "ogden", *(names or LAWS)))), rounds)
    click.echo(f"{cells} tetrahedra, medians of {rounds}, ms")
    click.echo(f"{'law':14s} {'law':>8s} {'force':>8s} {'matrix':>8s} {'all':>8s} {'to yeoh':>8s}")
    whole = {name: sum(times.values()) for name, times in found.items()}
    for name, times in found.items():
        cells_ms = " ".join(f"{1e3 * t:8.1f}" for t in (*times.values(), whole[name]))
        click.echo(f"{name:14s} {cells_ms} {whole[name] / whole['yeoh']:8.2f}")
    click.echo(f"ratio ogden_assembly_vs_yeoh {whole['ogden'] / whole['yeoh']:.2f}")


if __name__ == "__main__":
    main()

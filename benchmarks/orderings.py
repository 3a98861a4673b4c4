"""Orders of elimination: ``python -m benchmarks.orderings SPEC...``.

The tangent of each spec's body at rest is analysed and factorised with MUMPS's own ordering and
with METIS's, in turn: operations, estimated memory, seconds of the analysis and of a factorisation
(medians), and how far the answers to one right-hand side are apart. For several processes:
``mpirun -n 2 python -m benchmarks.orderings SPEC...``.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from pathlib import Path

import click
import numpy as np
from mpi4py import MPI

from softact.geometry.base import make_mesh
from softact.run.from_spec import build_model, supports_of
from softact.solve.analysis import METIS
from softact.solve.newton import Newton
from softact.spec import load

COMM = MPI.COMM_WORLD
OWN = "MUMPS's own"


class Case:
    """The tangent of one spec at rest."""

    def __init__(self, spec_file: Path, settings: tuple[str, ...], folder: Path):
        spec = load(spec_file, settings)
        mesh = folder / f"{spec_file.stem}.msh"
        if COMM.rank == 0:
            make_mesh(spec.geometry, mesh)
        COMM.barrier()
        self.model = build_model(COMM, spec, mesh)
        self.newton = Newton(self.model, 1e-6, 20)
        self.state = self.model.initial_state()
        self.newton.set_supports(supports_of(spec.supports or ()), self.state)
        self.model.tangent(self.state)
        unknowns = self.model.unknowns
        self.right, self.answer = unknowns.create_vector(), unknowns.create_vector()
        force = np.random.default_rng(1).standard_normal(COMM.allreduce(unknowns.owned))
        first, last = self.right.getOwnershipRange()
        self.right.setArray(force[first:last])

    def once(self, ordering: str) -> tuple[float, float, np.ndarray]:
        """Seconds of the analysis and of a factorisation, and the answer (owned,)."""
        factor = self.newton.factor
        factor.analyst.kept = ordering
        factor.set_up()
        started = time.perf_counter()
        factor.follow_layout()
        analysed = time.perf_counter()
        factor.again()
        factorised = time.perf_counter()
        factor.solve(self.right, self.answer)
        return analysed - started, factorised - analysed, self.answer.getArray().copy()

    def rows(self, rounds: int) -> list[str]:
        """One line for each ordering."""
        runs = {ordering: [] for ordering in (OWN, METIS)}
        said, answers = {}, {}
        for _ in range(rounds):
            for ordering, times in runs.items():
                *seconds, answers[ordering] = self.once(ordering)
                times.append(seconds)
                said[ordering] = self.newton.factor.analysis
        norms = [
            COMM.allreduce(float(np.sum(v**2))) ** 0.5
            for v in (answers[METIS] - answers[OWN], answers[OWN])
        ]
        lines = []
        for ordering, times in runs.items():
            analysis, numeric = (statistics.median(column) for column in zip(*times, strict=True))
            last = said[ordering]
            lines.append(
                f"| {last.ordering} | {last.operations[last.ordering]:.3g} | {last.memory_MB:,} "
                f"| {analysis:.2f} | {numeric:.2f} | {norms[0] / norms[1]:.1e} |"
            )
        return lines


@click.command()
@click.argument("specs", nargs=-1, required=True, type=click.Path(exists=True, path_type=Path))
@click.option("--set", "settings", multiple=True, help="Settings of the specs.")
@click.option("--rounds", default=3, show_default=True)
def main(specs: tuple[Path, ...], settings: tuple[str, ...], rounds: int) -> None:
    """Print the table."""
    head = "| spec | unknowns | ordering | operations | memory MB | analysis s | factor s | apart |"
    if COMM.rank == 0:
        click.echo(f"{COMM.size} processes\n{head}\n" + "|---" * 8 + "|")
    with tempfile.TemporaryDirectory() as folder:
        for spec in specs:
            case = Case(spec, settings, Path(COMM.bcast(folder)))
            unknowns = COMM.allreduce(case.model.unknowns.owned)
            for line in case.rows(rounds):
                if COMM.rank == 0:
                    click.echo(f"| {spec.stem} | {unknowns:,} {line}")
        COMM.barrier()


if __name__ == "__main__":
    main()

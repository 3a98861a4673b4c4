"""A block under a known pull, solved beside its exact answer.

Whether the releases of dolfinx, FFCx, PETSc, MUMPS, MPI and the compiler on this machine go
together, their version numbers do not say. A block of six tetrahedra (P2/P1) in processes as a run
has them does: they all take part in it.
"""

import json
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from itertools import permutations
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from softact.doctor.finding import Finding, State
from softact.doctor.supply import packages
from softact.files.streams import UTF8
from softact.run import launch

if TYPE_CHECKING:
    from mpi4py import MPI

    from softact.mesh.tetrahedra import Tetrahedra

C10, BULK = 0.1, 1.0  # MPa; soft in volume too, so that the pressure unknowns have work to do
STRETCH = 1.5
TOLERANCE = 1e-6  # of the stretch; 1e-9 is usual
SECONDS = 300  # a first compilation on a slow machine takes 20


def look_at_a_block() -> Iterable[Finding]:
    """One process first, then two, as `softact run` takes where there are two cores."""
    alone = _tried(1)
    yield alone
    if alone.state == "ok":
        yield _tried(2)


def _tried(processes: int) -> Finding:
    name = "a block" if processes == 1 else "two processes"
    bad: State = "broken" if processes == 1 else "slow"
    mend = "" if processes == 1 else _alone()
    started = time.perf_counter()
    try:
        answer = _answer(processes)
    except _FailedError as error:
        return Finding(name, bad, f"not solved: {error}", mend)
    deviation = abs(answer["stretch"] / STRETCH - 1)
    if answer["processes"] != processes:
        detail = f"mpirun started {processes} that know nothing of each other: another MPI's"
        return Finding(name, bad, detail, mend)
    if not deviation < TOLERANCE:
        wrong = f"stretched to {answer['stretch']:.6g} where {STRETCH} is exact"
        return Finding(name, bad, wrong, mend)
    took = time.perf_counter() - started
    return Finding(name, "ok", f"solved, {deviation:.0e} off the exact answer, in {took:.1f} s")


def _alone() -> str:
    return f"{packages('openmpi-bin', 'python3-mpi4py')}; until then: softact run -n 1"


class _FailedError(Exception):
    """The processes of a trial gave no answer; what they said last."""


def _answer(processes: int) -> dict[str, float]:
    """What ``main`` prints in processes of its own: a crash of theirs is not ours."""
    try:
        with tempfile.TemporaryDirectory() as folder:
            variables = launch.variables(processes, 1, Path(folder))
            done = subprocess.run(
                launch.command(processes, ["-m", "softact.doctor.trial"], variables),
                cwd=folder,
                env=variables,
                capture_output=True,
                timeout=SECONDS,
                **UTF8,
            )
        return json.loads(done.stdout.splitlines()[-1])
    except subprocess.TimeoutExpired:
        raise _FailedError(f"no answer within {SECONDS} s") from None
    except OSError as error:
        raise _FailedError(f"{error.filename}: {error.strerror}") from None
    except (IndexError, ValueError):
        raise _FailedError(_last_words(done.stderr) or f"exit code {done.returncode}") from None


def _last_words(text: str) -> str:
    """The error, or else the last line that says something: mpirun frames its own with dashes."""
    words = [line.strip() for line in text.splitlines() if line.strip(" -")]
    errors = [line for line in words if re.match(r"[\w.]*Error\b", line)]
    return errors[0] if errors else (words or [""])[-1]


def block() -> "Tetrahedra":
    """The unit cube in six tetrahedra about its diagonal, in mm."""
    from softact.mesh.tetrahedra import FACET_VERTICES, Tetrahedra

    points = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    ways = (np.cumsum([0, *order]) for order in permutations((4, 2, 1)))  # along three edges
    cells = np.array(list(ways))
    facets = cells[:, FACET_VERTICES].reshape(-1, 3)
    sides = {
        name: facets[(points[facets, axis] == place).all(axis=1)]
        for name, axis, place in (("x", 0, 0.0), ("y", 1, 0.0), ("z", 2, 0.0), ("pulled", 0, 1.0))
    }
    return Tetrahedra(points, cells, np.zeros(len(cells), np.int32), sides)


def pull() -> float:
    """Force per undeformed area in MPa that stretches the block to ``STRETCH``.

    W = C10 (Ī1 - 3) + K/2 (J - 1)²: the stress across, 2 C10 J^(-5/3) (b - I1/3) + K (J - 1) with
    b the square of the stretch across, vanishes.
    """
    from scipy.optimize import brentq

    def stress(squared: float, across: float) -> float:
        volume = STRETCH * across**2
        mean = (STRETCH**2 + 2 * across**2) / 3
        return 2 * C10 * volume ** (-5 / 3) * (squared - mean) + BULK * (volume - 1)

    across = brentq(lambda a: stress(a**2, a), 0.5, 1.0, xtol=1e-15)
    return stress(STRETCH**2, across) * across**2


def solved(comm: "MPI.Comm") -> float:
    """The stretch that softact finds. Collective."""
    from softact.loads.load_step import LoadStep
    from softact.loads.support import Support
    from softact.materials import LAWS
    from softact.mesh.layout import Layout
    from softact.mesh.tetrahedra import distribute
    from softact.model import Model
    from softact.solve.settings import Settings
    from softact.solve.stepping import Stepper

    layout = Layout(("body",), ("x", "y", "z", "pulled"), {}, clamp="x", tip="pulled", length=1.0)
    law = LAWS["neo_hookean"].of(c10=C10, bulk_modulus=BULK)
    model = Model(distribute(comm, block, layout), {"body": law.material()})
    rollers = [Support(name, {axis: 0.0}) for axis, name in enumerate("xyz")]
    stepper = Stepper(model, Settings(initial_increment=0.5, max_increment=0.5), lambda *told: None)
    progress = stepper.run([LoadStep("pull", traction={"pulled": (pull(), 0.0, 0.0)})], rollers)
    if progress.stopped:
        raise ArithmeticError(progress.stopped)
    moved = stepper.state.x[model.displacement_dofs].max(initial=-np.inf)
    return 1.0 + max(comm.allgather(float(moved)))


def main() -> None:
    """Solve the block with the other processes of this MPI job, and print what came out."""
    import petsc4py
    from mpi4py import MPI

    petsc4py.init(["softact", "-skip_petscrc"])
    comm = MPI.COMM_WORLD
    try:
        stretch = solved(comm)
    except Exception as error:  # the other processes would wait for this one
        print(f"{type(error).__name__}: {error}", file=sys.stderr, flush=True)
        comm.Abort(1)
        raise
    if comm.rank == 0:
        print(json.dumps({"processes": comm.size, "stretch": stretch}))


if __name__ == "__main__":
    main()

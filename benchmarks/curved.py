"""Orders of convergence and time with curved walls in the mesh, and with straight ones beside them.

``python -m benchmarks.curved`` prints tables in Markdown: the thick sphere and the thick tube of
tests/analytic/test_curved_walls.py against their closed forms, and round bellows, which have none,
by how much their figures change from mesh to mesh.
"""

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from mpi4py import MPI

from softact.geometries.bellows import Bellows
from softact.geometry.base import make_mesh
from softact.loads.load_step import LoadStep
from softact.loads.support import Support
from softact.materials import LAWS
from softact.measures.snapshot import Snapshot
from softact.mesh.msh_file import read_msh
from softact.mesh.tetrahedra import distribute
from softact.model import Model
from tests.analytic import test_curved_walls as walls
from tests.analytic.solving import solve

Figures = tuple[float, float, float]
BELLOWS = {
    "convolutions": 1,
    "pitch": "12 mm",
    "inner_radius": "8 mm",
    "outer_radius": "14 mm",
    "wall": "2 mm",
    "part": "quarter",
    "through_wall": 2,
}
SIZES, PRESSURE = (8, 4, 2), 2e-3  # mm, MPa


def bellows(size: float, curved: bool, folder: Path) -> Figures:
    """Movement of the tip, mm, the cavity's volume, mm³, and the largest stress, MPa."""
    geometry = Bellows.model_validate({**BELLOWS, "mesh_size": f"{size} mm"})
    path, layout = folder / "bellows.msh", geometry.layout()
    make_mesh(geometry, path, curved=curved)
    mesh = distribute(MPI.COMM_SELF, lambda: read_msh(path, layout), layout)
    law = LAWS["neo_hookean"].of(c10=0.1, bulk_modulus=100.0)
    model = Model(mesh, {"body": law.material()}, wall_normal=geometry.wall_normal)
    held = [Support("clamp", {0: 0.0, 1: 0.0, 2: 0.0})]
    state = solve(model, LoadStep("inflate", pressure={"cavity": PRESSURE}), held, 1.0).state
    tip, shares = model.surfaces.shares("tip")
    moved = float(shares @ state.x[model.displacement_dofs[tip, 0]])
    stress = float(Snapshot(model, state).max_principal_stress.max())
    return moved, model.cavity_volume(state, "cavity"), stress


def main() -> int:
    """Print both tables."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        print("| body | edges | mesh | displacement | volume | largest stress | CPU s |")
        print("|---|---|---|---|---|---|---|")
        for title, wall, divisions in (
            ("sphere", walls.SPHERE, (4, 8, 16)),
            ("tube", walls.TUBE, (8, 16, 32)),
        ):

            def error(number: float, curved: bool, wall: walls.Wall = wall) -> Figures:
                return walls.error(wall, int(number), curved, folder)

            lines(title, divisions, error, orders_of_errors)
        print("\n| body | edges | mesh size mm | moves mm | volume mm³ | stress MPa | CPU s |")
        print("|---|---|---|---|---|---|---|")
        lines("bellows", SIZES, lambda size, curved: bellows(size, curved, folder), orders_of_steps)
    return 0


def lines(
    title: str,
    meshes: tuple[float, ...],
    found: Callable[[float, bool], Figures],
    orders: Callable[[list[Figures]], np.ndarray],
) -> None:
    """Lines of a table, straight and curved, with the orders of convergence in brackets."""
    for curved in (False, True):
        rows: list[Figures] = []
        for mesh in meshes:
            began = time.process_time()
            rows.append(found(mesh, curved))
            seconds = time.process_time() - began
            with np.errstate(all="ignore"):
                known = orders(rows)
            cells = [
                f"{value:.4g}" + (f" ({order:.1f})" if np.isfinite(order) else "")
                for value, order in zip(rows[-1], known, strict=True)
            ]
            edges = "curved" if curved else "straight"
            print(
                f"| {title} | {edges} | {mesh} | {' | '.join(cells)} | {seconds:.1f} |", flush=True
            )


def orders_of_errors(rows: list[Figures]) -> np.ndarray:
    """Orders since the mesh before, of errors."""
    return np.log2(np.divide(rows[-2], rows[-1])) if len(rows) > 1 else np.full(3, np.nan)


def orders_of_steps(rows: list[Figures]) -> np.ndarray:
    """Orders by how much figures change from mesh to mesh."""
    if len(rows) < 3:
        return np.full(3, np.nan)
    one, two, three = np.array(rows[-3:])
    return np.log2(np.abs((one - two) / (two - three)))


if __name__ == "__main__":
    sys.exit(main())

"""Orders of convergence and time with curved walls in the mesh, and with straight ones beside them.

``python -m benchmarks.curved`` prints tables in Markdown: the thick sphere and the thick tube of
tests/analytic/test_curved_walls.py against their closed forms, and half a convolution of round
bellows, which have none, against a finer mesh with curved edges.
"""

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.analytic import test_curved_walls as walls

Figures = tuple[float, float, float]
FINEST = 6  # elements through the wall of the bellows that others are compared with


def main() -> int:
    """Print the table."""
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

            lines(title, divisions, error)
        finest = np.array(walls.bellows(FINEST, True))

        def off(number: float, curved: bool) -> Figures:
            one, two, three = np.abs(np.array(walls.bellows(int(number), curved)) / finest - 1)
            return one, two, three

        lines("bellows", (1, 2, 4), off)
    return 0


def lines(
    title: str,
    meshes: tuple[float, ...],
    found: Callable[[float, bool], Figures],
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


def orders(rows: list[Figures]) -> np.ndarray:
    """Orders since the mesh before, of errors."""
    return np.log2(np.divide(rows[-2], rows[-1])) if len(rows) > 1 else np.full(3, np.nan)


if __name__ == "__main__":
    sys.exit(main())

"""One long flat pouch of woven fabric that is put on bent, and straightens under pressure.

Nguyen and Zhang 2020, Sci. Rep. 10:9638, Fig. 4a: the stiffening actuator.
"""

from collections.abc import Iterator
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from softact.geometry.base import Layout
from softact.geometry.cutting_pattern import Pattern, rectangle
from softact.geometry.flat_sheets import BetweenLines, Lines, SheetGeometry, sides
from softact.mesh.sheets import SheetMesh
from softact.units import Angle, Length


class WovenStiffening(SheetGeometry):
    """Two equal rectangles, sealed along their rim, folded over a joint across their middle.

    The half before the joint lies along x, the other is turned down about the joint by ``angle``.
    Up to ``free`` before the joint a strip along the middle of the lower sheet, ``strap`` wide, is
    fastened to a plate. Half is meshed, y ≥ 0. The moment of the reaction counts about the joint.
    """

    why_no_module: ClassVar[str] = ": it is one pouch"

    #: The crumpled sheet at the joint changes what it touches all the time: that does not converge.
    meets_itself: ClassVar[bool] = False

    type: Literal["woven_stiffening"] = "woven_stiffening"
    l_i: Length = Field(240.0, description="length of the pouch")
    w_a: Length = Field(65.0, description="width across")
    angle: Angle = Field(60.0, ge=0, le=150, description="by which it is bent as it is put on")
    free: Length = Field(30.0, description="from the joint to where the lower sheet is fastened")
    strap: Length = Field(65.0, description="width of the strip that is fastened")
    mesh_size: Length = Field(8.0, description="longest side of the triangles along the axes")
    between_lines: BetweenLines = None

    def faults(self) -> Iterator[tuple[str, str]]:
        if self.free >= self.l_i / 2:
            yield (
                "free",
                f"{self.free:g} mm leave nothing of the half before the joint, {self.l_i / 2:g} mm,"
                " to be fastened",
            )
        if self.strap > self.w_a:
            yield "strap", f"{self.strap:g} mm: write at most the width of {self.w_a:g} mm"

    def layout(self) -> Layout:
        return Layout(
            regions=(),
            surfaces=(),
            sheets=("upper", "lower", "strap"),
            curves=("tip", "middle", "seams"),
            cavities={"air": ("upper", "lower", "strap")},
            clamp="strap",
            symmetry={"middle": 1},
            origin=(self.l_i / 2, 0.0, 0.0),
            length=self.l_i,
        )

    def volumes(self) -> dict[str, float]:
        whole, strap = self.l_i * self.w_a / 2, (self.l_i / 2 - self.free) * self.strap / 2
        return {"upper": whole, "lower": whole - strap, "strap": strap, "air": 0.0}

    def _folded(self, flat: np.ndarray) -> np.ndarray:
        """Points (n, 3) of the flat sheet, those beyond the joint turned down."""
        beyond = np.maximum(flat[:, 0] - self.l_i / 2, 0.0)
        turn = np.radians(self.angle)
        x = np.minimum(flat[:, 0], self.l_i / 2) + np.cos(turn) * beyond
        return np.column_stack([x, flat[:, 1], -np.sin(turn) * beyond])

    def sheet_mesh(self) -> SheetMesh:
        joint, half = self.l_i / 2, self.w_a / 2
        x = self.divided([0.0, joint - self.free, joint, self.l_i])
        lines = Lines(x, self.divided(sorted({0.0, self.strap / 2, half})))
        # At a corner of the rim the diagonal has to end there: else it would weld the two sheets.
        diagonals = lines.alternating()
        diagonals[0, -1], diagonals[-1, -1] = True, False
        flat, above = lines.points(), lines.triangles(diagonals=diagonals)
        rim = (flat[:, 0] == 0) | (flat[:, 0] == self.l_i) | (flat[:, 1] == half)
        below = np.empty(len(flat), dtype=int)
        below[rim] = np.flatnonzero(rim)
        below[~rim] = len(flat) + np.arange(int((~rim).sum()))
        everything = np.vstack([flat, flat[~rim]])
        triangles = np.vstack([above, below[above][:, [0, 2, 1]]])
        lower = np.arange(len(triangles)) >= len(above)
        middle = everything[triangles].mean(axis=1)
        strapped = lower & (middle[:, 0] < joint - self.free) & (middle[:, 1] < self.strap / 2)
        parts = {
            "upper": np.flatnonzero(~lower),
            "lower": np.flatnonzero(lower & ~strapped),
            "strap": np.flatnonzero(strapped),
        }
        edges = sides(triangles)
        ends = everything[edges]
        on_rim = (edges < len(flat)).all(axis=1) & rim[np.minimum(edges, len(flat) - 1)].all(axis=1)
        curves = {
            "tip": edges[(ends[:, :, 0] == self.l_i).all(axis=1)],
            "middle": edges[(ends[:, :, 1] == 0).all(axis=1)],
            "seams": edges[on_rim],
        }
        fold = edges[(ends[:, :, 0] == joint).all(axis=1)]
        hinges = np.vstack([curves["seams"], fold])
        return SheetMesh(self._folded(everything), triangles, parts, curves, hinges=hinges)

    def pattern(self) -> Pattern:
        rim = tuple(rectangle((self.l_i / 2, 0.0), self.l_i, self.w_a))
        return Pattern(rim, rim)


if __name__ == "__main__":
    from softact.geometry.base import main

    main(WovenStiffening)

"""The flat pattern of a fabric actuator for the laser cutter: DXF or SVG."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

COLOURS = {"cut": ("red", 1), "seam": ("blue", 5)}  # SVG name, AutoCAD index
MARGIN = 5.0  # mm around an SVG

Line = tuple[tuple[float, float], tuple[float, float]]


def rectangle(centre: Sequence[float] | np.ndarray, width: float, height: float) -> list[Line]:
    """Its four sides."""
    x, y = map(float, centre)
    w, h = width / 2, height / 2
    corners = [(x + s * w, y + t * h) for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))]
    return list(pairwise(corners))


@dataclass(frozen=True)
class Pattern:
    """Lines in mm. cut: outlines of the pieces, each of which is cut ``pieces`` times. seam: where
    they are joined airtight."""

    cut: tuple[Line, ...]
    seam: tuple[Line, ...]
    pieces: int = 2

    def text(self, suffix: str) -> str:
        """The whole file in the format of ``suffix``, .dxf or .svg."""
        return self.dxf() if suffix == ".dxf" else self.svg()

    def _lines(self) -> list[tuple[str, Line]]:
        return [("cut", line) for line in self.cut] + [("seam", line) for line in self.seam]

    def dxf(self) -> str:
        """DXF R12, units mm, the layers CUT and SEAM."""
        rows = ["0", "SECTION", "2", "HEADER", "9", "$ACADVER", "1", "AC1009"]
        rows += ["9", "$INSUNITS", "70", "4", "0", "ENDSEC", "0", "SECTION", "2", "ENTITIES"]
        for kind, ((x0, y0), (x1, y1)) in self._lines():
            rows += ["0", "LINE", "8", kind.upper(), "62", str(COLOURS[kind][1])]
            for code, value in ((10, x0), (20, y0), (30, 0.0), (11, x1), (21, y1), (31, 0.0)):
                rows += [str(code), f"{value:.6f}"]
        return "\n".join([*rows, "0", "ENDSEC", "0", "EOF", ""])

    def svg(self) -> str:
        """SVG in mm: cuts red, seams blue."""
        points = [point for _, line in self._lines() for point in line]
        left, bottom = (min(p[i] for p in points) - MARGIN for i in range(2))
        width, height = (
            max(p[i] for p in points) + MARGIN - low for i, low in ((0, left), (1, bottom))
        )
        rows = [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}mm" height="{height:g}mm" '
            f'viewBox="0 0 {width:g} {height:g}">',
            f"<title>{self.pieces} of each piece; red: cut, blue: seam; lengths in mm</title>",
        ]
        for kind, ((x0, y0), (x1, y1)) in self._lines():
            rows.append(
                f'<line class="{kind}" x1="{x0 - left:.4f}" y1="{height + bottom - y0:.4f}" '
                f'x2="{x1 - left:.4f}" y2="{height + bottom - y1:.4f}" '
                f'stroke="{COLOURS[kind][0]}" stroke-width="0.1"/>'
            )
        return "\n".join([*rows, "</svg>", ""])

"""Where on an actuator a node lies, in words: its region and its surfaces."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from softact.mesh.layout import Layout
from softact.results.folder import Results

_NONE = 255
_WORDS = {"outer": "outer surface", "clamp": "clamped face", "tip": "tip face"}


class Places:
    """The surfaces and regions of a result's nodes, see ``words``."""

    def __init__(self, results: Results):
        self.results = results

    @cached_property
    def surfaces(self) -> dict[str, np.ndarray]:
        """Name of a surface -> (n,) whether a node lies on it. Symmetry planes are left out: they
        are cuts."""
        layout, count = self.results.layout, len(self.results.points)
        found = {}
        for name, faces in self.results.surfaces.items():
            if name in layout.symmetry or faces.shape[1] < 3:
                continue
            on = np.zeros(count, bool)
            on[faces] = True
            found[name] = on
        return found

    @cached_property
    def regions(self) -> np.ndarray:
        """(n,) number of the region of each node, the first of several; 255 for none."""
        number = np.full(len(self.results.points), _NONE, np.uint8)
        if len(self.results.cells):
            for each in reversed(range(len(self.results.region_names))):
                number[self.results.cells[self.results.region == each]] = each
        return number

    def words(self, node: int) -> str:
        """Such as "body, edge of the wall of cavity 'left' and the outer surface"."""
        layout, names = self.results.layout, self.results.region_names
        on = [f"the {called(layout, name)}" for name, there in self.surfaces.items() if there[node]]
        said = f"edge of {' and '.join(on)}" if len(on) > 1 else (on or ["inside the wall"])[0]
        number = self.regions[node]
        region = names[number] if len(names) > 1 and number != _NONE else ""
        said = said.removeprefix("the ")
        return f"{region.replace('_', ' ')}, {said}" if region else said


def called(layout: Layout, surface: str) -> str:
    """What people call a surface."""
    for cavity, walls in layout.cavities.items():
        if surface in walls:
            alone = len(layout.cavities) == 1
            return "wall of the cavity" if alone else f"wall of cavity “{cavity}”"
    if surface in (layout.clamp, layout.tip):
        return _WORDS["clamp" if surface == layout.clamp else "tip"]
    return _WORDS.get(surface, surface.replace("_", " "))

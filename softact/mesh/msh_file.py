"""A gmsh file of tetrahedra with named groups as plain arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from softact.errors import MeshError
from softact.mesh.curves import VTK_EDGES, Curves, of_quadratic
from softact.mesh.layout import Layout


@dataclass(frozen=True)
class Tetrahedra:
    """A whole mesh as plain arrays: points (n, 3) mm, cells (m, 4), region (m,) and for each
    surface name its triangles (k, 3). curves: edges that are not straight."""

    points: np.ndarray
    cells: np.ndarray
    region: np.ndarray
    surfaces: dict[str, np.ndarray]
    curves: Curves = field(default_factory=Curves)


def read_msh(path: Path, layout: Layout) -> Tetrahedra:
    """Read a gmsh file (format 4.1, tets of first or second order, named groups).

    Raises MeshError where a group that the layout promises is missing.
    """
    import meshio

    raw = meshio.read(path, file_format="gmsh")
    blocks = {"tetra": (3, 4), "triangle": (2, 3), "tetra10": (3, 4), "triangle6": (2, 3)}
    sets: dict[tuple[int, str], list[np.ndarray]] = {}
    for name, per_block in raw.cell_sets.items():
        if name.startswith("gmsh:"):
            continue
        for block, members in zip(raw.cells, per_block, strict=True):
            if members is not None and block.type in blocks and len(members):
                dimension, corners = blocks[block.type]
                sets.setdefault((dimension, name), []).append(
                    block.data[np.asarray(members, dtype=np.int64), :corners]
                )
    curved = [block.data for block in raw.cells if block.type == "tetra10"]
    curves = of_quadratic(raw.points, np.vstack(curved), VTK_EDGES) if curved else Curves()
    return from_groups(raw.points, sets, layout, str(path), curves)


def from_groups(
    points: np.ndarray,
    sets: Mapping[tuple[int, str], list[np.ndarray]],
    layout: Layout,
    origin: str,
    curves: Curves | None = None,
) -> Tetrahedra:
    """Tetrahedra from {(dimension, name): [cells, ...]}; unused points are dropped."""
    cells, region = [], []
    for number, name in enumerate(layout.regions):
        if (3, name) not in sets:
            raise MeshError(f"{origin}: the mesh has no volume group '{name}'")
        cells.append(np.vstack(sets[3, name]))
        region.append(np.full(len(cells[-1]), number, dtype=np.int32))
    used, numbered = np.unique(np.vstack(cells).astype(np.int64), return_inverse=True)
    renumber = np.full(len(points), -1, dtype=np.int64)
    renumber[used] = np.arange(len(used))
    surfaces = {}
    for name in layout.surfaces:
        if (2, name) not in sets:
            raise MeshError(f"{origin}: the mesh has no surface group '{name}'")
        surfaces[name] = renumber[np.unique(np.sort(np.vstack(sets[2, name]), axis=1), axis=0)]
    return Tetrahedra(
        np.ascontiguousarray(points[used], dtype=float),
        numbered.reshape(-1, 4),
        np.concatenate(region),
        surfaces,
        (curves or Curves()).renumbered(renumber),
    )

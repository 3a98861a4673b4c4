"""A state of a run as a grid of pyvista, for scripts and notebooks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softact.results.folder import Results

if TYPE_CHECKING:
    import pyvista

#: VTK's number of a cell with so many nodes: triangles and tetrahedra, linear and quadratic.
_TYPES = {3: 5, 6: 22, 4: 10, 10: 24}


def grid(results: Results, number: int) -> pyvista.UnstructuredGrid:
    """State ``number`` of a run: the mesh at rest with every field of fields.h5.

    ``cell_data["region"]`` numbers the names in ``field_data["region_names"]``. Sheets that cover a
    solid are not among the cells; their triangles stand in ``results.surfaces``. Raises
    DamagedResultError where the fields cannot be read.
    """
    import pyvista

    nodes = results.cells.shape[1]
    cells = np.insert(results.cells, 0, nodes, axis=1)
    types = np.full(len(cells), _TYPES[nodes], np.uint8)
    made = pyvista.UnstructuredGrid(cells.ravel(), types, np.asarray(results.points, float))
    made.cell_data["region"] = results.region
    made.field_data["region_names"] = np.array(results.region_names)
    for name in results.field_names(number):
        values = results.field(number, name)
        place = made.point_data if len(values) == len(results.points) else made.cell_data
        place[name] = values
    return made

"""Every geometry's mesh is refined by what is asked for: sizes, and elements through its walls."""

import numpy as np
import pytest

from softact.converge.study import finer
from softact.geometries import GEOMETRIES
from softact.geometry.base import STEPS
from softact.geometry.imported import Imported

# As small as they come, so that the finest mesh is quick.
SMALL = {
    "antagonistic": {"chambers": 1, "symmetry": True, "mesh_size": "8 mm"},
    "fiber_reinforced": {"length": "40 mm"},
    "omnidirectional": {"modules": 1, "symmetry": True},
    "pneunet": {"chambers": 2, "mesh_size": "3 mm"},
    "shell_reinforced": {"cuts": 2},
    "slow_pneunet": {"chambers": 2, "mesh_size": "3 mm"},
}
# Of the user's own files: tests/geometries/test_imported.py.
NAMES = [name for name, kind in GEOMETRIES.items() if not issubclass(kind, Imported)]


def made(name, factor=1.0, times=0):
    """A geometry whose mesh is refined by ``factor`` so many times, as by ``softact converge``."""
    kind, given = GEOMETRIES[name], SMALL.get(name, {})
    mesh = finer(kind.model_validate(given), factor, times) if times else {}
    return kind.model_validate(given | mesh)


@pytest.fixture
def elements(meshed):
    """Function that returns points (n, 3) and corners (m, 3 or 4) of a geometry's elements."""

    def get(geometry):
        if geometry.layout().regions:
            solid = meshed(geometry)
            return solid.points, solid.cells
        sheets = geometry.checked_mesh()
        return sheets.points, sheets.triangles

    return get


@pytest.mark.parametrize("name", NAMES)
def test_the_number_of_elements_grows_as_the_refinement_says(name, elements):
    """By the factor to the power of the dimension. Whole numbers of steps make some difference,
    and a wall with one element gets two at once, whatever the factor."""
    dimension = elements(made(name))[1].shape[1] - 1
    counts = {f: len(elements(made(name, f, 1 if f > 1 else 0))[1]) for f in (1.0, 1.3, 2.0)}
    ratio = {f: (count / counts[1.0]) ** (1 / dimension) for f, count in counts.items()}
    assert 1.2 < ratio[1.3] <= ratio[2.0] * 1.01
    assert 0.85 * 2.0 < ratio[2.0] < 1.1 * 2.0


@pytest.mark.parametrize("name", NAMES)
def test_each_refinement_is_finer_than_the_one_before(name, elements):
    """Twice by 1.3, where sizes alone made some meshes twice: by 1.1 at least, as meshes have to be
    that count."""
    dimension = elements(made(name))[1].shape[1] - 1
    counts = [len(elements(made(name, 1.3, n))[1]) for n in range(3)]
    ratios = (np.array(counts[1:]) / counts[:-1]) ** (1 / dimension)
    assert ratios.min() > 1.1


@pytest.mark.parametrize("name", NAMES)
def test_a_geometry_says_how_many_elements_lie_between_its_planes(name):
    assert sum(field in STEPS for field in GEOMETRIES[name].model_fields) == 1


@pytest.mark.parametrize("name", NAMES)
def test_no_edge_along_the_axes_is_longer_than_the_mesh_size(name, elements):
    """Of grids; sections and gmsh's own meshes have edges of about the size. The strip under
    standing pouches is divided by its length between two seams in the middle, 10 of 16 mm."""
    geometry = made(name, 2.0, 1)
    points, cells = elements(geometry)
    edges = np.vstack(
        [points[cells[:, i]] - points[cells[:, j]] for i in range(cells.shape[1]) for j in range(i)]
    )
    along = edges[(np.abs(edges) > 1e-9).sum(axis=1) == 1]
    longest = np.abs(along).max(initial=0.0)
    grid = name in ("block", "pneunet", "slow_pneunet") or not geometry.layout().regions
    longer = {"woven_bending": 1.6}.get(name, 1.003 if grid else 1.4)
    assert longest <= geometry.mesh_size * longer

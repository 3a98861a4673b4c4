"""Pieces of simplices: as many as there should be, of one volume, and fitting to each other."""

import itertools

import gmsh
import numpy as np
import pytest

from softact.geometry.subdivide import Pieces, cut_mesh, pieces, subdivided


def volumes(points, cells):
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    return np.abs(np.linalg.det(edges)) / 6


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("k", [1, 2, 3, 5])
def test_pieces_fill_a_simplex(dimension, k):
    weights, parts = pieces(dimension, k)
    assert len(parts) == k**dimension
    assert (weights >= 0).all() and (weights.sum(axis=1) == k).all()
    places = weights[:, 1:].astype(float)  # of the simplex with edges of k along the axes
    edges = places[parts[:, 1:]] - places[parts[:, :1]]
    assert np.abs(np.linalg.det(edges)) == pytest.approx(1)


@pytest.mark.parametrize("k", [2, 3])
def test_pieces_of_neighbours_fit(k):
    """Of tetrahedra in a cube of random points, numbered anyhow: no face has more than two cells,
    those with one are the pieces of the faces with one, and the volume is the same."""
    from scipy.spatial import Delaunay

    draw = np.random.default_rng(1)
    points = draw.uniform(size=(40, 3))
    cells = draw.permuted(Delaunay(points).simplices, axis=1)
    sides = np.sort(np.vstack([cells[:, c] for c in itertools.combinations(range(4), 3)]), axis=1)
    skin, count = np.unique(sides, axis=0, return_counts=True)
    new, old, (small, cut_skin) = subdivided(points, [cells, skin[count == 1]], k)
    assert len(small) == k**3 * len(cells)
    assert np.array_equal(np.sort(new[old], axis=0), np.sort(points, axis=0))
    assert volumes(new, small).sum() == pytest.approx(volumes(points, cells).sum(), rel=1e-12)
    faces = np.vstack([small[:, c] for c in itertools.combinations(range(4), 3)])
    faces, count = np.unique(np.sort(faces, axis=1), axis=0, return_counts=True)
    assert count.max() == 2
    assert np.array_equal(faces[count == 1], np.unique(np.sort(cut_skin, axis=1), axis=0))


@pytest.fixture
def model():
    gmsh.initialize(readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    yield gmsh
    gmsh.finalize()


def test_points_of_a_cut_disc_lie_on_its_circle(model):
    """The polygon of 16 edges becomes one of 48, with an area of ½ n sin(2π/n)."""
    disc = model.model.occ.addDisk(0, 0, 0, 1, 1)
    model.model.occ.synchronize()
    for _, curve in model.model.getEntities(1):
        model.model.mesh.setTransfiniteCurve(curve, 17)
    model.model.mesh.generate(2)
    cut = Pieces(model, 2, 3)
    triangles = cut.points[cut.of[2, disc]][:, :, :2]
    edges = triangles[:, 1:] - triangles[:, :1]
    areas = np.abs(np.linalg.det(edges)) / 2
    assert areas.sum() == pytest.approx(24 * np.sin(2 * np.pi / 48), rel=1e-6)
    assert areas.min() > 0.2 * areas.mean()


def test_a_cut_solid_keeps_its_groups_and_its_thin_round_wall(model):
    """An eighth of a hollow ball, 0.5 thick, with facets that are as long as that: three layers,
    all the right way round, on both spheres."""
    occ, pi = model.model.occ, np.pi
    octant = (0.0, pi / 2, pi / 2)
    occ.cut([(3, occ.addSphere(0, 0, 0, 5.5, -1, *octant))],
            [(3, occ.addSphere(0, 0, 0, 5, -1, *octant))])  # fmt: skip
    occ.synchronize()
    for dimension, name in ((3, "body"), (2, "skin")):
        tags = [tag for _, tag in model.model.getEntities(dimension)]
        group = model.model.addPhysicalGroup(dimension, tags)
        model.model.setPhysicalName(dimension, group, name)
    model.option.setNumber("Mesh.MeshSizeMax", 1.0)
    model.model.mesh.generate(3)
    before = len(model.model.mesh.getElementsByType(4)[0])
    cut_mesh(model, 3)
    tags, coordinates, _ = model.model.mesh.getNodes()
    place = np.zeros(int(tags.max()) + 1, dtype=int)
    place[tags.astype(int)] = np.arange(len(tags))
    points = coordinates.reshape(-1, 3)
    cells = place[model.model.mesh.getElementsByType(4)[1].astype(int)].reshape(-1, 4)
    assert len(cells) == 27 * before
    assert volumes(points, cells).min() > 0
    whole = pi / 6 * (5.5**3 - 5**3)
    assert volumes(points, cells).sum() == pytest.approx(whole, rel=3e-3)
    names = {model.model.getPhysicalName(*group) for group in model.model.getPhysicalGroups()}
    assert names == {"body", "skin"}
    radius = np.linalg.norm(points, axis=1)
    on = {r: int((abs(radius - r) < 1e-6).sum()) for r in (5.0, 5.5)}
    between = int(((radius > 5 + 1e-3) & (radius < 5.5 - 1e-3)).sum())
    assert min(on.values()) > 50 and between > sum(on.values()) * 0.8

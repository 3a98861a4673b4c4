"""The search for what may touch leaves out nothing that does."""

import numpy as np
import pytest
from mpi4py import MPI
from scipy.spatial import cKDTree

from softact.contact.closest import derivatives
from softact.contact.pairs import FACING, Pairs, facet_normals, neighbours
from softact.contact.sight import spheres

# Places on a facet, a tenth of it beyond its edges included: so far points keep what they face.
STEPS = np.linspace(-0.1, 1.2, 27)
PLACES = np.array([(s, t) for s in STEPS for t in STEPS if s + t <= 1.1 + 1e-9])


def soup(count: int, seed: int, nodes: int = 6) -> np.ndarray:
    """Bent facets (count, nodes, 3) in a box, of sizes from 0.5 to 2 mm."""
    random = np.random.default_rng(seed)
    size = random.uniform(0.5, 2.0, (count, 1, 1))
    corners = random.uniform(0, 8, (count, 1, 3)) + size * random.normal(0, 0.5, (count, 3, 3))
    if nodes == 3:
        return corners
    middles = (corners + np.roll(corners, -1, axis=1)) / 2
    return np.hstack([corners, middles + size * random.normal(0, 0.05, (count, 3, 3))])


def pairs_of(nodes: np.ndarray, side: np.ndarray | None = None) -> Pairs:
    """The pairs of facets that have no nodes in common."""
    numbers = np.arange(nodes[..., 0].size).reshape(nodes.shape[:2])
    nobody = lambda i, j: np.zeros(len(i), bool)  # noqa: E731
    side = np.full(len(nodes), -1) if side is None else side
    reach, depth = np.full(len(nodes), 1.0), np.full(len(nodes), 0.25)
    return Pairs(MPI.COMM_SELF, numbers, side, reach, depth, nobody, nobody)


def closest(nodes: np.ndarray, i: np.ndarray, j: np.ndarray) -> np.ndarray:
    """Distances (m,) of facets by samples, which are no less than the true ones."""
    samples = np.einsum("sn,knc->ksc", derivatives(PLACES, nodes.shape[1])[0], nodes)
    trees = [cKDTree(cloud) for cloud in samples]
    return np.array([trees[b].query(samples[a])[0].min() for a, b in zip(i, j, strict=True)])


@pytest.mark.parametrize("sides", [False, True])
def test_candidates_are_those_of_a_search_of_all_pairs(sides):
    nodes = soup(300, 1)
    side = np.arange(300) % 2 if sides else np.full(300, -1)
    pairs = pairs_of(nodes, side)
    pairs.search(nodes)
    centre, radius = spheres(nodes)
    apart = np.linalg.norm(centre[:, None] - centre[None], axis=2)
    normal = facet_normals(nodes)
    wanted = (apart < radius[:, None] + radius + 1.0) & (normal @ normal.T < FACING)
    wanted &= (side[:, None] != side) | (side < 0)
    np.fill_diagonal(wanted, False)
    i, j = np.nonzero(wanted)
    assert len(i) > 3000
    assert np.array_equal(pairs.looking.facet, i)
    assert np.array_equal(pairs.looking.candidate, j)


@pytest.mark.parametrize("nodes", [3, 6])
def test_what_comes_near_is_marked(nodes):
    """However facets move, turn and bend: a pair that is not marked is farther off than asked."""
    before = soup(60, 2, nodes)
    pairs = pairs_of(before)
    pairs.search(before)
    random = np.random.default_rng(3)
    turn = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
    within = np.full(len(before), 0.1)
    for now in (
        before,
        before + random.normal(0, 0.3, (len(before), 1, 3)),
        before + random.normal(0, 0.1, before.shape),
        before @ turn.T + random.normal(0, 0.1, before.shape),
    ):
        mark = pairs.near(now, within)
        i, j = (a[~mark] for a in (pairs.looking.facet, pairs.looking.candidate))
        assert (closest(now, i, j) >= 0.1).all()
    assert not pairs.near(before, within).all()


def test_what_overlaps_is_marked():
    """A facet that lies behind another, by less than contact looks, may touch it; one that lies in
    front of it, or deeper, does not."""
    below = np.array([[[0, 0, 0], [2, 0, 0], [0, 2, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]]])
    above = below[:, [0, 2, 1, 5, 4, 3]]
    for height, wanted in ((0.02, False), (-0.001, True), (-0.2, True), (-0.4, False)):
        nodes = np.concatenate([below, above + np.array([0.1, 0.1, height])])
        pairs = pairs_of(nodes)
        pairs.search(nodes)
        assert len(pairs.looking.candidate) == 2
        assert pairs.near(nodes, np.zeros(2)).all() == wanted


def test_facets_that_move_as_one_stay_as_far_apart_as_they_were():
    before = soup(60, 4)
    pairs = pairs_of(before)
    pairs.search(before)
    within = np.full(len(before), 0.1)
    gone = before + np.array([300.0, -20.0, 7.0])
    assert np.array_equal(pairs.near(gone, within), pairs.near(before, within))


def test_neighbours_are_the_pairs_with_a_common_node():
    random = np.random.default_rng(5)
    numbers = np.array([random.choice(90, 6, replace=False) for _ in range(40)])
    common = (numbers[:, None, :, None] == numbers[None, :, None, :]).any(axis=(2, 3))
    found = neighbours(numbers)
    known = np.zeros_like(common)
    known[found.facet, found.candidate] = True
    assert np.array_equal(known, common)


def test_places_that_are_no_numbers_are_no_endless_search():
    nodes = soup(20, 6)
    pairs = pairs_of(nodes)
    nodes[3] = np.inf
    with pytest.raises(MemoryError):
        pairs.search(nodes)

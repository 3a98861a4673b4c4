"""Edges at which a surface ends or turns back, and points that slide off them."""

import numpy as np
import pytest
from mpi4py import MPI

from softact.contact.crossing import Crossing
from softact.contact.edges import open_edges

#: A quadratic facet that looks up, and a point of a facet.
FLAT = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0, 0], [0.5, 0.5, 0], [0, 0.5, 0]], float)
POINT = np.full((1, 3), 1 / 3) @ np.eye(3, 6)


def test_edges_of_a_box_are_open_and_those_within_its_faces_are_not():
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    nodes = np.array([q[:3] for q in quads] + [(q[0], q[2], q[3]) for q in quads])
    found = open_edges(nodes, corners[nodes])
    length = np.linalg.norm(corners[nodes[:, [1, 2, 0]]] - corners[nodes], axis=2)
    np.testing.assert_array_equal(found, length < 1.2)
    inward = nodes[:, ::-1]  # of a room of this shape all folds are concave
    assert not open_edges(inward, corners[inward]).any()
    assert open_edges(nodes[:1], corners[nodes[:1]]).all()
    assert open_edges(nodes[:0], corners[nodes[:0]]).shape == (0, 3)


@pytest.mark.parametrize("corners", [3, 6])
@pytest.mark.parametrize(
    ("edge", "to"),
    [(None, (0.3, 0.2)), (0, (0.3, -0.1)), (1, (0.7, 0.5)), (2, (-0.1, 0.3))],
)
def test_what_slides_off_an_edge_does_not_go_through(corners, edge, to):
    """A point over the middle of a facet ends below it, and beside it at one of its edges: it has
    gone through unless this edge is open."""
    facet = FLAT[:corners]
    before = np.stack([facet, facet + np.array([0.0, 0.0, 0.1])])
    after = before.copy()
    after[1] += np.array([*to, -0.3]) - [1 / 3, 1 / 3, 0.0]
    start, candidate = np.array([0, 0, 1]), np.array([0])
    crossed, point = Crossing(MPI.COMM_SELF), POINT[:, :corners]
    known = before, after, point, start, candidate, np.ones(2)
    assert crossed(*known)
    for k in range(3):
        is_open = np.zeros((2, 3), dtype=bool)
        is_open[0, k] = True
        assert crossed(*known, is_open=is_open) == (k != edge)

"""The compiled search for what points face, against a search among many points of all facets."""

import numpy as np
import pytest
from mpi4py import MPI

from softact.contact.closest import Closest, derivatives

COUNT = 6  # quads along each side of a sheet


def wavy(height, amplitude, up):
    """Quadratic facets (k, 6, 3) of a wavy sheet, and their nodes' numbers; up: normals upward."""
    along = np.linspace(0.0, 6.0, 2 * COUNT + 1)
    grid = np.arange(len(along) ** 2).reshape(len(along), -1)
    facets = []
    for i in range(0, 2 * COUNT, 2):
        for j in range(0, 2 * COUNT, 2):
            g = grid[i : i + 3, j : j + 3]
            facets.append([g[0, 0], g[2, 0], g[0, 2], g[1, 0], g[1, 1], g[0, 1]])
            facets.append([g[2, 2], g[0, 2], g[2, 0], g[1, 2], g[1, 1], g[2, 1]])
    numbers = np.array(facets)
    if not up:
        numbers = numbers[:, [0, 2, 1, 5, 4, 3]]
    x, y = (c.ravel() for c in np.meshgrid(along, along, indexing="ij"))
    wave = height + amplitude * np.sin(1.3 * x + 0.4) * np.cos(1.1 * y)
    return np.column_stack([x, y, wave])[numbers], numbers


@pytest.mark.parametrize("amplitude", [0.0, 0.1, 0.35])
def test_points_face_the_nearest_place_of_all(amplitude):
    low, _ = wavy(0.0, amplitude, up=True)
    high, _ = wavy(0.6, -amplitude / 2, up=False)
    rng = np.random.default_rng(3)
    shares = rng.dirichlet(np.ones(3), 12)
    at = derivatives(shares[:, 1:], 6)[0]
    nodes = np.concatenate([low, high])
    places = np.einsum("qn,knc->kqc", at, high)
    count = len(low)
    start = np.arange(len(high) + 1) * count
    candidate = np.tile(np.arange(count, dtype=np.int32), len(high))
    known = start.astype(np.int64), candidate, np.full(len(high), 1.0), np.full(len(high), 0.3)
    partner, place, gap = Closest(MPI.COMM_SELF)(places, high, nodes, *known)
    fine = np.array([(i, j) for i in range(41) for j in range(41 - i)]) / 40
    samples = np.einsum("sn,knc->ksc", derivatives(fine, 6)[0], low).reshape(-1, 3)
    inner = (np.abs(places[..., :2] - 3.0) < 2.2).all(axis=-1)
    assert inner.sum() > 300
    squares = ((places[inner][:, None] - samples[None]) ** 2).sum(axis=-1)
    distance, nearest = np.sqrt(squares.min(axis=1)), squares.argmin(axis=1) % len(fine)
    reached = distance < 0.95
    lost = reached & (partner[inner] < 0)  # in the wedge between two facets that are not smooth
    assert (
        np.minimum(fine[nearest].min(axis=1), 1 - fine[nearest].sum(axis=1))[lost].max(initial=0)
        <= 0.03
    )
    near = reached & ~lost
    assert near.sum() > 250
    assert np.abs(gap[inner][near]) == pytest.approx(distance[near], abs=0.01)
    foot = np.einsum("mn,mnc->mc", derivatives(place[inner], 6)[0], nodes[partner[inner]])
    apart = np.linalg.norm(places[inner] - foot, axis=1)
    assert apart[near] == pytest.approx(np.abs(gap[inner][near]), abs=1e-10)

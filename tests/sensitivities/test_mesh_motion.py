"""How points and middles of curved edges move with a radius."""

import numpy as np
import pytest

from softact.geometries import GEOMETRIES
from softact.geometry.base import move_mesh
from softact.geometry.motion import CARRIED, REPEATED, Moved


@pytest.mark.parametrize(
    ("name", "means", "given", "inner"),
    [
        ("thick_sphere", REPEATED, {"outer_radius": "14 mm"}, 10.0),
        ("tube", CARRIED, {"outer_radius": "9 mm"}, 5.0),
    ],
)
def test_points_and_middles_stay_on_the_round_wall(name, means, given, inner, tmp_path):
    """Those of the inner wall go outward as its radius grows, those of the outer wall stay."""
    kind, width = GEOMETRIES[name], 1e-4
    low, high = (
        kind.model_validate({**given, "mesh_size": "4 mm", "inner_radius": f"{r} mm"})
        for r in (inner, inner + width)
    )
    move_mesh(low, [(low, high, width)], tmp_path / "motion.npz", True)
    moved = Moved.stored(tmp_path / "motion.npz")
    assert moved.means == means and len(moved.edges) > 50
    (velocity,) = moved.velocities
    round_part = slice(None) if name == "thick_sphere" else slice(1, None)
    radius = np.linalg.norm(moved.points[:, round_part], axis=1)
    for wall, speed in ((inner, 1.0), (float(given["outer_radius"].split()[0]), 0.0)):
        on_wall = np.abs(radius - wall) < 1e-6
        edges = moved.edges[on_wall[moved.edges].all(axis=1)]
        assert len(edges) > 10
        ways = [moved.of_points(velocity)[on_wall], moved.of_middles(velocity, edges)]
        places = [moved.points[on_wall], moved.points[edges].mean(axis=1)]
        for way, place in zip(ways, places, strict=True):
            outward = place[:, round_part]
            outward = outward / np.linalg.norm(outward, axis=1)[:, None]
            along = np.einsum("nc,nc->n", way[:, round_part], outward)
            assert along == pytest.approx(speed, abs=1e-6)
            # They may slide along the wall a little, as the mesh between them does.
            assert np.abs(way[:, round_part] - speed * outward).max() < 0.1

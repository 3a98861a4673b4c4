"""The tube is meshed by gmsh itself: sizes are kept, the volume closes in on the cylinder's."""

import numpy as np
import pytest
from pydantic import ValidationError

from softact.geometries.tube import Tube


def tube(size: str) -> Tube:
    return Tube.model_validate({"mesh_size": size})


def test_points_of_the_walls_lie_on_the_cylinders(meshed):
    solid = meshed(tube("1.5 mm"))
    for name, radius in (("bore", 5.0), ("outer", 7.0)):
        corners = solid.points[np.unique(solid.surfaces[name])]
        assert np.linalg.norm(corners[:, 1:], axis=1) == pytest.approx(radius, rel=1e-9)


def test_mesh_size_is_kept(meshed):
    for size in (3.0, 1.5, 0.75):
        solid = meshed(tube(f"{size} mm"))
        x = solid.points[solid.cells]
        edges = [np.linalg.norm(x[:, i] - x[:, j], axis=1) for i in range(4) for j in range(i)]
        assert 0.5 * size < np.mean(edges) < 1.3 * size


def test_bore_converges(meshed):
    """The flux of (0, y, 0) into the bore is its volume. A polygon of n chords in a quarter circle
    holds sin(2 a)/(2 a) of it, a = pi/(4 n): the error falls by about four where the size is
    halved."""
    exact = np.pi / 4 * 5.0**2 * 10.0
    errors = []
    for size in ("2 mm", "0.5 mm"):
        middles, areas = meshed(tube(size)).outward_areas("bore")
        errors.append(1 + (middles[:, 1] * areas[:, 1]).sum() / exact)
    assert 0 < errors[1] < errors[0] / 8


def test_a_wall_that_vanishes_is_refused():
    with pytest.raises(ValidationError, match="the wall would vanish"):
        Tube.model_validate({"outer_radius": "5 mm"})

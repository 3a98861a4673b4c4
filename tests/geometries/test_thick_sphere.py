"""The sphere's facets close in on the sphere at second order."""

import numpy as np
import pytest
from pydantic import ValidationError

from softact.geometries.thick_sphere import ThickSphere


def test_volume_converges_at_second_order(meshed):
    errors = []
    for size in ("4.32 mm", "2.16 mm", "1.08 mm"):
        sphere = ThickSphere.model_validate({"mesh_size": size})
        errors.append(1 - meshed(sphere).volumes.sum() / sphere.volumes()["body"])
    assert 0 < errors[-1] < 0.006
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders == pytest.approx(2, abs=0.1)


def test_points_of_the_walls_lie_on_the_spheres(meshed):
    solid = meshed(ThickSphere())
    for name, radius in (("cavity", 10.0), ("outer", 11.0)):
        corners = solid.points[np.unique(solid.surfaces[name])]
        assert np.linalg.norm(corners, axis=1) == pytest.approx(radius, rel=1e-12)


def test_a_wall_that_vanishes_is_refused():
    with pytest.raises(ValidationError, match="the wall would vanish"):
        ThickSphere.model_validate({"inner_radius": "11 mm"})

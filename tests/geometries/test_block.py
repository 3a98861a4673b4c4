"""The block's faces are where their names say."""

import numpy as np
import pytest

from softact.geometries.block import Block


def test_each_face_lies_in_its_plane(meshed):
    extent = (7.0, 3.0, 11.0)
    names = ("length", "width", "height")
    solid = meshed(Block.model_validate(dict(zip(names, map("{} mm".format, extent), strict=True))))
    for axis in range(3):
        for end, at in (("min", 0.0), ("max", extent[axis])):
            corners = solid.points[solid.surfaces[f"{'xyz'[axis]}_{end}"]]
            assert corners[..., axis] == pytest.approx(at, abs=1e-12)
            across = [a for a in range(3) if a != axis]
            spread = np.ptp(corners.reshape(-1, 3)[:, across], axis=0)
            assert spread == pytest.approx(np.take(extent, across))


def test_cells_are_no_longer_than_the_mesh_size(meshed):
    solid = meshed(Block.model_validate({"length": "10.1 mm", "mesh_size": "5 mm"}))
    levels = [np.unique(solid.points[:, axis]) for axis in range(3)]
    assert [len(level) for level in levels] == [4, 3, 3]

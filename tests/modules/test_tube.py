"""A slice of a tube beside the middle of the whole, which is extruded as the slice is."""

from pathlib import Path
from types import ModuleType

import pytest

from softact.geometries.tube import Tube
from tests.modules.chain import RUBBER, WOUND, Case, assert_like_an_inner_one

ONE_WAY = {**WOUND, "k1": "0.5 MPa", "angle": "50 deg", "families": 1}
# part -> its law, kPa
PARTS = {"quarter": (RUBBER, 30.0), "whole": (ONE_WAY, 13.0)}


class Extruded(Tube):
    """A whole tube with the mesh of its slices."""

    def mesh(self, gmsh: ModuleType) -> None:
        """See ``Geometry.mesh``."""
        self.extruded().mesh(gmsh, self.mesh_size, self.least_steps)


@pytest.mark.parametrize("part", PARTS)
def test_a_slice_is_the_middle_of_the_whole(part, tmp_path, monkeypatch):
    """A whole one twists, since its fibres all wind the same way."""
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2]))  # gmsh's process imports it
    law, pressure = PARTS[part]
    geometry = {
        "type": "tube",
        "part": part,
        "inner_radius": "3 mm",
        "outer_radius": "5 mm",
        "length": "42 mm",
        "mesh_size": "3 mm",
    }
    how = {
        "cavity": "bore",
        "load": "surface_pressure",
        "whole": Extruded,
        "bends": part == "whole",
    }
    case = Case(geometry, pressure, 21.0, **how, materials={"body": law})
    assert_like_an_inner_one(case, tmp_path)

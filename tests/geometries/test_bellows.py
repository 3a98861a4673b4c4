"""Bellows: what a slice of them does, their thrust, and what is refused."""

import csv

import numpy as np
import pytest
from pydantic import ValidationError

from softact.geometries.bellows import Bellows
from softact.run.start import run
from softact.spec import loads

BELLOWS = """
geometry: {{type: bellows, convolutions: {convolutions}, part: {part}, mesh_size: 6 mm}}
materials: {{body: {{law: neo_hookean, c10: 0.1 MPa, density: 1000 kg/m^3}}}}
solver: {{initial_increment: 1, max_increment: 1}}
supports: [{{surface: clamp, fix: [x, y, z]}}{more}]
steps: [{{pressure: {pressure}}}]
"""
HELD = ", {surface: tip, fix: [x, y, z]}"


@pytest.fixture
def last(tmp_path):
    """Function from the text of a spec to the last row of its curve."""

    def solve(text):
        outcome = run(loads(text), tmp_path / "result", report=False)
        assert outcome.status == "complete", outcome.message
        with (tmp_path / "result" / "curve.csv").open() as file:
            return {
                k: float(v) for k, v in list(csv.DictReader(file))[-1].items() if k != "step" and v
            }

    return solve


def test_a_quarter_does_what_a_half_does(last):
    """Volumes of a part are told of the whole, too."""
    shown = ("elongation_mm", "cavity_volume_mm3", "max_principal_stretch")
    quarter, half = (
        last(BELLOWS.format(convolutions=1, part=part, more="", pressure="0.3 kPa"))
        for part in ("quarter", "half")
    )
    assert [quarter[name] for name in shown] == pytest.approx(
        [half[name] for name in shown], rel=0.01
    )
    assert quarter["elongation_mm"] > 0.3


def test_pressure_makes_them_longer_and_a_vacuum_shorter(last):
    """By nearly the same, where both are small."""
    text = BELLOWS.replace("steps", "contact: none\nsteps")
    moved = [
        last(text.format(convolutions=2, part="quarter", more="", pressure=p))["elongation_mm"]
        for p in ("0.05 kPa", "-0.05 kPa")
    ]
    assert moved[0] > 0.1
    assert moved[1] == pytest.approx(-moved[0], rel=0.1)


def test_bellows_that_are_held_push_with_their_effective_area(last):
    """A thrust p A: A is the air that a motion of the tip takes in (Betti), and, where the wall is
    thin, π D²/4 with the mean diameter of crests and roots (Expansion Joint Manufacturers
    Association)."""
    thin = "outer_radius: 14.7 mm, inner_radius: 8.3 mm, wall: 0.4 mm, mesh_size"
    text = BELLOWS.replace("mesh_size", thin)
    row = last(text.format(convolutions=2, part="quarter", more=HELD, pressure="0.01 kPa"))
    area = row["tip_force_x_N"] / 1e-5
    assert area == pytest.approx(np.pi * 11.5**2, rel=0.02)
    moved = HELD.replace("fix: [x, y, z]", "fix: [y, z], move: {x: 0.01 mm}")
    far, near = (
        last(text.format(convolutions=2, part="quarter", more=more, pressure="0 kPa"))
        for more in (moved, moved.replace("0.01", "-0.01"))
    )
    air = far["cavity_volume_mm3"] - near["cavity_volume_mm3"]
    assert air / 0.02 == pytest.approx(area, rel=1e-3)


def test_normals_point_out_of_the_wall(meshed):
    """Those of the facets, within the angle that an arc turns between two stations."""
    solid = meshed(Bellows.model_validate({"convolutions": 2, "mesh_size": "2 mm"}))
    middles, areas = solid.outward_areas("outer")
    normal = solid.geometry.wall_normal("body", middles)
    assert np.linalg.norm(normal, axis=1) == pytest.approx(1.0)
    outward = areas / np.linalg.norm(areas, axis=1)[:, None]
    assert np.einsum("ij,ij->i", normal, outward).min() > np.cos(np.pi / 12)


@pytest.mark.parametrize(
    ("given", "field", "reason"),
    [
        ({"outer_radius": "9 mm"}, "outer_radius", "convolutions would vanish"),
        ({"fold_radius": "0.5 mm"}, "fold_radius", "gaps in the folds would vanish"),
        ({"pitch": "2 mm"}, "pitch", "gaps in the folds would vanish"),
        ({"fold_radius": "2.1 mm"}, "fold_radius", "lean over into each other"),
    ],
)
def test_what_cannot_be_built_is_refused(given, field, reason):
    with pytest.raises(ValidationError) as caught:
        Bellows.model_validate(given)
    assert [fault["loc"][0] for fault in caught.value.errors()] == [field]
    assert reason in caught.value.errors()[0]["msg"]

"""Modules of actuators that are made of boxes."""

from dataclasses import replace

import numpy as np
import pytest

from softact.measures.cross_section import CrossSection
from tests.modules.chain import RUBBER, Case, assert_like_an_inner_one
from tests.modules.solving import solved

FINGER = Case(
    {
        "type": "pneunet",
        "chambers": 6,
        "chamber_height": "8 mm",
        "chamber_width": "8 mm",
        "base": "3 mm",
        "mesh_size": "4 mm",
        "cavity_mesh_size": "2 mm",
    },
    pressure=20.0,
    begins=4 + 2 + 2 * 9,  # the plug, a third of a chamber, two pitches
)
# Its walls meet from 7 kPa on.
CLOSING = {**FINGER.geometry, "chambers": 8, "gap": "0.2 mm", "inner_wall": "0.5 mm"}
LAYER = {"surface": "strain_limiting_layer", "thickness": "0.1 mm", "material": "paper"}
CASES = {
    "pneunet": FINGER,
    "pneunet with paper": replace(FINGER, more={"layers": [LAYER]}),
    "pneunet whose gaps close": replace(
        FINGER,
        geometry=CLOSING,
        begins=4 + 2 + 3 * 7.2,
        more={"contact": "auto"},
    ),
    "slow_pneunet": Case(
        {
            "type": "slow_pneunet",
            "chambers": 8,
            "chamber_height": "6 mm",
            "chamber_width": "6 mm",
            "outer_wall": "3 mm",
            "roof": "4 mm",
            "mesh_size": "3 mm",
        },
        pressure=30.0,
        begins=7 + 2 + 7 / 3 + 3 * 9,
        materials={"body": RUBBER, "film": RUBBER},
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_a_module_is_an_inner_one_of_the_whole(name, tmp_path):
    assert_like_an_inner_one(CASES[name], tmp_path)


def held_section(symmetry, folder):
    """The cross-section of a small finger's module at 5 kPa, turned by 5° and 1.05 pitches long."""
    geometry = {
        "type": "pneunet",
        "module_alone": True,
        "chamber_height": "6 mm",
        "chamber_width": "6 mm",
        "base": "3 mm",
        "mesh_size": "4 mm",
        "symmetry": symmetry,
    }
    given = {"turn": {"y": "5 deg"}, "shift": {"x": "9.45 mm"}}
    model, (state,) = solved(
        {
            "geometry": geometry,
            "materials": {"body": RUBBER},
            "module": {"left": "left", "right": "right", **given},
            "steps": [{"name": "press", "pressure": "5 kPa"}],
        },
        folder,
    )
    return CrossSection(model, state), model.cavity_volume(state, "cavity")


def test_a_half_says_what_the_whole_does(tmp_path):
    """Moment, force, stiffness: those of a half count for both; the whole moves in its plane."""
    half, air = held_section(True, tmp_path / "half")
    whole, all_air = held_section(False, tmp_path / "whole")
    assert half.free.tolist() == [False, True, False, True, False, True]
    assert whole.free.all()
    np.testing.assert_allclose(whole.strain, half.strain, atol=1e-8)
    assert abs(half.load[1]) > 0.1
    assert abs(half.load[3]) > 0.1
    np.testing.assert_allclose(whole.load, half.load, atol=1e-6)
    assert all_air == pytest.approx(2 * air, rel=1e-9)
    in_plane = np.ix_([1, 3, 5], [1, 3, 5])
    stiffness = half.stiffness()
    np.testing.assert_allclose(whole.stiffness()[in_plane], stiffness, rtol=1e-6, atol=1e-6)

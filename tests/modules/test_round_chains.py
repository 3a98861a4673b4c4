"""Modules of round actuators: a bellows with one cavity driven, a slit shell."""

from dataclasses import replace

import pytest

from tests.modules.chain import PAPER, Case, assert_like_an_inner_one

SHELL = Case(
    {
        "type": "shell_reinforced",
        "cuts": 9,
        "length": "93 mm",
        "radius": "7 mm",
        "chamber_radius": "5 mm",
        "mesh_size": "5 mm",
    },
    pressure=20.0,
    begins=5 + 6.5 / 2 + 4 * 8.5,
    more={"layers": [{"surface": "shell", **PAPER}]},
)

CASES = {
    "omnidirectional": Case(
        {"type": "omnidirectional", "modules": 6, "symmetry": True, "mesh_size": "4.5 mm"},
        pressure=10.0,
        begins=25.0,
        cavity="cavity_1",
    ),
    # Its second cavity bends it about an axis that is none of the coordinates'.
    "omnidirectional, whole": Case(
        {"type": "omnidirectional", "modules": 4, "pitch": "40 mm", "mesh_size": "18 mm"},
        pressure=6.0,
        begins=1.5 * 40,
        cavity="cavity_2",
    ),
    "shell_reinforced": SHELL,
    "shell_reinforced, linear": replace(
        SHELL,
        geometry={**SHELL.geometry, "kind": "linear", "mesh_size": "6 mm"},
        pressure=50.0,
        bends=False,
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_a_module_is_an_inner_one_of_the_whole(name, tmp_path):
    assert_like_an_inner_one(CASES[name], tmp_path)

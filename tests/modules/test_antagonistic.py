"""A module of each of two pairs; the upper one has the bores to the lower in its central wall."""

from dataclasses import replace

import pytest

from tests.modules.chain import Case, assert_like_an_inner_one

PITCH = 60.0  # so long that the plates are far from the two inner chambers of four
UPPER = Case(
    {
        "type": "antagonistic",
        "chambers": 4,
        "symmetry": True,
        "pitch": f"{PITCH} mm",
        "radius": "14 mm",
        "central_wall": "8 mm",
        "bore": "6 mm",
        "bore_distance": "8.5 mm",
        "mesh_size": "30 mm",
    },
    pressure=8.0,
    begins=5 + 1.5 * PITCH,
    cavity="upper_a",
)
LOWER = replace(
    UPPER,
    geometry=UPPER.geometry | {"module_of": "lower", "in_plane": "lower"},
    begins=5 + 4 * PITCH + 4 + 1.5 * PITCH,
    pressure=14.0,
    cavity="lower_a",
)


@pytest.mark.parametrize("case", [UPPER, LOWER], ids=["upper", "lower"])
def test_a_module_is_an_inner_one_of_the_whole(case, tmp_path):
    assert_like_an_inner_one(case, tmp_path)

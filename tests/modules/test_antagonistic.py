"""A module of the upper of two pairs, with the bores to the lower one in its central wall."""

from tests.modules.chain import Case, assert_like_an_inner_one

PITCH = 60.0  # so long that the plates are far from the two inner chambers of four
PAIR = Case(
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


def test_a_module_is_an_inner_one_of_the_whole(tmp_path):
    assert_like_an_inner_one(PAIR, tmp_path)

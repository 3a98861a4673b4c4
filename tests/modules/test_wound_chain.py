"""A slice of a wound tube on a base of paper, beside its middle."""

from tests.modules.chain import PAPER, RUBBER, WOUND, Case, assert_like_an_inner_one

TUBE = Case(
    {
        "type": "fiber_reinforced",
        "length": "90 mm",
        "radius": "6 mm",
        "wall": "1 mm",
        "base_wall": "1 mm",
        "mesh_size": "4 mm",
    },
    pressure=20.0,
    begins=5 + 10 * 4,
    materials={"body": RUBBER, "sleeve": WOUND},
    more={"layers": [{"surface": "base", **PAPER}]},
)


def test_a_slice_is_the_middle_of_the_whole(tmp_path):
    assert_like_an_inner_one(TUBE, tmp_path)

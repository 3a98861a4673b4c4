"""The strongest derivative in words."""

import pytest

from softact.report.slopes import _said
from softact.sensitivities.stored import Slope


@pytest.mark.parametrize(("elasticity", "told"), [(-1.43, "−14.3 %"), (0.5, "+5 %")])
def test_what_a_tenth_more_changes_has_one_sign(elasticity, told):
    slope = Slope(3, "elongation_mm", "geometry.wall", "1.5 mm", -13.7, "mm/mm", elasticity)
    wanted = f"geometry.wall larger by 10 %: {told} of elongation"
    assert _said([slope], "elongation_mm") == wanted

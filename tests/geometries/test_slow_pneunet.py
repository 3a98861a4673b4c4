"""The slow PneuNet's own rules: what closes the chambers below, and what is refused."""

import numpy as np
import pytest
from pydantic import ValidationError

from softact.geometries.slow_pneunet import SlowPneunet


def slow(**given):
    """A slow PneuNet from lengths in mm (and whole numbers, truths and texts)."""
    return SlowPneunet.model_validate(
        {k: f"{v} mm" if isinstance(v, float) else v for k, v in given.items()}
    )


def test_volumes_of_the_published_actuator_by_hand():
    """Block 52 x 22 x 15 mm; air 5 x 2 x 8 x 8 and four tunnels 7 x 2 x 2; film 52 x 22 x 0.5."""
    volumes = slow(symmetry=False).volumes()
    air = 5 * 2 * 8 * 8 + 4 * 7 * 2 * 2
    assert volumes["cavity"] == pytest.approx(air)
    assert volumes["body"] == pytest.approx(52 * 22 * 15 - air)
    assert volumes["film"] == pytest.approx(52 * 22 * 0.5)
    assert slow().length == 52


def test_the_film_alone_closes_the_floor(meshed):
    """The cavity's walls that look up are the film's: chambers 5 x 2 x 4 mm and tunnels 4 x 7 x 1
    in the half, at the height of the film."""
    solid = meshed(slow())
    middles, areas = solid.outward_areas("cavity")
    up = areas[:, 2] > 1e-9
    floor = up & (abs(middles[:, 2] - 0.5) < 1e-9)
    assert areas[floor, 2].sum() == pytest.approx(5 * 2 * 4 + 4 * 7 * 1)
    assert not (up & ~floor).any()


def test_the_linear_kind_is_symmetric_up_and_down(meshed):
    solid = meshed(slow(kind="linear"))
    middle = 7.0 + 4.0
    assert solid.points[:, 2].max() == pytest.approx(2 * middle)
    for name in ("cavity", "outer"):
        middles, areas = solid.outward_areas(name)
        weight = np.linalg.norm(areas, axis=1)
        moments = [(weight * (middles[:, 2] - middle) ** p).sum() for p in (1, 3)]
        assert moments == pytest.approx([0, 0], abs=1e-6 * weight.sum())
    assert solid.layout.regions == ("body",)


@pytest.mark.parametrize(
    ("given", "field", "reason"),
    [
        ({"tunnel_height": 9.0}, "tunnel_height", "the roof would be thinned or vanish"),
        ({"tunnel_width": 9.0}, "tunnel_width", "outer walls would be thinned or vanish"),
        ({"film_width": 7.0}, "film_width", "would not close it"),
        ({"film_width": 23.0}, "film_width", "wider than the block (22 mm)"),
        ({"floor": 7.0}, "floor", "the bending kind has none"),
        ({"kind": "linear", "film_thickness": 0.5}, "film_thickness", "linear kind has none"),
        ({"inner_wall": 0.0}, "inner_wall", "the inner wall would vanish"),
        ({"film_thickness": 0.0}, "film_thickness", "the film thickness would vanish"),
    ],
)
def test_impossible_parameters_are_refused(given, field, reason):
    with pytest.raises(ValidationError) as caught:
        slow(**given)
    (fault,) = caught.value.errors()
    assert fault["loc"] == (field,) and reason in fault["msg"]

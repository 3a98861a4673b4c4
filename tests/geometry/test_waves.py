"""The wall of round bellows against its own points, measured without any closed form."""

import numpy as np
import pytest

from softact.geometry.waves import Wave

# U: upright flanks; V: leaning ones; shallow: arcs that meet without a flank's help.
WAVES = {
    "U": Wave(3, 8.0, 8.5, 14.5, 2.0),
    "V": Wave(2, 10.0, 8.75, 15.25, 1.6),
    "shallow": Wave(1, 12.0, 10.0, 11.0, 2.5),
}
WALL = 1.2


@pytest.fixture(params=WAVES)
def wave(request):
    return WAVES[request.param]


def offset(wave, out, pieces=240_000):
    """Places (n,), (n,) along the axis and the radius, a distance outside of the wall's middle."""
    x, radius, angle = wave.place(np.linspace(0.0, wave.length, pieces + 1))
    return x - out * np.sin(angle), radius + out * np.cos(angle)


def turned(x, radius):
    """Volume inside a curve that turns about the axis, of many cones."""
    a, b = radius[:-1], radius[1:]
    return np.pi / 3 * float(((a**2 + a * b + b**2) * np.diff(x)).sum())


def test_it_runs_from_root_to_root_by_way_of_its_crests(wave):
    x, radius = offset(wave, 0.0)
    assert (x[0], radius[0]) == pytest.approx((0.0, wave.root))
    assert (x[-1], radius[-1]) == pytest.approx((wave.count * wave.pitch, wave.root))
    assert (radius.min(), radius.max()) == pytest.approx((wave.root, wave.crest))
    crests = x[np.isclose(radius, wave.crest, rtol=0, atol=1e-9)]
    assert len(np.unique(crests.round(2))) == wave.count


def test_its_length_is_that_of_its_points_and_it_has_no_corners(wave):
    x, radius = offset(wave, 0.0)
    steps = np.hypot(np.diff(x), np.diff(radius))
    assert steps == pytest.approx(wave.length / len(steps), rel=1e-6)
    _, _, angle = wave.place(np.linspace(0.0, wave.length, len(x)))
    assert np.abs(np.diff(angle)).max() <= 1.001 * steps[0] / wave.fold
    direction = np.arctan2(np.diff(radius), np.diff(x))
    assert direction == pytest.approx((angle[:-1] + angle[1:]) / 2, abs=1e-4)


def test_volumes_are_those_between_its_offsets(wave):
    inside, outside = (turned(*offset(wave, side * WALL / 2)) for side in (-1, 1))
    assert wave.air_volume(WALL) == pytest.approx(inside, rel=1e-8)
    assert wave.wall_volume(WALL) == pytest.approx(outside - inside, rel=1e-7)


@pytest.mark.parametrize("out", [-0.5, 0.0, 0.5])
def test_the_slope_through_a_point_of_the_wall_is_that_of_the_middle_below_it(wave, out):
    x, radius, angle = wave.place(np.linspace(0.0, wave.length, 1001))
    place = x - out * WALL * np.sin(angle), radius + out * WALL * np.cos(angle)
    assert wave.slope(*place) == pytest.approx(angle, abs=1e-6)


def test_stations_are_near_enough_and_hold_all_joints(wave):
    stations = wave.stations(1.5, WALL)
    arc = wave.fold * wave.lean
    assert np.diff(stations).min() > 0
    assert np.diff(stations).max() <= 1.5 + 1e-9
    for joint in (0.0, arc, arc + wave.flank, wave.half, wave.length):
        assert np.abs(stations - joint).min() < 1e-9

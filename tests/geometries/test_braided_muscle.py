"""The braided muscle against what follows from a braid of inextensible threads."""

import numpy as np
import pytest
import scipy.integrate
from pydantic import ValidationError

from softact.geometries.braided_muscle import BraidedMuscle
from softact.results.folder import read
from softact.run.start import run
from softact.spec import loads

# Threads so stiff that they keep their length. The hydrostatic stress jumps between tube and braid,
# which a continuous pressure cannot follow: with P2/P1 the muscle pulls 2 % too hard.
MUSCLE = """
geometry:
  {{type: braided_muscle, length: {length} mm, radius: 7 mm, braid: 0.5 mm, wall: 1 mm, end: 5 mm,
    mesh_size: 8 mm}}
materials:
  body: {{law: neo_hookean, c10: 50 kPa, density: 1000 kg/m^3}}
  braid:
    {{law: holzapfel, c10: 50 kPa, k1: {stiffness} GPa, angle: {angle} deg, density: 1000 kg/m^3}}
  ends: {{law: neo_hookean, c10: 1 GPa, density: 1000 kg/m^3}}
supports:
  - {{surface: clamp, fix: [x, y, z]}}
  - {{surface: tip, fix: [y, z], move: {{x: 0 mm}}}}
solver: {{element: P2/P0, initial_increment: 0.5, max_increment: 1}}
steps:
  - {{name: blocked, pressure: 100 kPa}}
"""
SHORTER = """
  - name: shorter
    supports:
      - {{surface: clamp, fix: [x, y, z]}}
      - {{surface: tip, fix: [y, z], move: {{x: {move} mm}}}}
"""
BORE, INSIDE, OUTSIDE = 5.5, 6.5, 7.0  # radii of the bore and of the braid, mm
RADIUS = (INSIDE + OUTSIDE) / 2
C10, PRESSURE = 0.05, 0.1  # MPa


@pytest.fixture
def pull(tmp_path):
    """Function from the text of a spec to the pull of the muscle on its tip's support, by step."""

    def solve(text):
        outcome = run(loads(text), tmp_path / "result", report=False)
        assert outcome.status == "complete", outcome.message
        curve = read(tmp_path / "result").curve
        return dict(zip(curve["step"], -curve["tip_force_x_N"], strict=True))

    return solve


def braid(angle, contraction):
    """Pull in N: F = p π r0² (3 (1 − ε)²/tan² α − 1/sin² α), from the virtual work of the pressure
    in threads that keep their length (Chou and Hannaford 1996; Tondu and Lopez 2000)."""
    angle = np.radians(angle)
    shape = 3 * (1 - contraction) ** 2 / np.tan(angle) ** 2 - 1 / np.sin(angle) ** 2
    return PRESSURE * np.pi * RADIUS**2 * shape


def rubber(angle, contraction):
    """What the rubber takes off the pull, N: the slope of the strain energy of an incompressible
    tube whose middle braid's radius follows from threads that keep their length."""
    sine, cosine = np.sin(np.radians(angle)), np.cos(np.radians(angle))

    def energy(along):
        """Of 1 mm of the tube that is stretched by a factor, mJ."""
        middle = RADIUS * np.sqrt(1 - (along * cosine) ** 2) / sine

        def density(radius):
            around = np.sqrt(middle**2 - (RADIUS**2 - radius**2) / along) / radius
            i1 = along**2 + around**2 + (along * around) ** -2
            return C10 * (i1 - 3) * 2 * np.pi * radius

        return scipy.integrate.quad(density, BORE, OUTSIDE)[0]

    step = 1e-5
    along = 1 - contraction
    return (energy(along - step) - energy(along + step)) / (2 * step)


@pytest.mark.parametrize("angle", [30, 65])
def test_a_muscle_that_is_held_at_its_length_pulls_as_its_braid_says(angle, pull):
    """Nothing moves but by the threads' stretch, so ends and rubber have no effect; above the
    neutral angle it pushes."""
    found = pull(MUSCLE.format(length=30, angle=angle, stiffness=10))["blocked"]
    assert found == pytest.approx(braid(angle, 0.0), rel=0.01)


def test_at_the_neutral_angle_it_neither_pulls_nor_pushes(pull):
    """tan² α = 2, 54.7°: the force is less than 1 % of the pressure on the ends."""
    neutral = np.degrees(np.arctan(np.sqrt(2)))
    found = pull(MUSCLE.format(length=30, angle=neutral, stiffness=10))["blocked"]
    assert abs(found) < 0.01 * PRESSURE * np.pi * RADIUS**2


def test_a_shorter_muscle_pulls_less_and_its_ends_take_their_part(pull):
    """At a contraction of 5 % a muscle lacks what its two ends, which stay narrow, take of its
    length. That part falls as 1/L, so that two lengths together give the closed form."""
    lacking, exact = {}, braid(30, 0.05) - rubber(30, 0.05)
    for tube in (50, 100):
        text = MUSCLE.format(length=tube + 10, angle=30, stiffness=1)
        text += SHORTER.format(move=-0.05 * tube)
        lacking[tube] = 1 - pull(text)["shorter"] / exact
    assert 0.05 < lacking[100] < lacking[50]
    assert 2 * lacking[100] - lacking[50] == pytest.approx(0.0, abs=0.005)


@pytest.mark.parametrize(
    ("given", "field", "reason"),
    [
        ({"wall": "6.4 mm"}, "radius", "the bore would vanish"),
        ({"end": "50 mm"}, "end", "the tube would vanish"),
    ],
)
def test_walls_that_vanish_are_refused(given, field, reason):
    with pytest.raises(ValidationError) as caught:
        BraidedMuscle.model_validate(given)
    assert caught.value.errors()[0]["loc"] == (field,)
    assert reason in caught.value.errors()[0]["msg"]

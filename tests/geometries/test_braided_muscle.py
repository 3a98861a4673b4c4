"""The braided muscle against what follows from a braid of inextensible threads."""

import numpy as np
import pytest
import scipy.integrate
import scipy.optimize
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


def stretching(k1, angle, pressure, c10):
    """Pull in N of a long muscle that is held at its length, of threads that stretch: k1 (MPa) as
    in the law. A tube that does not get longer keeps its volume: r² = R² + g. What carries the
    pressure across its wall tells g; the pull is π ∫ (2 σx − σr − σt) r dr."""
    sine, cosine = np.sin(np.radians(angle)) ** 2, np.cos(np.radians(angle)) ** 2

    def stresses(radius, grown):
        """Along the radius, around and along the axis, less one that all three share."""
        wider = 1 + grown / radius**2
        thread = 4 * k1 * max(cosine + sine * wider - 1, 0.0) if radius > INSIDE else 0.0
        around = 2 * c10 * wider + thread * sine * wider
        return 2 * c10 / wider, around, 2 * c10 + thread * cosine

    def over_the_wall(of):
        return sum(
            scipy.integrate.quad(of, *ends)[0] for ends in ((BORE, INSIDE), (INSIDE, OUTSIDE))
        )

    def carried(grown):
        def slope(radius):
            across, around, _ = stresses(radius, grown)
            return (around - across) * radius / (radius**2 + grown)

        return over_the_wall(slope)

    grown = scipy.optimize.brentq(lambda g: carried(g) - pressure, 0.0, OUTSIDE**2)

    def pulls(radius):
        across, around, along = stresses(radius, grown)
        return np.pi * (2 * along - across - around) * radius

    return over_the_wall(pulls)


def test_threads_that_stretch_and_rubber_take_their_part_of_the_pull(pull):
    """A fifth of that of the ideal braid; two lengths together give that of a long muscle, as
    below."""
    # An ideal braid has no thickness: (0.5/6.75)² = 0.5 %.
    assert stretching(1e6, 30, PRESSURE, 1e-6) == pytest.approx(braid(30, 0.0), rel=5e-3)
    exact, lacking = stretching(0.05e3, 30, PRESSURE, 0.2), {}
    assert exact == pytest.approx(0.8 * braid(30, 0.0), rel=0.05)
    for tube in (40, 80):
        text = MUSCLE.format(length=tube + 10, angle=30, stiffness=0.05)
        lacking[tube] = 1 - pull(text.replace("50 kPa", "200 kPa"))["blocked"] / exact
    assert 0.02 < lacking[80] < lacking[40]
    assert 2 * lacking[80] - lacking[40] == pytest.approx(0.0, abs=0.01)


def test_a_shorter_muscle_pulls_less_and_its_ends_take_their_part(pull):
    """At a contraction of 5 % a muscle lacks what its two ends, which stay narrow, take of its
    length. That part falls as 1/L, so that two lengths together give the closed form: 1.1 % more
    at this mesh, 0.8 % at half its size."""
    lacking, exact = {}, braid(30, 0.05) - rubber(30, 0.05)
    for tube in (50, 100):
        text = MUSCLE.format(length=tube + 10, angle=30, stiffness=1)
        text += SHORTER.format(move=-0.05 * tube)
        lacking[tube] = 1 - pull(text)["shorter"] / exact
    assert 0.05 < lacking[100] < lacking[50]
    assert 2 * lacking[100] - lacking[50] == pytest.approx(0.0, abs=0.015)


@pytest.mark.parametrize("part", ["half", "whole"])
def test_the_number_of_tetrahedra_is_known_before_there_is_a_mesh(part, meshed):
    muscle = BraidedMuscle.model_validate({"length": "20 mm", "part": part, "through_wall": 5})
    assert muscle.cells() == len(meshed(muscle).cells)


@pytest.mark.parametrize(
    ("given", "field", "reason"),
    [
        ({"wall": "6.4 mm"}, "radius", "would vanish; write more than 7 mm"),
        ({"end": "50 mm"}, "end", "the tube would vanish; write less than 50 mm"),
        ({"mesh_size": "1 m"}, "mesh_size", "wide: no element would show how it opens at its ends"),
    ],
)
def test_walls_that_vanish_are_refused(given, field, reason):
    with pytest.raises(ValidationError) as caught:
        BraidedMuscle.model_validate(given)
    assert caught.value.errors()[0]["loc"] == (field,)
    assert reason in caught.value.errors()[0]["msg"]

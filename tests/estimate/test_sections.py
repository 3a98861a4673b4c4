"""Walls against pressure, section by section: beams, the paper's equations, exact solutions."""

import numpy as np
import pytest
from scipy.integrate import quad

from softact.estimate import polygerinos, reach, thick, uniaxial
from softact.estimate.beam import Beam, blocked, follow
from softact.estimate.sections import Film, Section, rectangle, region
from softact.materials.laws.gent import Gent
from softact.materials.laws.holzapfel import Holzapfel
from softact.materials.laws.neo_hookean import NeoHookean
from softact.materials.laws.ogden import Ogden
from softact.materials.laws.yeoh import Yeoh

MU = 0.2
SOFT = NeoHookean(c10="0.1 MPa")
YEOH = Yeoh(c10="0.11 MPa", c20="0.02 MPa")
STRETCHES = np.array([0.7, 1.0, 1.2, 1.8])


def test_uniaxial_stress_of_neo_hooke():
    exact = MU * (STRETCHES - STRETCHES**-2)
    assert uniaxial.free_across(SOFT)(STRETCHES) == pytest.approx(exact, abs=1e-6)


def test_stress_of_the_papers_material_is_its_equation_3():
    found = uniaxial.held_across(YEOH)(STRETCHES)
    assert found == pytest.approx(polygerinos.stress(0.11, 0.02, STRETCHES), abs=1e-5)


def test_equation_3_is_the_derivative_of_equation_1():
    step = 1e-6
    slope = (polygerinos.strain_energy(0.11, 0.02, STRETCHES + step)
             - polygerinos.strain_energy(0.11, 0.02, STRETCHES - step)) / (2 * step)  # fmt: skip
    assert polygerinos.stress(0.11, 0.02, STRETCHES) == pytest.approx(slope, rel=1e-6, abs=1e-9)


def test_ogden_takes_the_same_way():
    ogden = Ogden.of(mu1=MU, alpha1=2.0)  # neo-Hooke
    found = uniaxial.free_across(ogden)(STRETCHES)
    assert found == pytest.approx(uniaxial.free_across(SOFT)(STRETCHES), abs=1e-9)


def test_of_a_law_with_fibres_its_matrix_is_taken():
    fabric = Holzapfel(c10="0.1 MPa", k1="100 MPa", angle="80 deg")
    found = uniaxial.free_across(fabric)(STRETCHES)
    assert found == pytest.approx(uniaxial.free_across(SOFT)(STRETCHES))


def test_a_law_that_locks_has_a_stress_up_to_there():
    locking = Gent.of(mu=MU, jm=2.0)
    stress = uniaxial.free_across(locking)(np.array([1.2, 1.5, 10.0]))
    assert np.isfinite(stress).all() and (np.diff(stress) > 0).all()


def test_arc_of_a_wall():
    """Equation 2: a sagitta of half the chord is a semicircle; its stretch is pi/2."""
    assert polygerinos.half_angle(4.0, 8.0) == pytest.approx(np.pi / 2)
    assert polygerinos.stretch(4.0, 8.0) == pytest.approx(np.pi / 2)
    # A known arc: radius 10, half angle 0.3 and, beyond a semicircle, 2.0.
    for angle in (0.3, 2.0):
        chord, sagitta = 20 * np.sin(angle), 10 * (1 - np.cos(angle))
        assert polygerinos.half_angle(sagitta, chord) == pytest.approx(angle)


def test_pressure_of_a_bulging_wall_is_that_of_a_membrane():
    """Half of a long tube of chord 2R: p R = nominal stress times thickness."""
    radius, thickness = 5.0, 0.5
    s = np.pi / 2
    nominal = MU * (s - s**-3)  # pure shear
    found = polygerinos.pressure(SOFT, radius, 2 * radius, thickness)
    assert found == pytest.approx(nominal * thickness / radius, rel=1e-5)


def test_moment_arm_of_equation_5():
    """The walls' height squared as they touch, nothing once they have bulged by b/sqrt(2) more."""
    b, d = 16.0, 1.0
    assert polygerinos.moment_arm(d / 2, b, d) == pytest.approx(b**2)
    assert polygerinos.moment_arm((d + b / np.sqrt(2)) / 2, b, d) == pytest.approx(0.0, abs=1e-9)


def test_a_section_bends_as_a_beam():
    """Small pressure in a box over a layer that does not stretch: b = p S / (E I), by hand."""
    half, height, wall, e = 4.0, 10.0, 1.0, 3 * MU
    stress = uniaxial.free_across(SOFT)
    walls = [rectangle(half, half + wall, 0.0, height), rectangle(-half - wall, -half, 0.0, height)]
    air = rectangle(-half, half, 0.0, height)
    section = Section(1.0, [(w, stress) for w in walls], {"cavity": air}, [Film(0.0, 10.0, 1e7)])
    strain = section.solve(section.pressed({"cavity": 1e-6}), np.zeros(3))
    moment, inertia = 1e-6 * 2 * half * height**2 / 2, 2 * wall * height**3 / 3
    assert strain[1] == pytest.approx(moment / (e * inertia), rel=2e-3)
    assert strain[0] == pytest.approx(0.0, abs=1e-8)
    assert strain[2] == pytest.approx(0.0, abs=1e-12)


def test_a_section_bends_towards_where_it_is_pressed():
    """A ring, pressed in one quarter of its inside: the plane is that of the quarter's centre."""
    stress = uniaxial.free_across(SOFT)
    ring = region(lambda y, z: (np.hypot(y, z) < 10) & (np.hypot(y, z) > 8), 10.0)
    quarter = region(lambda y, z: (np.hypot(y, z) < 8) & (y > 0) & (z > 0), 10.0)
    section = Section(1.0, [(ring, stress)], {"cavity": quarter})
    strain = section.solve(section.pressed({"cavity": 1e-5}), np.zeros(3))
    assert strain[1] > 0 and strain[1] == pytest.approx(strain[2], rel=1e-6)


def test_more_than_walls_carry_has_no_answer():
    """Neo-Hooke in tension carries any force: a law that softens does not."""
    weak = uniaxial.free_across(Ogden.of(mu1=MU, alpha1=-0.5))  # nominal stress has a maximum
    tube = rectangle(-5.0, 5.0, -1.0, 1.0)
    section = Section(1.0, [(tube, weak)], {"cavity": rectangle(-4.0, 4.0, 1.0, 9.0)})
    beam = Beam([section], 10.0)
    curve = follow(beam, {"cavity": 1.0}, np.linspace(0, 1, 11))
    assert curve.reached < 1.0 and len(curve.angle) == round(10 * curve.reached) + 1


def test_what_blocks_a_straight_tube_is_the_pressure_on_its_end():
    stress = uniaxial.free_across(SOFT)
    ring = region(lambda y, z: (np.hypot(y, z) < 10) & (np.hypot(y, z) > 8), 10.0)
    air = region(lambda y, z: np.hypot(y, z) < 8, 10.0)
    beam = Beam([Section(30.0, [(ring, stress)], {"cavity": air})], 40.0)
    pull, moments = blocked(beam, {"cavity": 0.01})
    assert pull == pytest.approx(0.01 * np.pi * 8**2, rel=5e-3)
    assert moments == pytest.approx(0.0, abs=1e-9)
    curve = follow(beam, {"cavity": 0.01}, np.linspace(0, 1, 5))
    # λ − λ⁻² = p A / (μ A_wall), at full pressure.
    stretch = 1 + curve.elongation[-1] / 30.0
    assert stretch - stretch**-2 == pytest.approx(0.01 * 64 / (MU * 36), rel=5e-3)


def test_stiffness_is_that_of_a_beam():
    stress = uniaxial.free_across(SOFT)
    beam = Beam([Section(20.0, [(rectangle(-3.0, 3.0, -2.0, 2.0, 200), stress)])], 20.0)
    curve = follow(beam, {}, np.zeros(1))
    bend, across = 3 * MU * np.array([6 * 4**3, 4 * 6**3]) / 12
    assert curve.stiffness[0] == pytest.approx([bend, across], rel=1e-3)


def test_sphere_is_that_of_the_reference_case():
    """39.316 kPa at an inner stretch of 1.5 (configs/reference/thick_sphere_yeoh.yaml)."""
    found = thick.sphere_pressure(YEOH, 10.0, 11.0, np.array([1.5]))
    assert 1e3 * found[0] == pytest.approx(39.316, abs=2e-3)


def test_tube_in_plane_strain_is_that_of_a_logarithm():
    """Neo-Hooke: p = μ/2 (2 ln(A⁻¹B a/b) + (a² − A²)(1/a² − 1/b²)); the pull by quadrature."""
    inner, outer, stretch = 5.0, 7.0, 1.2
    a = inner * stretch
    b = np.sqrt(outer**2 + a**2 - inner**2)
    c = a**2 - inner**2
    exact = MU / 2 * (2 * np.log(outer / inner / (b / a)) + c * (1 / a**2 - 1 / b**2))
    pressure, pull = thick.tube_pressure(SOFT, inner, outer, np.array([stretch]), np.ones(1))
    assert pressure[0] == pytest.approx(exact, rel=1e-5)

    def radial(r):
        return -quad(lambda x: MU * (x**2 / (x**2 - c) - (x**2 - c) / x**2) / x, r, b)[0]

    def axial(r):
        return (radial(r) + MU * (1 - (r**2 - c) / r**2)) * 2 * np.pi * r

    assert pull[0] == pytest.approx(quad(axial, a, b)[0], rel=1e-4)


def test_a_slit_opens_as_a_crack():
    """Volume of a penny-shaped crack, 16 (1 − ν²) a³ s/(3 E) at ν = 1/2, over area and strain."""
    radius = 3.0
    area = np.pi * radius**2
    alone = reach.opened(0.0, reach.slit_decay(area), 1e6)
    assert alone * area == pytest.approx(16 * 0.75 * radius**3 / 3)
    # Walls between slits that are short beside the slits give their whole length.
    assert reach.opened(1.0, 50.0, 0.1) == pytest.approx(1.1, rel=1e-3)

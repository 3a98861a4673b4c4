"""The reduced model itself: its shapes against arcs, its equilibrium against beams and the
elastica, its volume against its work."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from softact.export.rod import COMPONENTS, Rod, rotations

LENGTH, BENDING = 100.0, 400.0


def rod(pieces=20, rest=(0.0, 0.0), stiffness=(BENDING, BENDING), mass=0.0, free=("bending_y",)):
    """A rod from 0 to LENGTH whose curvature about y and stiffness go from one value to another
    between 0 and 10 kPa."""
    nothing = {f"rest_{c}": [0.0, 0.0] for c in COMPONENTS}
    stiff = {f"stiffness_{c}": [1e9, 1e9] for c in COMPONENTS}
    table = {"pressure_kPa": [0.0, 10.0], **nothing, **stiff, "rest_volume_mm3": [100.0, 300.0]}
    table |= {"rest_bending_y": list(rest), "stiffness_bending_y": list(stiffness)}
    table["stiffness_bending_z"] = list(stiffness)
    return Rod({
        "pieces": pieces, "start_mm": 0.0, "active_length_mm": LENGTH, "end_mm": 0.0,
        "tip_y_mm": 0.0, "tip_z_mm": 0.0, "offset_y_mm": 0.0, "offset_z_mm": 0.0,
        "components": list(free), "table": table,
        "masses": {"mass_tonne": [0.0, *[mass / pieces] * pieces, 0.0],
                   "centre_mm": [[0.0] * 3] * (pieces + 2)},
    })  # fmt: skip


@pytest.mark.parametrize("size", [0.0, 1e-5, 1e-3, 2.0])
def test_rotation_and_chord_of_an_arc(size):
    axis = np.array([1.0, 2.0, -2.0]) / 3
    turn, chord = rotations(size * axis)
    assert turn == pytest.approx(Rotation.from_rotvec(size * axis).as_matrix(), abs=1e-12)
    points, weights = np.polynomial.legendre.leggauss(12)
    on_the_way = Rotation.from_rotvec((points[:, None] + 1) / 2 * size * axis).as_matrix()
    assert chord == pytest.approx(np.einsum("n,nij->ij", weights / 2, on_the_way), abs=1e-8)


@pytest.mark.parametrize("pieces", [1, 7])
def test_a_rod_without_a_load_is_an_arc(pieces):
    radius = 40.0
    state = rod(pieces, rest=(0.0, 1 / radius)).state(10.0)
    angle = LENGTH / radius
    assert state["bending_angle_deg"][0] == pytest.approx(np.degrees(angle))
    assert state["tip_x_mm"][0] == pytest.approx(radius * np.sin(angle))
    # Positive angles about y turn x towards -z.
    assert state["tip_z_mm"][0] == pytest.approx(-radius * (1 - np.cos(angle)))


def test_a_twisted_and_bent_rod_is_a_helix():
    """Constant twist w and curvature k: a helix about w e1 + k e2, of which the tip is known."""
    w, k = 0.02, 0.03
    found = rod(3, free=("twist", "bending_y"))
    strains = np.zeros((1, 3, 4))
    strains[..., 0], strains[..., 1] = w, k
    place, _ = found.tip(strains)
    rate = np.hypot(w, k)
    axis = np.array([w, k, 0.0]) / rate
    along = axis * axis[0]
    across = np.array([1.0, 0.0, 0.0]) - along
    turned = np.cross(axis, across)
    exact = along * LENGTH + (across * np.sin(rate * LENGTH)
                              + turned * (1 - np.cos(rate * LENGTH))) / rate  # fmt: skip
    assert place[0] == pytest.approx(exact)


def test_small_deflection_of_a_cantilever_converges_with_the_second_order():
    force = 1e-4
    exact = force * LENGTH**3 / (3 * BENDING)
    errors = [abs(rod(n).state(0.0, [[0, 0, force]])["tip_z_mm"][0] / exact - 1) for n in (8, 16)]
    assert errors[1] < 2e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


def test_weight_of_a_cantilever():
    """Tip of a beam under its own weight: q L⁴/8EI."""
    mass, gravity = 1e-9, 9810.0
    exact = mass * gravity * LENGTH**3 / (8 * BENDING)
    state = rod(20, mass=mass).state(0.0, gravity=[[0, 0, -gravity]])
    assert state["tip_z_mm"][0] == pytest.approx(-exact, rel=5e-3)


def test_large_deflection_is_the_elastica():
    """A dead force F across the tip: EI a'' + F cos a = 0, a(0) = 0, a'(L) = 0, by shooting."""
    force = 3 * BENDING / LENGTH**2

    def shoot(start):
        def slope(_, y):
            return [y[1], -force * np.cos(y[0]) / BENDING, np.cos(y[0]), np.sin(y[0])]

        return solve_ivp(slope, (0, LENGTH), [0, start, 0, 0], rtol=1e-10, atol=1e-12).y[:, -1]

    start = brentq(lambda s: shoot(s)[1], 0.0, 2 * force * LENGTH / BENDING)
    angle, _, x, z = shoot(start)
    state = rod(40).state(0.0, [[0, 0, force]])
    assert state["bending_angle_deg"][0] == pytest.approx(-np.degrees(angle), rel=1e-3)
    assert state["tip_x_mm"][0] == pytest.approx(x, rel=1e-3)
    assert state["tip_z_mm"][0] == pytest.approx(z, rel=1e-3)


def test_a_cycle_of_pressure_and_load_makes_no_energy():
    """Work of the pressure on the volume and of the force on the tip add up to nothing."""
    found = rod(8, rest=(0.0, 0.012), stiffness=(400.0, 700.0))
    turn = np.linspace(0, 2 * np.pi, 241)
    pressure, force = 5 - 4 * np.cos(turn), 0.02 + 0.05 * np.sin(turn)
    state = found.state(pressure, np.column_stack([0 * force, 0 * force, force]))

    def work(of, change):
        return float((of[1:] + of[:-1]) / 2 @ np.diff(change))

    by_air = work(1e-3 * pressure, state["cavity_volume_mm3"])
    by_force = work(force, state["tip_z_mm"])
    assert abs(by_force) > 0.05
    assert by_air + by_force == pytest.approx(0.0, abs=2e-3 * abs(by_force))

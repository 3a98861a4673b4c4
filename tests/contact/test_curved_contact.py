"""Contact of walls that are curved in the mesh: quarters of round tubes, solved exactly."""

import numpy as np
import pytest
import scipy.integrate
import scipy.optimize

from softact.contact.obstacles.cylinder import Cylinder
from softact.contact.rigid import Obstacle
from softact.contact.surfaces import Touching
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.measures.further_fields import further_fields
from softact.measures.snapshot import Snapshot
from softact.model import Support
from tests.analytic.meshes import block
from tests.analytic.solving import build, solve

C10 = 0.14  # MPa
SOFT = LAWS["neo_hookean"].of(c10=C10, bulk_modulus=1e4)
INNER, OUTER, GAP = 10.0, 16.0, 0.1  # mm
QUARTER = {"x_min": 0, "x_max": 2}
STILL = [Support("y_min", {1: 0.0}), Support("y_max", {1: 0.0})]  # the length stays


def tube(divisions, radii, shear=0.0, curved=True):
    """A quarter of a tube about y, of layers between these radii (mm); every second one is left
    out, and the walls beside it are ``inside``.

    divisions: edges of the quarter. shear: how far the mesh lines of the outer half lie beside
    those of the inner one, as a part of an edge.
    """
    layers = len(radii) - 1

    def places(points):
        angle = points[:, 0] / divisions
        beside = np.sin(np.pi * angle) * (points[:, 2] > layers / 2)
        angle = np.pi / 2 * (angle + shear / divisions * beside)
        radius = np.interp(points[:, 2], range(layers + 1), radii)
        return np.column_stack([radius * np.sin(angle), points[:, 1], radius * np.cos(angle)])

    def walls(centres):
        return centres[:, 2].astype(int) % 2 == 0

    size = float(divisions), 1.0, float(layers)
    return block((divisions, 1, layers), size, places, walls, curved)


def pressure(stretch, inner, outer):
    """Pressure inside (MPa) that stretches the inner circles of a tube of this length by so much;
    Ogden 1984, 5.3.3."""
    far = np.sqrt(1 + (stretch**2 - 1) * (inner / outer) ** 2)

    def slope(s):
        return 2 * C10 * (s - s**-3) / (s**2 - 1) if abs(s - 1) > 1e-9 else 4 * C10

    return scipy.integrate.quad(slope, far, stretch, epsabs=1e-14)[0]


def contact_pressures(model, state):
    """Of all nodes that touch, MPa."""
    found = further_fields(Snapshot(model, state), ["contact_pressure"])["contact_pressure"]
    return found[found > 0]


def mean_stretch(model, state, surface, radius):
    """Of the circles of a surface that had this radius, and how far it varies."""
    nodes = model.surfaces.nodes(surface)
    moved = (model.nodes.places[nodes] + state.x[model.displacement_dofs[nodes]])[:, [0, 2]]
    found = np.linalg.norm(moved, axis=1) / radius
    return found.mean(), np.ptp(found)


def on_a_pin(curved):
    """A tube that is pressed from outside onto a rigid pin, 0.2 mm thinner than its bore."""
    pin = Obstacle("pin", Cylinder((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 9.8), surfaces=("z_min",))
    model = build(tube(4, (INNER, OUTER), 0, curved), SOFT, symmetry=QUARTER, obstacles=[pin])
    step = LoadStep("press", surface_pressure={"z_max": 0.08})
    return model, solve(model, step, STILL, 0.25).state


def test_a_tube_on_a_rigid_pin():
    """The pressure between them is the exact one of the stretch that is reached, everywhere; on a
    straight mesh it is not, since its facets are chords."""
    model, state = on_a_pin(True)
    stretch, varies = mean_stretch(model, state, "z_min", INNER)
    assert stretch == pytest.approx(0.98, abs=5e-3) and varies < 5e-4
    exact = 0.08 + pressure(stretch, INNER, OUTER)
    found = contact_pressures(model, state)
    # The field is per undeformed area.
    assert found == pytest.approx(exact * stretch, rel=0.01)
    assert np.ptp(contact_pressures(*on_a_pin(False))) > 10 * np.ptp(found)


def one_in_another(divisions, shear, curved):
    """A tube in another, with a gap that closes as it is inflated: the pressure between them of
    the stretch that the inner tube reaches, and the pressures that are found, both by the exact one
    of the stretch that the outer tube reaches."""
    between, inside = 13.0, 0.06
    tets = tube(divisions, (INNER, between, between + GAP, OUTER), shear, curved)
    touching = Touching("tubes", (("inside",),), 0.0)
    model = build(tets, SOFT, symmetry=QUARTER, touching=[touching])
    step = LoadStep("inflate", surface_pressure={"z_min": inside})
    state = solve(model, step, STILL, 0.25).state
    rim = mean_stretch(model, state, "z_max", OUTER)[0] * OUTER
    bore = between + GAP
    outer = np.sqrt(rim**2 - OUTER**2 + bore**2) / bore
    inner = mean_stretch(model, state, "z_min", INNER)[0]
    exact = pressure(outer, bore, OUTER)
    # The field is per undeformed area, of either side.
    touched = np.sqrt(between**2 + (inner**2 - 1) * INNER**2) / between
    nominal = exact * (touched + outer) / 2
    felt = (inside - pressure(inner, INNER, between)) / exact
    return felt, contact_pressures(model, state) / nominal


@pytest.mark.parametrize(("divisions", "shear", "uneven"), [(4, 0.0, 0.02), (8, 0.4, 0.2)])
def test_two_tubes(divisions, shear, uneven):
    """Both tubes feel the same pressure to 1e-3, whether their meshes match or not; with straight
    edges it is some per cent, and at nodes the pressure varies by far more."""
    felt, pressures = one_in_another(divisions, shear, True)
    assert felt == pytest.approx(1.0, rel=1e-3)
    assert pressures == pytest.approx(1.0, rel=uneven)
    straight, chords = one_in_another(divisions, shear, False)
    assert abs(straight - 1) > 30 * abs(felt - 1)
    assert np.ptp(chords) > 4 * np.ptp(pressures)

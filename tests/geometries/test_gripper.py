"""Several fingers around a ball: equal forces by symmetry, which add up to what the ball bears, and
each that of a finger alone."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
import yaml

from softact.api import run
from softact.geometry.base import export
from softact.spec import loads
from softact.system.rotation import rotation_about

SCRIPT = Path(__file__).parents[2] / "geometries/examples/gripper.py"
FINGERS, RADIUS, BALL = 3, 6.5, 6.0
MATERIALS = "{body: {law: neo_hookean, c10: 0.05 MPa}}"
FINGER = "{type: pneunet, chambers: 1, chamber_length: 8 mm, mesh_size: 12 mm, symmetry: false}"
END = """
obstacles: {{ball: {{type: sphere, center: [12 mm, 0 mm, {z} mm], radius: {ball} mm}}}}
steps: [{{name: close, pressure: {pressure}}}]
solver: {{initial_increment: 0.25, max_increment: 0.5}}
measures: [pressure, reaction, contact, volume]
"""


def script():
    spec = importlib.util.spec_from_file_location("gripper", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def alone(z):
    return f"geometry: {FINGER}\nmaterials: {MATERIALS}\n" + END.format(
        z=z, ball=BALL, pressure="20 kPa"
    )


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The finger's spec and mesh, and what the script makes of it."""
    top = tmp_path_factory.mktemp("gripper")
    finger = loads(alone(-RADIUS))
    export(finger.geometry, top / "finger.msh")
    parts = script().make(top / "finger.msh", top / "gripper.msh", FINGERS, RADIUS)
    return top, finger, parts


@pytest.fixture(scope="module")
def last(files):
    """Figures of the last states: of the gripper, and of a finger alone with the same ball."""
    top, finger, parts = files
    text = yaml.safe_dump(parts) + f"materials: {MATERIALS}\n"
    pressures = ", ".join(f"cavity_{n}: 20 kPa" for n in range(1, FINGERS + 1))
    text += END.format(z=0, ball=BALL, pressure=f"{{{pressures}}}")
    gripper = run(loads(text), top / "gripper", report=False)
    one = run(finger, top / "finger", report=False)
    assert gripper.status == one.status == "complete"
    return gripper.summary, one.summary


def force(row, name):
    return np.array([row[f"{name}_{c}_N"] for c in "xyz"])


def clamps(row):
    """Force (fingers, 3) of each clamp."""
    names = ["reaction", *(f"reaction_clamp_{n}" for n in range(2, FINGERS + 1))]
    return np.array([force(row, name) for name in names])


def test_the_fingers_press_alike(last):
    """A turn by a third takes each finger's force into the next one's; and it is no small one."""
    found = clamps(last[0])
    size = np.linalg.norm(found[0])
    assert size > 0.05
    turn = rotation_about((1, 0, 0), 360 / FINGERS)
    for one, other in zip(found, np.roll(found, -1, axis=0), strict=True):
        np.testing.assert_allclose(turn @ one, other, atol=1e-5 * size)


def test_their_forces_add_up_to_what_the_ball_bears(last):
    """Clamps and ball hold the gripper in balance; across the axis the fingers cancel."""
    row = last[0]
    total, ball = clamps(row).sum(axis=0), force(row, "contact_force_ball")
    size = np.linalg.norm(clamps(row)[0])
    np.testing.assert_allclose(total + ball, 0, atol=1e-5 * size)
    np.testing.assert_allclose(ball[1:], 0, atol=1e-5 * size)


def test_each_is_a_finger_alone(last):
    """A ball that nothing moves tells no finger of the others."""
    row, one = last
    size = np.linalg.norm(clamps(row)[0])
    np.testing.assert_allclose(clamps(row)[0], force(one, "reaction"), atol=1e-3 * size)
    wanted = FINGERS * force(one, "contact_force_ball")[0]
    assert force(row, "contact_force_ball")[0] == pytest.approx(wanted, rel=2e-3)
    for n in range(1, FINGERS + 1):
        volume = row[f"cavity_volume_cavity_{n}_mm3"]
        assert volume == pytest.approx(one["cavity_volume_mm3"], rel=1e-4)


def turned_back(points, n):
    return points @ rotation_about((1, 0, 0), 360 * n / FINGERS)


def clamped(solid, name):
    """Points (k, 3) of a clamp, in order."""
    points = solid.points[np.unique(solid.surfaces[name])]
    return points[np.lexsort(points.round(6).T)]


def test_the_mesh_is_the_fingers_so_often(files, meshed):
    """Its volume three times, and each clamp a finger's end, at the radius and a third of a turn on
    from the last."""
    _, finger, parts = files
    whole = meshed(loads(yaml.safe_dump(parts) + f"materials: {MATERIALS}\n"
                         "steps: [{pressure: {cavity_1: 1 kPa}}]").geometry)  # fmt: skip
    assert whole.volumes.sum() == pytest.approx(FINGERS * finger.geometry.volumes()["body"])
    wanted = clamped(meshed(finger.geometry), "clamp") + np.array([0.0, 0.0, RADIUS])
    for n in range(FINGERS):
        found = turned_back(clamped(whole, f"clamp_{n + 1}"), n)
        found = found[np.lexsort(found.round(6).T)]
        np.testing.assert_allclose(found, wanted, atol=1e-9)


def test_half_a_finger_is_refused(tmp_path):
    half = loads(alone(-RADIUS).replace("symmetry: false", "symmetry: true"))
    export(half.geometry, tmp_path / "half.msh")
    with pytest.raises(SystemExit, match="half a finger; write symmetry: false"):
        script().make(tmp_path / "half.msh", tmp_path / "g.msh", 3, 9.0)

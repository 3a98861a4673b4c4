"""Supports that turn or spring, and torques: what a spec may not say of them."""

import pytest

from softact import spec as specs
from softact.errors import SpecError

BLOCK = """
geometry: {{type: block, length: 6 mm, width: 4 mm, height: 4 mm}}
materials: {{body: ecoflex-00-30}}
supports: [{{surface: x_min, fix: [x, y, z]}}, {first}]
steps: [{{{step}}}]
"""
FINGER = """
geometry: {{type: pneunet}}
materials: {{body: ecoflex-00-30}}
supports: [{{surface: clamp, fix: [x, y, z]}}, {first}]
steps: [{{{step}}}]
"""
GRAVITY, FREE = "gravity: [0, 0, -1]", "{surface: x_max, fix: [y]}"


def fault(text, first=FREE, step=GRAVITY):
    with pytest.raises(SpecError) as caught:
        specs.loads(text.format(first=first, step=step), "spec.yaml")
    (line,) = caught.value.lines
    return line


@pytest.mark.parametrize(
    ("support", "said"),
    [
        ("{surface: x_max, fix: [x], turn: {axis: [1, 0, 0], angle: 3 deg}}", "leave fix, move"),
        ("{surface: x_max, fix: [x], spring: {x: 1 N/mm}}", "'x' has a spring and is prescribed"),
        ("{surface: x_max, spring: {x: 0 N/mm}}", "greater than 0"),
        ("{surface: x_max, spring: {x: 1 N}}", "N/mm"),
        ("{surface: x_max, turn: {axis: [0, 0, 0], angle: 3 deg}}", "all three are zero"),
        ("{surface: x_max}", "neither fixes nor moves"),
    ],
)
def test_supports(support, said):
    assert said in fault(BLOCK, first=support)


def test_a_spring_is_there_from_the_start():
    step = "supports: [{surface: x_min, fix: [x, y, z]}, {surface: x_max, spring: {x: 1 N/mm}}]"
    assert "springs act from the start" in fault(BLOCK, step=step)


def test_springs_hold_an_actuator():
    springs = "{surface: x_max, spring: {x: 1 N/mm, y: 1 N/mm, z: 1 N/mm}}"
    text = BLOCK.format(first=springs, step=GRAVITY).replace(
        "{surface: x_min, fix: [x, y, z]}, ", ""
    )
    spec = specs.loads(text)
    assert spec.supports[0].held == (0, 1, 2)
    assert specs.loads(spec.to_yaml()) == spec


def test_what_a_half_model_cannot_do():
    """A finger is cut along its middle: what turns it about an axis in that plane is not alike on
    both sides."""
    (plane, normal), *_ = (
        specs.loads(FINGER.format(first="{surface: tip, fix: [x]}", step="pressure: 1 kPa"))
        .geometry.layout()
        .symmetry.items()
    )
    across = ["1", "0", "0"] if normal != 0 else ["0", "1", "0"]
    moment = ", ".join(f"{c} N*mm" for c in across)
    said = fault(FINGER, "{surface: tip, fix: [x]}", f"torque: {{moment: [{moment}]}}")
    assert f"in the symmetry plane '{plane}'" in said and "torque.moment" in said
    turn = f"{{surface: tip, turn: {{axis: [{', '.join(across)}], angle: 3 deg}}}}"
    assert f"not normal to the symmetry plane '{plane}'" in fault(FINGER, turn)

"""Obstacles and contact in a spec: units, shapes, and one line for each fault."""

import numpy as np
import pytest

from softact import spec
from softact.contact.obstacles.block import Block
from softact.contact.obstacles.cylinder import Cylinder
from softact.contact.obstacles.plane import Plane
from softact.contact.obstacles.sphere import Sphere
from softact.errors import SpecError

TEXT = """\
geometry: {type: pneunet}
materials: {body: elastosil-m4601}
obstacles:
  table: {type: plane, point: [0 mm, 0 mm, -1 cm], normal: [0, 0, 2], friction: 0.3}
  cell:
    {type: block, center: [60 mm, 0 mm, -20 mm], size: [1 cm, 40 mm, 5 mm],
     rotation: [0 deg, 90 deg, 0 deg], load_cell: true}
  rod: {type: cylinder, center: [0 mm, 0 mm, 90 mm], axis: [0, 1, 0], radius: 4 mm, active: false}
  ball: {type: sphere, center: [0 mm, 0 mm, 90 mm], radius: 4 mm, surfaces: [tip]}
contact:
  - {self: outer, friction: 0.2}
  - {between: [tip, [outer, base]], distance: 0.1 mm}
steps:
  - {name: push, obstacles: {cell: {move: [0 mm, 0 mm, 3 mm]}, rod: {active: true}}}
"""


def load(text=TEXT):
    return spec.loads(text, "finger.yaml")


def test_obstacles_and_contact_are_read():
    """Lengths become mm; a block turned by 90° about y has its x and z edges exchanged."""
    read = load()
    shapes = {name: obstacle.shape() for name, obstacle in read.obstacles.items()}
    assert shapes["table"] == Plane((0.0, 0.0, -10.0), (0.0, 0.0, 2.0))
    assert shapes["ball"] == Sphere((0.0, 0.0, 90.0), 4.0)
    assert shapes["rod"] == Cylinder((0.0, 0.0, 90.0), (0.0, 1.0, 0.0), 4.0, None)
    assert isinstance(shapes["cell"], Block)
    beside = np.array([[60.0 + 2.6, 0, -20], [60.0, 0, -20 + 4.9]])
    np.testing.assert_allclose(shapes["cell"].distance(beside)[0], [0.1, -0.1], atol=1e-12)
    assert [c.groups for c in read.contact] == [(("outer",),), (("tip",), ("outer", "base"))]
    assert [c.name for c in read.contact] == ["contact_1", "contact_2"]
    assert read.steps[0].obstacles["cell"].move == (0.0, 0.0, 3.0)
    again = spec.loads(read.to_yaml(), "again.yaml")
    assert again == read and again.hash == read.hash


WRONG = {
    "friction: 0.3": ("friction: -0.3", "obstacles.table.friction: -0.3 is below zero"),
    "type: plane": ("type: plain", "obstacles.table.type: there is no obstacle 'plain'"),
    "normal: [0, 0, 2]": ("normal: [0, 0, 0]", "obstacles.table.normal: all three are zero"),
    "-1 cm": ("-1 kPa", "obstacles.table.point.2: "),
    "size: [1 cm": ("size: [0 mm", "obstacles.cell.size.0: "),
    "radius: 4 mm, active": ("radius: 0 mm, active", "obstacles.rod.radius: "),
    "surfaces: [tip]": ("surfaces: [tp]", "obstacles.ball.surfaces.0: the geometry has no surface"),
    "self: outer": ("self: outre", "contact.0.self: the geometry has no surface 'outre'"),
    "{self: outer, friction: 0.2}": ("{friction: 0.2}", "contact.0: write either self: outer"),
    "friction: 0.2": ("friction: -1", "contact.0.friction: -1 is below zero"),
    "[tip, [outer, base]]": ("[tip]", "contact.1.between"),
    "[outer, base]": ("[outer, bases]", "contact.1.between.1.1: the geometry has no surface"),
    "cell: {move:": ("cel: {move:", "steps.0.obstacles.cel: there is no obstacle 'cel'"),
    "rod: {active: true}": ("rod: {}", "steps.0.obstacles.rod: changes nothing"),
}


FREE = """\
geometry: {type: pneunet, symmetry: true}
materials: {body: {law: neo_hookean, c10: 0.1 MPa, density: 1000 kg/m^3}}
obstacles:
  table: {type: plane, point: [0 mm, 0 mm, -1 cm], normal: [0, 0, 1]}
  ball: {type: sphere, center: [0 mm, 0 mm, 90 mm], radius: 4 mm, mass: 50 g, held: true}
  bar: {type: cylinder, center: [0 mm, 0 mm, 90 mm], axis: [0, 1, 0], radius: 4 mm, length: 1 cm}
steps:
  - {name: go, obstacles: {ball: {held: false}, bar: {turn: {axis: [0, 2, 0], angle: 20 deg}}}}
"""

WRONG_FREE = {
    "mass: 50 g": ("mass: 0 g", "obstacles.ball.mass: "),
    "mass: 50 g, held": (
        "held",
        "obstacles.ball.held: all obstacles stay in place but free bodies",
    ),
    "normal: [0, 0, 1]": (
        "normal: [0, 0, 1], mass: 1 g",
        "obstacles.table.mass: a plane without end has no mass",
    ),
    "radius: 4 mm, length: 1 cm": (
        "radius: 4 mm, mass: 1 g",
        "obstacles.bar.mass: a cylinder without end has no mass",
    ),
    "held: true": ("active: false", "obstacles.ball.active: a free body is there from the start"),
    "{held: false}": (
        "{move: [1 mm, 0 mm, 0 mm]}",
        "steps.0.obstacles.ball.move: a free body goes where it is pushed",
    ),
    "bar: {turn": ("bar: {held: true, turn", "steps.0.obstacles.bar.held: it is no free body"),
    "axis: [0, 2, 0]": (
        "axis: [0, 0, 1]",
        "steps.0.obstacles.bar.turn.axis: an obstacle that turns about an axis that is not normal "
        "to the symmetry plane",
    ),
    "length: 1 cm": (
        "length: 1 cm, mass: 1 g}\n  cube: {type: mesh, file: nowhere.stl",
        "obstacles.cube.file: there is no file",
    ),
}


def test_free_bodies_are_read():
    """Masses become tonne; a turn is told by its axis, of length 1, and a point of it."""
    read = spec.loads(FREE, "ball.yaml")
    assert read.obstacles["ball"].mass == pytest.approx(50e-6) and read.obstacles["ball"].held
    assert read.obstacles["bar"].mass is None
    change = read.steps[0].obstacles
    assert change["ball"].held is False
    again = spec.loads(read.to_yaml(), "again.yaml")
    assert again == read and again.hash == read.hash


@pytest.mark.parametrize("part", WRONG_FREE)
def test_a_fault_of_a_free_body(part):
    """One line says where it is and what is wrong; steps may be at odds with it, too."""
    wrong, words = WRONG_FREE[part]
    assert FREE.count(part) == 1
    with pytest.raises(SpecError) as caught:
        spec.loads(FREE.replace(part, wrong), "ball.yaml")
    assert sum(words in line for line in caught.value.lines) == 1


def test_what_turns_unevenly_has_no_dynamics():
    """A bar resists turns about its axis less than others: its motion is refused, a ball's not."""
    moving = FREE.replace("name: go,", "name: go, duration: 1 s, dynamics: true,")
    spec.loads(moving, "ball.yaml")
    text = moving.replace("length: 1 cm}", "length: 1 cm, mass: 1 g}")
    text = text.replace(", bar: {turn: {axis: [0, 2, 0], angle: 20 deg}}", "")
    with pytest.raises(SpecError, match=r"obstacles.bar.mass: dynamics follows free bodies that"):
        spec.loads(text, "ball.yaml")


SHEETS = """\
geometry: {type: woven_elongating}
sheets:
  pouches: &nylon
    plies: [{material: {law: linear, youngs_modulus: 498 MPa, poissons_ratio: 0.35},
             thickness: 0.2 mm}]
  ends: *nylon
obstacles:
  plate: {type: plane, point: [60 mm, 0 mm, 0 mm], normal: [-1, 0, 0], surfaces: [ends]}
contact:
  - {self: pouches, friction: 0.3}
  - {between: [pouches, ends]}
steps:
  - {pressure: 100 kPa}
"""


def test_sheets_may_touch():
    """Obstacles and contact take names of sheets; a curve has no area that could touch."""
    read = spec.loads(SHEETS, "stack.yaml")
    assert read.obstacles["plate"].surfaces == ("ends",)
    assert [c.groups for c in read.contact] == [(("pouches",),), (("pouches",), ("ends",))]
    for old, new, place in (
        ("[ends]", "[tip]", "obstacles.plate.surfaces.0"),
        ("self: pouches", "self: seams", "contact.0.self"),
    ):
        with pytest.raises(SpecError) as caught:
            spec.loads(SHEETS.replace(old, new), "stack.yaml")
        (line,) = caught.value.lines
        assert place in line and "is a curve, which touches nothing; write one of: pouches" in line


@pytest.mark.parametrize("part", WRONG)
def test_a_fault_is_one_line(part):
    """Each says where it is and what is wrong."""
    wrong, words = WRONG[part]
    assert TEXT.count(part) == 1
    with pytest.raises(SpecError) as caught:
        load(TEXT.replace(part, wrong))
    assert len(caught.value.lines) == 1
    assert words in caught.value.lines[0]


SLIDING = """\
geometry: {type: shell_reinforced, shell: sliding}
materials: {body: ecoflex-00-30}
sheets:
  shell: &pet {plies: [{material: pet, thickness: 0.1 mm}], wrinkling: resolved, bending: 1}
  glued: *pet
contact: [{between: [outer, shell], distance: 0.005 mm}]
steps: [{name: inflate, pressure: 5 kPa}]
"""


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        (SLIDING.splitlines()[5] + "\n", "", "contact: missing; 'shell' lies on the solid"),
        (", distance: 0.005 mm", "", "contact.0.distance: missing; 'shell' lies on the solid"),
        ("  glued: *pet\n", "", "sheets.glued: missing; write what this sheet is made of"),
        ("materials: {body: ecoflex-00-30}\n", "", "materials: missing"),
    ],
)  # fmt: skip
def test_a_sheet_on_a_solid_is_held(right, wrong, said):
    """By contact with an interference: one line says what is missing."""
    assert load(SLIDING).sheets["shell"].bending == 1
    with pytest.raises(SpecError) as found:
        load(SLIDING.replace(right, wrong))
    (line,) = found.value.lines
    assert said in line


AUTO = """\
geometry: {type: pneunet, chambers: 2}
materials: {body: elastosil-m4601}
layers: [{surface: strain_limiting_layer, thickness: 0.1 mm, material: paper}]
contact: auto
steps: [{pressure: 10 kPa}]
"""


def test_auto_is_the_outside_with_itself():
    """Of a solid all outer surfaces, of a geometry of sheets alone all of them; what the resolved
    spec says may be read again; cavities under vacuum touch beside it."""
    read = spec.loads(AUTO, "finger.yaml")
    (contact,) = read.contact
    (surfaces,) = contact.groups
    assert contact.name == "outside" and {"outer", "base", "tip"} <= set(surfaces)
    assert not {"cavity", "symmetry"} & set(surfaces)
    alone = spec.loads(AUTO.replace("auto", "[{name: outside, self: outer}]"), "finger.yaml")
    assert alone.contact[0].groups == (("outer",),)  # what is written stays
    written = f"[{{name: outside, self: [{', '.join(surfaces)}]}}]"
    assert spec.loads(AUTO.replace("auto", written), "finger.yaml") == read
    drawn = spec.loads(AUTO.replace("10 kPa", "-10 kPa"), "finger.yaml")
    assert [c.name for c in drawn.contact] == ["outside", "cavity_walls"]
    stack = SHEETS.split("obstacles:")[0] + "contact: auto\nsteps: [{pressure: 100 kPa}]\n"
    groups = [c.groups for c in spec.loads(stack, "stack.yaml").contact]
    assert groups == [(("pouches", "ends"),)]


def test_another_word_is_one_line():
    with pytest.raises(SpecError) as caught:
        spec.loads(AUTO.replace("auto", "self"), "finger.yaml")
    assert any("write auto, none, or a list" in line for line in caught.value.lines)


def test_the_json_schema_knows_the_words():
    listed, words, _ = spec.json_schema()["properties"]["contact"]["anyOf"]
    assert listed["type"] == "array" and words == {"enum": ["auto", "none"]}

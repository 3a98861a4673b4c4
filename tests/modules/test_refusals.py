"""What a module cannot do is refused by name, in one line each."""

import pytest
from pydantic import ValidationError

from softact.errors import SpecError
from softact.geometries import GEOMETRIES
from softact.modules.module_spec import module_specs
from softact.spec import loads

FINGER = """
geometry: {type: pneunet, chambers: 3, mesh_size: 4 mm}
materials: {body: elastosil-m4601}
steps: [{name: inflate, pressure: 5 kPa}]
"""
ALONE = FINGER.replace("chambers: 3", "chambers: 3, module_alone: true")


@pytest.mark.parametrize(
    ("added", "line"),
    [
        (
            "contact: [{self: outer, friction: 0.3}]",
            "contact.0.friction: modules touch each other without friction",
        ),
        ("contact: [{self: [outer, left]}]", "contact.0.self.1: 'left' is a face of the module"),
        ("supports: [{surface: base, fix: [z]}]", "supports: a module is held by the means of"),
        ("constraints: [{surface: base, stays: rigid}]", "constraints: a face of a chain keeps no"),
        (
            "obstacles: {floor: {type: plane, point: [0 mm, 0 mm, -9 mm], normal: [0, 0, 1]}}",
            "obstacles: an obstacle touches some modules and not others",
        ),
        ("module: {left: left, right: left}", "module.right: is the left face too"),
        ("module: {left: left, right: wrong}", "module.right: the geometry has no surface 'wrong'"),
        (
            "module: {left: left, right: right, turn: {x: 1 deg}}",
            "module.turn.x: the symmetry planes leave no room for it",
        ),
        ("module: {left: left, right: right, shift: {w: 1 mm}}", "there is no component 'w'"),
    ],
)
def test_what_stands_beside_a_module_is_refused(added, line):
    with pytest.raises(SpecError) as refused:
        loads(f"{ALONE}{added}\n")
    assert len(refused.value.lines) == 1
    assert line in refused.value.lines[0]


@pytest.mark.parametrize(
    ("load", "line"),
    [
        ("gravity: [0, 0, -1]", "gravity: weight makes the modules of a chain unequal"),
        (
            "torque: {surface: right, moment: [0 N*mm, 1 N*mm, 0 N*mm]}",
            "torque: a torque acts on one place",
        ),
        (
            "payload: {surface: right, force: [0 N, 0 N, 1 N]}",
            "payload: a payload hangs on one place",
        ),
        ("wrench: {moment: [1 N*mm, 0 N*mm, 0 N*mm]}", "the symmetry planes leave no room for it"),
    ],
)
def test_loads_that_make_modules_unequal_are_refused(load, line):
    with pytest.raises(SpecError) as refused:
        loads(ALONE.replace("pressure: 5 kPa", load))
    assert len(refused.value.lines) == 1
    assert line in refused.value.lines[0]


def test_a_wrench_needs_a_module():
    with pytest.raises(SpecError, match="acts on a module of a chain"):
        loads(FINGER.replace("pressure: 5 kPa", "wrench: {force: [1 N, 0 N, 0 N]}"))


@pytest.mark.parametrize(
    ("geometry", "line"),
    [
        ("type: thick_sphere", "thick_sphere has no module that repeats"),
        ("type: bellows", "bellows has no module that repeats"),
        ("type: pneunet, chambers: 1", "chambers: one chamber is no chain"),
        ("type: omnidirectional, modules: 1", "modules: one module is no chain"),
        ("type: shell_reinforced, cuts: 1, kind: linear", "cuts: 1 rows of slits are no chain"),
    ],
)
def test_what_has_no_module_is_refused(geometry, line):
    spec = loads(
        f"geometry: {{{geometry}}}\nmaterials: {{body: elastosil-m4601}}\n"
        "supports: [{surface: outer, fix: [x, y, z]}]\n"
        "steps: [{name: press, surface_pressure: {outer: 1 kPa}}]\n"
    )
    with pytest.raises(SpecError, match=line):
        module_specs(spec, {})


@pytest.mark.parametrize(
    "geometry",
    [
        {"type": "omnidirectional", "modules": 1},
        {"type": "pneunet", "chambers": 1},
        {"type": "antagonistic", "chambers": 1},
        {"type": "woven_elongating", "n_a": 1},
        {"type": "woven_contracting", "n_a": 1},
        {"type": "knit_strips", "n_r": 1, "kind": "elongating"},
        {"type": "slow_pneunet", "chambers": 1},
        {"type": "shell_reinforced", "cuts": 1, "kind": "linear"},
    ],
)
def test_one_module_of_no_chain_is_refused_once(geometry):
    field = next(name for name in geometry if name != "type")
    kind = GEOMETRIES[geometry["type"]]
    with pytest.raises(ValidationError) as caught:
        kind.model_validate({**geometry, "module_alone": True})
    assert [(f["loc"], "no chain" in f["msg"]) for f in caught.value.errors()] == [((field,), True)]


def test_why_a_single_pouch_has_no_module_is_told():
    with pytest.raises(SpecError) as refused:
        GEOMETRIES["woven_stiffening"]().module()
    assert len(refused.value.lines) == 1
    why = "woven_stiffening has no module that repeats: it is one pouch"
    assert f"geometry.type: {why}" in refused.value.lines[0]


@pytest.mark.parametrize("kind", ["bending", "twisting"])
def test_knit_strips_have_a_module_where_they_elongate(kind):
    with pytest.raises(SpecError, match=f"geometry.kind: {kind} has no module that repeats yet"):
        GEOMETRIES["knit_strips"](kind=kind).module()


def test_sheets_are_refused():
    spec = """
geometry: {type: woven_stiffening}
module: {left: front, right: back}
sheets: {}
steps: [{name: inflate, pressure: 5 kPa}]
"""
    with pytest.raises(SpecError, match="module: two curves of sheets are no faces of a module"):
        loads(spec)


def test_weight_can_be_left_out():
    step = "[{name: gravity, gravity: [0, 0, -1]}, {name: inflate, pressure: 5 kPa}]"
    spec = loads(FINGER.replace("[{name: inflate, pressure: 5 kPa}]", step))
    with pytest.raises(SpecError, match="gravity: weight makes the modules"):
        module_specs(spec, {})
    runs = module_specs(spec, {}, weight=False).runs
    assert [step.name for step in runs["clamped"].steps] == ["inflate"]


def test_contact_is_that_of_inner_modules():
    """What the ends touch is none of a module's, and all of it can be left out."""
    contacts = "contact: [{self: [outer, tip]}, {name: ring, between: [clamp, tip]}]"
    free = module_specs(loads(f"{FINGER}{contacts}\n"), {}).runs["free"]
    assert [(c.name, c.groups) for c in free.contact] == [("contact_1", (("outer",),))]
    rubbing = loads(f"{FINGER}contact: [{{self: outer, friction: 0.3}}]\n")
    with pytest.raises(SpecError) as refused:
        module_specs(rubbing, {})
    assert len(refused.value.lines) == 1
    assert "--no-contact" in refused.value.lines[0]
    assert not module_specs(rubbing, {}, contact=False).runs["free"].contact


def test_components_are_held_by_name():
    spec = loads(FINGER)
    with pytest.raises(SpecError, match="--hold turn_w: did you mean 'turn_"):
        module_specs(spec, {"turn_w": "1 deg"})
    held = module_specs(spec, {"turn_y": "2 deg"}).runs["free"].layout().repeats
    assert held.hold == pytest.approx({"turn_y": 0.03490658503988659})

"""Values that look a unit wrong: warned of with their place, never refused; nothing said of what
people really build."""

import json
from pathlib import Path

import pytest

from softact.check import cases
from softact.cli.main import main
from softact.materials import CARDS, load_card
from softact.results.folder import read
from softact.run.start import run
from softact.spec import load, loads
from softact.spec.plausible import RANGES, lines, oddities

CONFIGS = Path(__file__).resolve().parents[2] / "configs"

CUBE = """\
geometry: {type: block, length: 10 mm, mesh_size: 10 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa, poissons_ratio: 0.49}}
layers: [{surface: x_max, thickness: 0.1 mm, material: paper}]
supports: [{surface: x_min, fix: [x, y, z]}, {surface: x_max, move: {x: 1 mm}}]
obstacles: {floor: {type: sphere, center: [0 mm, 0 mm, -99 mm], radius: 9 mm, friction: 0.3}}
contact: [{self: y_max, distance: 0.01 mm}]
steps:
  - {traction: {surface: y_min, value: [10 kPa, 0 kPa, 0 kPa]}, gravity: [0, 0, -1]}
"""
FINGER = """\
geometry: {type: pneunet, mesh_size: 4 mm}
materials: {body: elastosil-m4601}
steps: [{pressure: 20 kPa}]
"""
FABRIC = """\
geometry: {type: woven_contracting}
sheets:
  pouches: {plies: [{material: woven-tpu-nylon, thickness: 0.2 mm}]}
  tabs: {plies: [{material: woven-tpu-nylon, thickness: 0.2 mm}]}
steps: [{pressure: 20 kPa}]
"""
BODY = "{law: neo_hookean, c10: 0.1 MPa, poissons_ratio: 0.49}"


@pytest.mark.parametrize("path", sorted(CONFIGS.glob("*.yaml")), ids=lambda path: path.stem)
def test_nothing_is_said_of_what_has_been_built(path):
    assert lines(load(path)) == []


@pytest.mark.parametrize("path", sorted(CONFIGS.glob("reference/*.yaml")), ids=lambda p: p.stem)
def test_nothing_is_said_of_a_reference_case(path):
    assert lines(cases.read(path).spec) == []


@pytest.mark.parametrize("card", CARDS)
def test_nothing_is_said_of_a_card(card):
    assert lines(loads(CUBE.replace(BODY, card))) == []
    fabric = FABRIC.replace("woven-tpu-nylon", card)
    if load_card(card).remembers:
        fabric = fabric.replace("{material:", "{incompressible: true, material:")
        fabric = fabric.replace("{plies:", "{wrinkling: resolved, plies:")
    assert lines(loads(fabric)) == []


@pytest.mark.parametrize("text", [CUBE, FINGER, FABRIC])
def test_nothing_is_said_of_the_specs_that_are_changed_below(text):
    assert lines(loads(text)) == []


# kind of value: spec, what is changed in it, place, words
ODD = {
    "rubber": (
        CUBE,
        "materials.body.c10=110 GPa",
        "materials.body",
        "220 GPa is above what is usual for",
    ),
    "rubber, kPa for MPa": (
        CUBE,
        "materials.body.c10=0.1 kPa",
        "materials.body",
        "1000 times larger it",
    ),
    "rubber_poisson": (
        CUBE,
        "materials.body.poissons_ratio=-0.65",
        "materials.body",
        "ratio of -0.65 is",
    ),
    "rubber_poisson of K": (
        # (3K - 2G) / (6K + 2G) with G = 0.2 MPa and K = 0.2 MPa is 1/8
        CUBE,
        "materials.body={law: neo_hookean, c10: 0.1 MPa, bulk_modulus: 0.2 MPa}",
        "materials.body",
        "ratio of 0.125 is",
    ),
    "density": (
        CUBE,
        "materials.body.density=1070 g/cm^3",
        "materials.body.density",
        "1000 times smaller",
    ),
    "strength": (CUBE, "materials.body.strength=3 Pa", "materials.body.strength", "3 Pa is below"),
    "solid": (
        CUBE,
        "materials.body={law: linear, youngs_modulus: 1 Pa, poissons_ratio: 0.3}",
        "materials.body.youngs_modulus",
        "1 Pa is below what is usual for solids",
    ),
    "softest": (
        CUBE,
        "materials.body={law: linear, youngs_modulus: 110 GPa, poissons_ratio: 0.35}",
        "materials",
        "a shear modulus of 40.74 GPa is above",  # E / 2 (1 + nu)
    ),
    "fibres": (
        CUBE,
        "materials.body={law: holzapfel, c10: 0.1 MPa, k1: 500 GPa, normal: [0, 0, 1]}",
        "materials.body.k1",
        "500 GPa is above",
    ),
    "length": (CUBE, "geometry.length=0.04 mm", "geometry.length", "the length 40 um is below"),
    "size": (CUBE, "geometry.width=0.001 mm", "geometry.width", "1 um is below"),
    "wall": (FINGER, "geometry.roof=0.001 mm", "geometry.roof", "1000 times larger it"),
    "film": (CUBE, "layers.0.thickness=0.1 m", "layers.0.thickness", "100 mm is above"),
    "film of a fabric": (
        FABRIC,
        "sheets.pouches.plies=[{material: pet, thickness: 1 nm}]",
        "sheets.pouches.plies.0.thickness",
        "0.001 um is below",
    ),
    "sheet": (
        CUBE,
        "layers.0.material={law: linear, youngs_modulus: 6.5 kPa, poissons_ratio: 0.2}",
        "layers.0.material",
        "a Young's modulus of 6.5 kPa is below",
    ),
    "poisson": (
        CUBE,
        "layers.0.material={law: linear, youngs_modulus: 6 GPa, poissons_ratio: -0.2}",
        "layers.0.material",
        "a Poisson's ratio of -0.2 is below",
    ),
    "pressure": (FINGER, "steps.0.pressure=20 mPa", "steps.0.pressure.cavity", "a million times"),
    "pressure of a surface": (
        CUBE,
        "steps.0={surface_pressure: {y_max: 20 GPa}}",
        "steps.0.surface_pressure.y_max",
        "20 GPa is above",
    ),
    "vacuum": (FINGER, "steps.0.pressure=-200 kPa", "steps.0.pressure.cavity", "for a vacuum"),
    "traction": (CUBE, "steps.0.traction.value=[1 TPa, 0 Pa, 0 Pa]", "steps.0.traction", "above"),
    "force": (
        CUBE,
        "steps.0.payload={surface: z_max, force: [0 N, 3 MN, 4 MN]}",
        "steps.0.payload",
        "5000 kN is above",
    ),
    "volume": (FINGER, "steps.0={inject: 2 km^3}", "steps.0.inject.cavity", "is above"),
    "gravity": (
        CUBE,
        "steps.0.gravity=[0 m/s^2, 0 m/s^2, -9.81 mm/s^2]",
        "steps.0.gravity",
        "9.81 mm/s^2 is below what is usual for accelerations",
    ),
    "moment": (
        CUBE,
        "steps.0.torque={surface: z_max, moment: [0 N*mm, 3 MN*m, 0 N*mm]}",
        "steps.0.torque",
        "above",
    ),
    "spring": (
        CUBE,
        "supports.1={surface: z_max, spring: {x: 1e-9 N/mm}}",
        "supports.1.spring.x",
        "below",
    ),
    "motion": (
        CUBE,
        "supports.1.move.x=2 Mm",
        "supports.1.move.x",
        "a million times smaller",
    ),
    "motion of an obstacle": (
        CUBE,
        "steps.0.obstacles={floor: {move: [0 mm, 0 mm, 9 km]}}",
        "steps.0.obstacles.floor.move.2",
        "is above",
    ),
    "friction": (CUBE, "obstacles.floor.friction=5", "obstacles.floor.friction", "5 is above"),
    "friction of surfaces": (CUBE, "contact.0.friction=4", "contact.0.friction", "4 is above"),
    "distance": (CUBE, "contact.0.distance=1 m", "contact.0.distance", "1 m is above"),
    "place": (
        CUBE,
        "obstacles.floor.center=[0 mm, 0 mm, -99 m]",
        "obstacles.floor.center.2",
        "99 m is above what is usual for where obstacles are",
    ),
    "obstacle": (CUBE, "obstacles.floor.radius=9 nm", "obstacles.floor.radius", "is below"),
}


@pytest.mark.parametrize("case", ODD)
def test_a_value_that_looks_a_unit_wrong_is_warned_of(case):
    text, change, place, words = ODD[case]
    found = lines(loads(text, overrides=[change]))
    assert [line for line in found if line.startswith(f"{place}: ") and words in line], found


@pytest.mark.parametrize(
    "given, said",
    [(", bulk_modulus: 100 MPa", "bulk_modulus: 50000 MPa, or none of bulk_modulus, poissons_r"),
     (", bulk_modulus: 6000 MPa", ""), ("", "")],
)  # fmt: skip
def test_a_bulk_modulus_that_is_small_beside_the_fibres(given, said):
    """With a hundredth of the fibres' stiffness a tube's volume grows by percents, see
    tests/analytic/test_fibres.py; the default follows the fibres."""
    law = (
        f"{{law: holzapfel, c10: 0.05 MPa, k1: 5000 MPa, angle: 25 deg, normal: [0, 0, 1]{given}}}"
    )
    found = lines(loads(CUBE, overrides=[f"materials.body={law}"]))
    assert [said in line for line in found if "bulk modulus K" in line] == ([True] if said else [])


@pytest.mark.parametrize("ratio, warned", [(0.45, True), (0.4801, False), (0.499, False)])
def test_a_rubber_whose_volume_is_not_kept(ratio, warned):
    """A shear modulus of 0.2 MPa: K is 1.93 MPa at ν = 0.45, and 200 MPa keep the volume."""
    found = lines(loads(CUBE, overrides=[f"materials.body.poissons_ratio={ratio}"]))
    assert len(found) == warned
    assert not warned or "K of 1.933 MPa, 9.67 times" in found[0]
    assert not warned or "bulk_modulus: 200 MPa keeps the volume" in found[0]


def test_every_range_has_its_case_its_evidence_and_an_order():
    assert set(RANGES) == {case.split(",")[0].split(" of ")[0] for case in ODD}
    for limits in RANGES.values():
        assert limits.evidence
        assert limits.low < limits.high
        assert limits.oddity(limits.low) is None
        assert limits.oddity(limits.high) is None
        assert limits.oddity(1.001 * limits.high)


def test_places_are_those_of_the_spec():
    odd = loads(CUBE, overrides=["materials.body.c10=110 GPa"])
    assert [place for place, _ in oddities(odd)] == [("materials", "body")]


def test_validate_warns_with_file_and_line_and_refuses_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("cube.yaml").write_text(CUBE)
    options = ["--set", "geometry.length=0.04 mm", "--set", "materials.body.poissons_ratio=-0.65"]
    with pytest.raises(SystemExit) as left:
        main(["validate", "cube.yaml", *options])
    assert left.value.code == 0
    out, err = capsys.readouterr()
    assert out == "cube.yaml: ok, 2 warnings\n"
    first, second = err.splitlines()
    assert first.startswith("warning: --set geometry.length=0.04 mm: geometry.length: the length")
    assert second.startswith("warning: cube.yaml:2: materials.body: a Poisson's ratio of -0.65")


def test_a_run_tells_of_it_first_and_keeps_it_in_its_results(tmp_path):
    text = """\
geometry: {type: block, mesh_size: 10 mm}
materials: {body: {law: neo_hookean, c10: 110 GPa}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps: [{traction: {surface: x_max, value: [10 kPa, 0 kPa, 0 kPa]}, max_increment: 1}]
measures: [elongation]
"""
    spec = loads(text)
    (warning,) = lines(spec)
    events = []
    run(spec, tmp_path / "out", progress=events.append)
    assert events[0] == {"stage": "note", "text": warning}
    assert (tmp_path / "out" / "log.txt").read_text(encoding="utf-8").startswith(warning)
    assert warning in read(tmp_path / "out").run["messages"]
    assert warning in json.loads((tmp_path / "out" / "run.json").read_text())["messages"]
    assert warning in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")

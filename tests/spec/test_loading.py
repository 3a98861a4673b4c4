"""Files that a spec names: found from the file that names them, by every command alike."""

import json
from pathlib import Path

import pytest

from softact import spec as specs
from softact.check import cases
from softact.cli.main import main
from softact.errors import MeshError, SpecError
from softact.files import document
from softact.spec import opened, part, spec_at
from softact.sweep.points import changes_of
from softact.sweep.spec import Sweep, read

RUBBER = "law: neo_hookean\nc10: 0.2 MPa\npoissons_ratio: 0.45\n"
FILM = "law: linear\nyoungs_modulus: 200 MPa\npoissons_ratio: 0.3\n"
MESH = "def build(gmsh):\n    raise SystemExit('meshed')\n"
SOLID = """\
geometry: {type: from_script, file: shapes/box.py, surfaces: [side]}
materials: {body: {card: cards/rubber.yaml, density: 1 g/cm^3}}
layers: [{surface: side, thickness: 0.1 mm, material: cards/film.yaml}]
steps: [{name: hang, gravity: [0, 0, -1]}]
"""
CLOTH = """\
geometry: {type: woven_contracting}
sheets:
  pouches: {plies: [{material: cards/film.yaml, thickness: 0.2 mm},
                    {material: {card: ./cards/rubber.yaml}, thickness: 0.1 mm}]}
  tabs: {plies: [{material: cards/film.yaml, thickness: 0.2 mm}]}
steps: [{pressure: 10 kPa}]
"""
CASE = "description: x\nspec: {}\nvalues: [{{measure: elongation_mm, value: 0, tolerance: 1, kind: \
exact, source: me}}]\n"
SWEEP = "base: {}\naxes: [{{path: materials.body.c10, values: [0.1 MPa, 0.3 MPa]}}]\n"
OPTIMISE = "base: {}\nparameters: [{{path: materials.body.c10, from: 0.1 MPa, to: 0.3 MPa}}]\n\
objectives: [{{measure: elongation_mm, goal: maximise}}]\ntrials: 1\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """parts/ holds specs and what they name, studies/ what names a spec; elsewhere one works."""
    files = {
        "parts/cards/rubber.yaml": RUBBER,
        "parts/cards/film.yaml": FILM,
        "parts/shapes/box.py": MESH,
        "parts/solid.yaml": SOLID,
        "parts/cloth.yaml": CLOTH,
        "studies/sweep.yaml": SWEEP.format("../parts/solid.yaml"),
        "studies/optimise.yaml": OPTIMISE.format("../parts/solid.yaml"),
        "studies/case.yaml": CASE.format("../parts/solid.yaml"),
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    return tmp_path


def leave(*arguments):
    with pytest.raises(SystemExit) as left:
        main([str(argument) for argument in arguments])
    return left.value.code


def test_own_cards_stand_wherever_a_material_may(folder):
    solid = specs.load(folder / "parts/solid.yaml")
    assert (solid.materials["body"].c10, solid.materials["body"].density) == (0.2, 1e-9)
    layer = solid.layers[0].material
    assert (layer.youngs_modulus, layer.name) == (200, "film")
    pouches = specs.load(folder / "parts/cloth.yaml").sheets["pouches"]
    assert [ply.material.law for ply in pouches.plies] == ["linear", "neo_hookean"]


def test_a_constant_of_an_own_card_is_set_in_a_ply(folder):
    path = "sheets.pouches.plies.0.material"
    cloth = folder / "parts/cloth.yaml"
    spec = specs.load(cloth, [f"{path}.youngs_modulus=1 GPa"])
    assert spec.sheets["pouches"].plies[0].material.youngs_modulus == 1000
    assert spec.sheets["pouches"].plies[0].material.poissons_ratio == 0.3
    spec = specs.load(cloth, [f"{path}=cards/rubber.yaml", f"{path}.bulk_modulus=9 MPa"])
    material = spec.sheets["pouches"].plies[0].material
    assert (material.bulk_modulus, material.poissons_ratio) == (9.0, None)


@pytest.mark.parametrize("name", ["solid", "cloth"])
def test_the_resolved_spec_finds_its_files_from_anywhere(name, folder, monkeypatch):
    spec = specs.load(folder / "parts" / f"{name}.yaml")
    monkeypatch.chdir("/")
    assert specs.loads(spec.to_yaml()) == spec


def test_relative_paths_of_the_command_line_count_from_its_folder(folder, monkeypatch):
    monkeypatch.chdir(folder / "parts")
    spec = specs.load("solid.yaml")
    assert spec.geometry.file == str(folder / "parts/shapes/box.py")


COMMANDS = {
    "run": ("run", "{parts}/solid.yaml", "-o", "out"),
    "sweep": ("sweep", "{studies}/sweep.yaml", "-o", "out", "-j", "1"),
    "optimize": ("optimize", "{studies}/optimise.yaml", "-o", "out", "-j", "1"),
    "check": ("check", "{studies}/case.yaml", "-j", "1"),
    "converge": ("converge", "{parts}/solid.yaml", "-o", "out", "-m", "mass_g", "-j", "1"),
    "calibrate": ("calibrate", "{parts}/solid.yaml", "--data", "data.csv", "--vary",
                  "materials.body.c10", "-o", "out"),
    "mesh": ("mesh", "{parts}/solid.yaml", "-o", "out.msh"),
}  # fmt: skip


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_finds_what_a_base_spec_names(command, folder, monkeypatch):
    """The spec that comes to the solver, or to gmsh, is the same for all."""
    seen = []

    def record(spec, *others, **options):
        seen.append(spec)
        raise MeshError("seen")

    for place in ("softact.run.start.run", "softact.sweep.compute.run", "softact.check.compare.run",
                  "softact.geometry.base.export"):  # fmt: skip
        monkeypatch.setattr(place, record)
    monkeypatch.setattr("softact.converge.study._check", lambda spec, measures: None)
    Path("data.csv").write_text("step_fraction,elongation_mm\n0.5,1\n1,2\n")
    words = {"parts": folder / "parts", "studies": folder / "studies"}
    leave(*(word.format(**words) for word in COMMANDS[command]))
    geometry = seen[0] if command == "mesh" else seen[0].geometry
    assert geometry.file == str(folder / "parts/shapes/box.py")
    if command != "mesh":
        assert seen[0].layers[0].material.name == "film"
        assert seen[0].materials["body"].poissons_ratio == 0.45


def test_what_a_study_sets_counts_from_the_study(folder):
    (folder / "studies/soft.yaml").write_text(RUBBER.replace("0.2", "0.02"))
    (folder / "studies/sweep.yaml").write_text(
        "base: ../parts/solid.yaml\nset: {layers.0.material: film.yaml}\n"
        "axes: [{path: materials.body, values: [./soft.yaml, ecoflex-00-30]}]\n"
    )
    (folder / "studies/film.yaml").write_text(FILM.replace("200", "300"))
    study, base = read(folder / "studies/sweep.yaml", Sweep)
    soft, ecoflex = study.design.points(study.axes)
    spec = spec_at(base, changes_of(study.axes, soft))
    assert spec.materials["body"].c10 == 0.02
    assert spec.layers[0].material.youngs_modulus == 300
    assert spec.geometry.file == str(folder / "parts/shapes/box.py")
    assert spec_at(base, changes_of(study.axes, ecoflex)).materials["body"].law == "ogden"


def test_a_spec_inside_a_study_counts_from_the_study_and_keeps_its_lines(folder):
    text = "base:\n" + "".join(f"  {line}\n" for line in SOLID.splitlines())
    (folder / "parts/sweep.yaml").write_text(text.replace("0.1 mm", "0.1 kPa") + "axes: []\n")
    base = part(document.read(folder / "parts/sweep.yaml"), "base", "study")
    with pytest.raises(SpecError) as caught:
        spec_at(base)
    (line,) = caught.value.lines
    assert line.startswith(f"{folder / 'parts/sweep.yaml'}:4: layers.0.thickness: '0.1 kPa' is a")


def test_a_document_is_not_changed_by_what_is_made_of_it(folder):
    base = opened(folder / "parts/solid.yaml")
    before = json.dumps(base.data)
    first = spec_at(base, (("materials.body.c10", "0.3 MPa"),))
    assert json.dumps(base.data) == before
    assert spec_at(base) != first


def test_a_case_is_stored_as_it_was_written(folder):
    case = cases.read(folder / "studies/case.yaml")
    assert case.source.data["spec"] == "../parts/solid.yaml"


WRONG = {
    "no such base": (SWEEP.format("../parts/nothing.yaml"), "sweep.yaml:1: base: ", "no such file"),
    "base of another kind": (
        SWEEP.format("../parts/cards/film.yaml"),
        "sweep.yaml:1: base: ",
        "this is a material card, where a spec is wanted",
    ),
    "base that is no YAML": (SWEEP.format("../parts/bad.yaml"), "sweep.yaml:1: base: ", ":1: "),
}


@pytest.mark.parametrize("case", WRONG)
@pytest.mark.parametrize("command", ["sweep", "validate"])
def test_a_base_that_cannot_be_read_is_told_with_both_files(case, command, folder, capsys):
    text, start, words = WRONG[case]
    (folder / "parts/bad.yaml").write_text("a: [\n")
    (folder / "studies/sweep.yaml").write_text(text)
    assert leave(command, "../studies/sweep.yaml") == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"../studies/{start}") and words in line
    assert not list(Path().iterdir())


def test_faults_of_cards_and_of_the_spec_are_told_at_once(folder):
    (folder / "parts/cards/rubber.yaml").write_text("law: neo_hookean\nc10: 0.2\n")
    (folder / "parts/solid.yaml").write_text(SOLID.replace("0.1 mm", "0.1 kPa"))
    with pytest.raises(SpecError) as caught:
        specs.load(folder / "parts/solid.yaml")
    card, layer = caught.value.lines
    assert "solid.yaml:2: materials.body.card: " in card and "rubber.yaml:2: c10: '0.2' has" in card
    assert "solid.yaml:3: layers.0.thickness: '0.1 kPa' is a pressure" in layer


@pytest.mark.parametrize("name", ["~nobody/x.yaml", "a\\x00.yaml", "x" * 5000 + ".yaml"])
def test_names_that_no_file_can_have_are_told(name, folder):
    for text in (SOLID.replace("cards/film.yaml", f'"{name}"'),
                 SOLID.replace("shapes/box.py", f'"{name[:-5]}.py"')):  # fmt: skip
        (folder / "parts/solid.yaml").write_text(text)
        with pytest.raises(SpecError) as caught:
            specs.load(folder / "parts/solid.yaml")
        assert len(caught.value.lines) == 1


def test_an_optimisation_whose_base_is_wrong_ends_before_anything_runs(folder, capsys):
    solid = folder / "parts/solid.yaml"
    solid.write_text(SOLID.replace("0.1 mm", "0.1 kPa"))
    assert leave("optimize", "../studies/optimise.yaml", "-o", "out") == 2
    err = capsys.readouterr().err
    assert "solid.yaml:3: layers.0.thickness: '0.1 kPa' is a pressure" in err
    assert not list(Path().iterdir())

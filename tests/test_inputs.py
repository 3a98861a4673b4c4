"""Every YAML file is checked as what it is, and a command that wants another says so."""

from pathlib import Path

import pytest
import yaml

from softact import spec as specs
from softact.check.cases import CaseFile
from softact.cli.main import main
from softact.cli.schema import KINDS as WITH_SCHEMA
from softact.fit.sheet import TestList
from softact.inputs import schema, validate
from softact.materials import CARDS, LAWS, Law
from softact.optimise.spec import Optimisation
from softact.report.targets_file import TargetsFile
from softact.spec.kinds import KINDS, kind_of, read_any
from softact.spec.models import Spec
from softact.sweep.spec import Sweep

ROOT = Path(__file__).parents[1]
SPEC = """\
geometry: {type: block, length: 4 mm}
materials: {body: ecoflex-00-30}
steps: [{gravity: [0, 0, -1]}]
"""
FILES = {
    "spec": SPEC,
    "sweep": "base: spec.yaml\naxes: [{path: geometry.length, values: [4 mm, 5 mm]}]\n",
    "optimise": "base: spec.yaml\nparameters: [{path: geometry.length, from: 4 mm, to: 5 mm}]\n"
    "objectives: [{measure: elongation_mm, goal: maximise}]\n",
    "case": "description: x\nspec: spec.yaml\nvalues: [{measure: elongation_mm, value: 0, "
    "tolerance: 1, kind: exact, source: me}]\n",
    "card": "law: neo_hookean\nc10: 0.1 MPa\n",
    "tests": "tests: [{file: test.csv}]\n",
    "targets": "sources: {me: {short: me, full: me}}\ntargets:\n  lift: {title: Lift, "
    "requirements: [{source: me, text: 2 N, figure: blocked_force_N, at_least: 2 N}]}\n",
    "figures": "sources: [{name: x}]\n",
}
DONE = {  # kind -> command for which it is made
    "spec": "run", "sweep": "sweep", "optimise": "optimize", "case": "check", "tests": "fit",
}  # fmt: skip


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for kind, text in FILES.items():
        Path(f"{kind}.yaml").write_text(text)
    rows = "".join(f"{1 + 0.1 * i:g},{0.1 * i:g}\n" for i in range(12))
    Path("test.csv").write_text(f"stretch,nominal_stress MPa\n{rows}")
    return tmp_path


def leave(capsys, *arguments):
    with pytest.raises(SystemExit) as left:
        main(arguments)
    out, err = capsys.readouterr()
    return left.value.code, out.splitlines(), err.splitlines()


@pytest.mark.parametrize("kind", [kind for kind in FILES if kind != "figures"])
def test_a_file_is_validated_as_what_it_is(kind, folder, capsys):
    code, out, err = leave(capsys, "validate", f"{kind}.yaml")
    called = "" if kind == "spec" else f", {KINDS[kind].called}"
    assert (code, out, err) == (0, [f"{kind}.yaml: ok{called}"], [])


def test_published_figures_are_read_elsewhere(folder, capsys):
    code, _, err = leave(capsys, "validate", "figures.yaml")
    assert code == 2
    assert err == [
        "figures.yaml: this is a file of published figures; docs/validation_table.py reads it and "
        "says what is wrong in it"
    ]


FAULTS = {
    "sweep": (
        "base: spec.yaml\naxes:\n  - {path: geometry.lenght, values: [4 mm]}\n"
        "  - {path: materials.body.mu1, values: [3 mm]}\nset: {steps.4.gravity: [0, 0, 1]}\n",
        [":5: set.steps.4.gravity: 'steps' has no entry '4'",
         ":3: axes.0.path: 'geometry.lenght': geometry has no 'lenght'; did you mean 'length'?"],
    ),
    "sweep of wrong values": (
        "base: spec.yaml\nset:\n  geometry.length: 0 mm\naxes: [{path: geometry.width, "
        "values: [4 mm]}]\n",
        [":3: geometry.length: at 0 mm the length would vanish"],
    ),
    "sweep with faults": (
        "base: spec.yaml\naxes: [{pat: x, values: [1]}]\ndesign: {kind: gird}\n",
        [":2: axes.0.path: missing", ":2: axes.0.pat: unknown key; did you mean 'path'?",
         ":3: design.kind: 'gird' is not one of: grid, "],
    ),
    "sweep's unknown key": (
        "base: spec.yaml\naxes: [{path: geometry.length, fro: 1 mm, to: 2 mm}]\n",
        [":2: axes.0.fro: unknown key; did you mean 'from'?"],
    ),
    "optimisation of nothing": (
        "base: spec.yaml\nobjectives: []\nparameters: []\ntrails: 3\n",
        [":4: trails: unknown key; did you mean 'trials'?"],
    ),
    "case": (
        "description: x\nspec: {geometry: {type: blok}, steps: []}\nvalue: []\n",
        [":1: values: missing", ":3: value: unknown key; did you mean 'values'?"],
    ),
    "case with a wrong spec": (
        FILES["case"].replace("spec: spec.yaml", "spec:\n  geometry: {type: blok}\n  steps: []"),
        [":2: materials: missing", ":3: geometry.type: there is no geometry 'blok'; did you mean",
         ":4: steps: no step is given"],
    ),
    "card": ("law: neo_hookean\nc1: 0.1 MPa\n", [":1: c10: missing", ":2: c1: unknown key; did"]),
    "tests": (
        "tests:\n  - {file: nothing.csv}\n  - {fil: test.csv, mode: planer}\n",
        [":3: tests.1.file: missing", ":3: tests.1.mode: 'planer' is not one of: uniaxial",
         ":3: tests.1.fil: unknown key; did you mean 'file'?"],
    ),
    "data that is not there": ("tests: [{file: no.csv}]\n", ["no.csv: there is no such file"]),
    "targets": (
        FILES["targets"].replace("source: me", "source: you").replace("2 N}", "2 mm}"),
        [":3: targets.lift.requirements.0: '2 mm' is no value of 'blocked_force_N': "],
    ),
    "figure of targets": (
        FILES["targets"].replace("blocked_force_N", "."),
        [":3: targets.lift.requirements.0: '2 N' is no value of '.': its name ends with no unit"],
    ),
    "source of targets": (
        FILES["targets"].replace("source: me", "source: you"),
        [":3: targets.lift.requirements.0.source: no source 'you'; known: me"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", FAULTS)
def test_all_faults_of_a_file_are_told_with_their_lines(case, folder, capsys):
    text, expected = FAULTS[case]
    Path("wrong.yaml").write_text(text)
    code, out, err = leave(capsys, "validate", "wrong.yaml")
    assert (code, out, len(err)) == (2, [], len(expected)), err
    for words in expected:
        assert any(line.startswith(("wrong.yaml", "no.csv")) and words in line for line in err), err


WANTED = {
    ("run",): "spec", ("mesh",): "spec", ("converge",): "spec",
    ("calibrate", "--data", "test.csv", "--vary", "x"): "spec", ("sweep",): "sweep",
    ("optimize",): "optimise", ("check",): "case", ("fit",): "tests",
}  # fmt: skip
CROSSWISE = [(command, kind) for command in WANTED for kind in FILES if kind != WANTED[command]]


@pytest.mark.parametrize(("command", "kind"), CROSSWISE)
def test_a_command_that_wants_another_file_says_what_it_was_given(command, kind, folder, capsys):
    before = sorted(folder.rglob("*"))
    code, out, err = leave(capsys, command[0], f"{kind}.yaml", *command[1:])
    assert (code, out) == (2, [])
    (line,) = err
    assert line.startswith(f"{kind}.yaml: this is {KINDS[kind].called}, where ")
    assert f"{KINDS[WANTED[command]].called} is wanted" in line
    if kind in DONE:
        assert line.endswith(f"softact {DONE[kind]} {kind}.yaml")
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize("command", ["report", "compare"])
def test_a_spec_is_no_result_folder(command, folder, capsys):
    code, _, err = leave(capsys, command, "spec.yaml", *(["sweep.yaml"] * (command == "compare")))
    assert code == 2
    words = "this is a spec, where a result folder is wanted; to solve it: softact run spec.yaml"
    assert err[0] == f"spec.yaml: {words}"


def test_a_result_folder_is_no_spec(folder, capsys):
    Path("out").mkdir()
    Path("out/run.json").write_text("{}")
    Path("out/spec.yaml").write_text(SPEC)
    code, _, err = leave(capsys, "run", "out")
    assert code == 2
    assert err == [
        "out: this is a result folder, where a spec is wanted; the spec of its run is out/spec.yaml"
    ]


def test_a_file_in_place_of_a_command_is_told_its_command(folder, capsys):
    code, _, err = leave(capsys, "sweep.yaml")
    assert code == 2
    assert "sweep.yaml is a sweep; to compute it: softact sweep sweep.yaml" in " ".join(err)


def test_values_are_replaced_in_specs_only(folder, capsys):
    code, _, err = leave(capsys, "validate", "sweep.yaml", "--set", "geometry.length=3 mm")
    assert (code, err) == (2, ["sweep.yaml: this is a sweep; --set replaces values of a spec"])


def test_a_file_of_mixed_keys_is_of_the_wanted_kind(folder):
    """A spec with a key of a sweep is a spec with a fault, and told as such by every command."""
    Path("mixed.yaml").write_text(f"{SPEC}axes: []\n")
    assert kind_of(read_any(Path("mixed.yaml"))) == "spec"
    assert kind_of(read_any(Path("mixed.yaml")), "sweep") == "sweep"


OPTIMISED = ("_optimise", "_gradient", "flexed_index_finger")  # ends of names in configs/sweeps


def test_every_file_of_the_repository_is_told_for_what_it_is():
    folders = {"": "spec", "reference": "case", "sweeps": "sweep"}
    for folder, kind in folders.items():
        for path in (ROOT / "configs" / folder).glob("*.yaml"):
            optimised = folder == "sweeps" and path.stem.endswith(OPTIMISED)
            wanted = "optimise" if optimised else kind
            assert kind_of(read_any(path)) == wanted, path
    cards = (ROOT / "softact" / "cards").glob("*.yaml")
    assert {kind_of(read_any(path)) for path in cards} == {"card"}
    assert validate(ROOT / "softact/report/targets.yaml").called == KINDS["targets"].called
    assert kind_of(read_any(ROOT / "docs/published/figures.yaml")) == "figures"


def test_the_keys_by_which_files_are_told_are_keys_of_their_models():
    common = {"name", "description", "source"}
    models = {"spec": Spec, "sweep": Sweep, "optimise": Optimisation, "case": CaseFile,
              "tests": TestList, "targets": TargetsFile}  # fmt: skip
    for kind, model in models.items():
        assert KINDS[kind].keys == set(model.model_fields) - common, kind
    assert KINDS["card"].keys - {"law"} <= set(Law.model_fields) - common


@pytest.mark.parametrize("kind", WITH_SCHEMA)
def test_a_schema_names_every_key_of_its_kind(kind):
    found = schema(kind)
    if kind == "card":
        laws = {found["$defs"][ref["$ref"].split("/")[-1]]["properties"]["law"]["const"]
                for ref in found["oneOf"]}  # fmt: skip
        assert laws == set(LAWS)
    else:
        assert set(found["properties"]) >= KINDS[kind].keys


def test_a_schema_knows_a_spec_inside_and_short_forms():
    inside = schema("case")["properties"]["spec"]["anyOf"]
    assert inside == [{"type": "string"}, {"$ref": "#/$defs/Spec"}]
    assert schema("case")["$defs"]["Spec"]["properties"]["steps"]["type"] == "array"
    sweep = schema("sweep")
    assert {"type": "string"} in sweep["$defs"]["Axis"]["properties"]["path"]["anyOf"]
    assert "grid" in sweep["properties"]["design"]["anyOf"][0]["enum"]
    assert "from" in sweep["$defs"]["Axis"]["properties"]


def test_a_schema_is_written_for_a_kind(folder, capsys):
    code, out, _ = leave(capsys, "schema", "--kind", "sweep", "-o", "sweep.schema.json")
    assert (code, out) == (0, ["wrote sweep.schema.json"])
    assert yaml.safe_load(Path("sweep.schema.json").read_text())["title"] == "Sweep"


def test_a_card_of_the_library_is_a_card_of_ones_own(folder):
    for name in CARDS:
        path = ROOT / "softact" / "cards" / f"{name}.yaml"
        assert validate(path).called == KINDS["card"].called
    body = specs.load("spec.yaml", [f"materials.body={path}"]).materials["body"]
    assert body.law == specs.load("spec.yaml", [f"materials.body={name}"]).materials["body"].law

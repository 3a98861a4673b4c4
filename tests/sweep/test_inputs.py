"""Whatever a run reads is in its key, or its result is not kept: scripts of the user's with what
they import, open and ask for, files that a spec names, options of PETSc."""

import csv
import json
import subprocess
import sys
from pathlib import Path

import meshio
import pytest

from softact import spec as specs
from softact.cli import main as cli
from softact.files.text import digest
from softact.geometries.from_script import FromScript
from softact.geometries.from_step import FromStep
from softact.geometry import imported
from softact.geometry.base import make_mesh
from softact.sweep import compute as computing
from softact.sweep.cache import Cache
from softact.sweep.compute import compute
from softact.sweep.points import Plan
from softact.sweep.spec import Sweep, read
from softact.sweep.version import run_key
from tests import bent_beam
from tests.sweep.folders import CUBE, instead_of_run

# The height of a block comes from a module, the width from a file, the length from the environment.
SCRIPT = """
import os, sys
from pathlib import Path
here = Path(__file__).parent
sys.path.insert(0, str(here))
from helper import HEIGHT

def build(gmsh):
    width = float((here / "width.txt").read_text())
    length = float(os.environ.get("LENGTH_OF_THE_BLOCK", 4))
    block = gmsh.model.occ.addBox(0, 0, 0, length, width, HEIGHT)
    gmsh.model.occ.synchronize()
    groups = {"body": (3, [block]), "clamp": (2, [1])}
    for name, (dimension, tags) in groups.items():
        gmsh.model.setPhysicalName(dimension, gmsh.model.addPhysicalGroup(dimension, tags), name)
"""
BASE = """
base:
  geometry: {type: from_script, file: FILE, mesh_size: 4 mm, cavities: {}, tip: ''}
  materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
  steps: [{name: hang, gravity: [0, 0, -1]}]
axes: [{path: materials.body.c10, values: [0.1 MPa]}]
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A sweep over a script; the solver is made up: 10 degrees for each mm of height."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "block.py").write_text(SCRIPT)
    (tmp_path / "helper.py").write_text("HEIGHT = 3\n")
    (tmp_path / "width.txt").write_text("4")
    (tmp_path / "sweep.yaml").write_text(BASE.replace("FILE", str(tmp_path / "block.py")))
    monkeypatch.setattr(computing, "run", by_its_mesh)
    return tmp_path


def by_its_mesh(spec, directory, scratch, **options):
    make_mesh(spec.geometry, scratch / "mesh.msh")
    height = meshio.read(scratch / "mesh.msh").points[:, 2].max()
    bent_beam.write(directory, 10 * height, 2, size={"nx": 6, "ny": 2, "nz": 7})
    path = directory / "run.json"
    story = json.loads(path.read_text()) | {"mesh_hash": digest(scratch / "mesh.msh")}
    path.write_text(json.dumps(story))


def a_new_process(monkeypatch):
    monkeypatch.setattr(imported, "_digests", {})


def key(folder):
    study, base = read(folder / "sweep.yaml", Sweep)
    (point,) = Plan(base).points(study.axes, study.design.points(study.axes))
    return point.key


def test_whatever_a_script_reads_is_in_the_key(folder, monkeypatch):
    keys = [key(folder)]
    for change in (
        lambda: (folder / "helper.py").write_text("HEIGHT = 2\n"),
        lambda: (folder / "width.txt").write_text("5"),
        lambda: monkeypatch.setenv("LENGTH_OF_THE_BLOCK", "6"),
    ):
        change()
        a_new_process(monkeypatch)
        keys.append(key(folder))
    (folder / "helper.py").write_text("HEIGHT = 2  # what changes nothing\n")
    a_new_process(monkeypatch)
    assert len(set(keys)) == 4 and key(folder) == keys[-1]
    assert not list(folder.rglob("__pycache__"))


def sweep(capsys, *options):
    with pytest.raises(SystemExit) as stop:
        cli.main(["sweep", "sweep.yaml", *options])
    out = capsys.readouterr()
    return stop.value.code, out.out, out.err


def angle(folder):
    with open(folder / "results/sweep/sweep.csv") as file:
        (row,) = csv.DictReader(file)
    return float(row["bending_angle_deg"]) if row["status"] == "complete" else None


def test_an_edited_helper_is_swept_anew(folder, monkeypatch, capsys):
    assert sweep(capsys)[0] == 0
    assert angle(folder) == pytest.approx(30)
    assert "0 computed now" in sweep(capsys)[1]
    (folder / "helper.py").write_text("HEIGHT = 2\n")
    a_new_process(monkeypatch)
    assert "not computed" in sweep(capsys, "--list")[1]
    assert "1 computed now" in sweep(capsys)[1]
    assert angle(folder) == pytest.approx(20)


def test_an_edit_between_plan_and_run_is_not_kept_under_the_old_key(folder, monkeypatch, capsys):
    old = key(folder)
    (folder / "helper.py").write_text("HEIGHT = 2\n")  # the plan of this process is of 3 mm
    code, _, err = sweep(capsys)
    assert code == 1 and "has changed since the run was planned" in err
    assert (angle(folder), Cache(folder / "results/.runs").find(old)) == (None, None)
    a_new_process(monkeypatch)
    assert sweep(capsys)[0] == 0
    assert angle(folder) == pytest.approx(20)


def test_a_script_that_makes_another_mesh_each_time_is_never_kept(folder, capsys):
    (folder / "helper.py").write_text("import random\nHEIGHT = 2 + random.random()\n")
    code, _, err = sweep(capsys)
    assert code == 1 and "or its script makes another mesh each time" in err
    assert not list((folder / "results/.runs").glob("??/*"))


def test_a_script_without_a_mesh_is_a_failed_point(folder, capsys):
    (folder / "width.txt").unlink()
    code, out, err = sweep(capsys)
    assert code == 0 and err.startswith("runs the script ") and len(err.splitlines()) == 1
    assert "1 failed" in out and "No such file" in (folder / "results/sweep/sweep.csv").read_text()


def test_a_run_of_another_spec_is_not_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(computing, "run", instead_of_run)
    loaded = specs.loads(
        "geometry: {type: block}\nmaterials: {body: {law: neo_hookean, c10: 0.1 MPa}}\n"
        "steps: [{name: hang, gravity: [0, 0, -1]}]"
    )
    answer = compute(loaded, "0" * 32, Cache(tmp_path / "runs"))
    assert (answer.status, answer.record, answer.transient) == ("failed", None, True)
    assert not list((tmp_path / "runs").glob("??/*"))


@pytest.mark.parametrize("texts", [("card.yaml", "a text"), ("a text", "card.yaml")])
def test_a_remembered_key_knows_the_content_of_the_files_that_are_named(tmp_path, texts):
    """Whether the base or a value of an axis names it; here where it has no effect at all."""
    in_base, on_axis = texts
    card, plan_file = tmp_path / "card.yaml", tmp_path / "plan.json"
    card.write_text("law: neo_hookean\nc10: 0.1 MPa\n")
    (tmp_path / "sweep.yaml").write_text(
        f"{CUBE}axes: [{{path: description, values: [{on_axis}]}}]\nset: {{source: {in_base}}}\n"
    )
    study, base = read(tmp_path / "sweep.yaml", Sweep)

    def remembered():
        plan = Plan(base, plan_file)
        before = dict(plan.known)
        plan.points(study.axes, study.design.points(study.axes))
        plan.remember(plan_file)
        return plan.known == before

    assert [remembered(), remembered()] == [False, True]
    card.write_text("law: neo_hookean\nc10: 0.2 MPa\n")
    assert [remembered(), remembered()] == [False, True]


def test_options_of_petsc_are_in_the_key_or_without_effect(tmp_path, monkeypatch):
    """PETSc reads PETSC_OPTIONS, and .petscrc of the folder that it is started in."""
    loaded = specs.loads(
        "geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}\n"
        "materials: {body: {law: neo_hookean, c10: 0.1 MPa}}\n"
        "steps: [{traction: {surface: x_max, value: [20 kPa, 0 kPa, 0 kPa]}}]\n"
        "solver: {initial_increment: 1, max_increment: 1}\n"
    )
    (tmp_path / "cube.yaml").write_text(loaded.to_yaml())
    (tmp_path / ".petscrc").write_text("-snes_max_it 1\n")
    command = [sys.executable, "-m", "softact.cli.main", "run", "cube.yaml", "-o", "out"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    with open(tmp_path / "out/curve.csv") as file:
        last = list(csv.DictReader(file))[-1]
    assert int(last["newton_iterations"]) > 1 and float(last["residual"]) < 1e-8
    before = run_key(loaded)
    monkeypatch.setenv("PETSC_OPTIONS", "-snes_max_it 1")
    assert run_key(loaded) != before


def test_a_finished_run_of_a_script_is_no_longer_finished_when_its_helper_was_edited(folder):
    """``run --resume`` answered 'complete', with the results of the old wall."""
    text = (folder / "sweep.yaml").read_text()
    spec = text[text.index("  geometry") : text.index("axes:")].replace("\n  ", "\n").strip()
    (folder / "spec.yaml").write_text(spec + "\nsolver: {initial_increment: 1, max_increment: 1}\n")

    def run():
        command = [sys.executable, "-m", "softact.cli.main", "run", "spec.yaml", "-o", "out"]
        done = subprocess.run([*command, "--resume"], cwd=folder, capture_output=True, text=True)
        return done.returncode, done.stderr

    assert [run()[0], run()[0]] == [0, 0]
    (folder / "helper.py").write_text("HEIGHT = 2\n")
    code, err = run()
    assert code == 2 and err.startswith("out: holds the run of another mesh: what block.py reads")
    assert len(err.splitlines()) == 1


def test_what_follows_from_a_file_alone_is_not_meshed_for_its_key(tmp_path):
    """A mesh, and a STEP file, for one that refers to others is refused; a script is."""
    texts = {
        "a.msh": "$MeshFormat",
        "a.step": "ISO-10303-21;",
        "b.step": "#1 = DOCUMENT_FILE('wheel.step', '', '', #2, '', $);",
        "a.py": "",
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    kinds = {".msh": FromScript, ".py": FromScript, ".step": FromStep}
    found = {
        name: kinds[Path(name).suffix](file=str(tmp_path / name)).self_contained for name in texts
    }
    assert found == {"a.msh": True, "a.step": True, "b.step": True, "a.py": False}

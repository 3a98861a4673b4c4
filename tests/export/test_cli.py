"""`softact export`: what it writes, says and refuses."""

import importlib.util
import json

import numpy as np
import pytest
from click.testing import CliRunner

from softact.cli.export import export
from softact.errors import SpecError
from softact.export import to_fmu
from softact.mesh.layout import Layout
from softact.results.writer import ResultsWriter

from . import made_up


@pytest.fixture
def folders(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return [str(folder) for folder in made_up.write(tmp_path)]


def called(*arguments):
    return CliRunner().invoke(export, list(arguments), standalone_mode=False)


def test_it_writes_and_says_how_far_it_is_off(folders, tmp_path):
    out = tmp_path / "out"
    result = called(*folders, "--to", "json", "--to", "urdf", "-o", str(out))
    assert result.exception is None
    assert sorted(path.name for path in out.iterdir()) == [
        ".softact.json", "made_up.urdf", "made_up_joints.csv", "model.json", "reduced.html",
    ]  # fmt: skip
    assert "bending angle: at most" in result.stdout
    assert f"wrote {out / 'model.json'}" in result.stdout
    assert result.stderr == ""


def test_it_warns_where_no_load_tells_the_stiffness(folders):
    result = called(folders[0], "--to", "json")
    assert "warning: stiffness of bending_y is assumed" in result.stderr
    assert "pneunet_tip_loads.yaml" in result.stderr


def test_a_refusal_writes_nothing(folders, tmp_path, monkeypatch):
    monkeypatch.setattr(to_fmu, "find_spec", lambda name: None)
    out = tmp_path / "out"
    result = called(*folders, "--to", "json", "--to", "fmu", "-o", str(out))
    assert isinstance(result.exception, SpecError)
    assert not out.exists()


def test_what_is_no_result_is_refused_in_a_line(tmp_path):
    result = called(str(tmp_path), "--to", "json")
    assert isinstance(result.exception, SpecError) and len(result.exception.lines) == 1
    assert list(tmp_path.iterdir()) == []


def test_more_pieces_are_more_pieces(folders, tmp_path):
    called(*folders, "--to", "json", "--pieces", "11", "-o", str(tmp_path / "out"))
    assert json.loads((tmp_path / "out" / "model.json").read_text())["pieces"] == 11


def test_files_go_beside_the_results_and_are_replaced(folders, tmp_path):
    for _ in range(2):
        assert called(*folders, "--to", "json").exception is None
    made = tmp_path / "results" / "moment_0-export"
    assert sorted(p.name for p in made.iterdir()) == [
        ".softact.json", "model.json", "reduced.html",
    ]  # fmt: skip


def test_a_folder_or_file_of_somebody_else_is_left_alone(folders, tmp_path):
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.tex").write_text("mine")
    refused = called(*folders, "--to", "json", "-o", str(mine))
    assert "holds other files than those of 'softact export'" in refused.exception.lines[0]
    assert [path.name for path in mine.iterdir()] == ["thesis.tex"]
    out = tmp_path / "out"
    called(*folders, "--to", "urdf", "-o", str(out))
    (out / "model.json").write_text("mine")
    refused = called(*folders, "--to", "json", "-o", str(out))
    assert "model.json: is there already" in refused.exception.lines[0]
    assert (out / "model.json").read_text() == "mine"
    assert called(*folders, "--to", "json", "-o", str(out), "--force").exception is None


def test_a_damaged_run_is_refused(folders, tmp_path):
    curve = tmp_path / "moment_1" / "curve.csv"
    curve.write_text(curve.read_text().replace("0.2", "0.3", 1))
    refused = called(*folders, "--to", "json")
    assert refused.exception.lines == [
        "moment_1/curve.csv: is not as the run wrote it; solve the spec again".replace(
            "moment_1", str(tmp_path / "moment_1")
        )
    ]
    assert not (tmp_path / "results").exists()


def test_of_an_incomplete_run_the_states_so_far_are_taken_and_it_says_so(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made_up.write(tmp_path, finished=False)
    result = called("moment_0", "--to", "json")
    assert "warning: moment_0: the run is incomplete; its states so far are taken" in result.stderr


def test_a_run_named_twice_is_refused(folders):
    refused = called(folders[0], folders[0], "--to", "json")
    assert refused.exception.lines == [f"{folders[0]}: is named twice"]


def test_sheets_alone_are_refused(tmp_path):
    spec = "geometry: {type: woven_contracting}\nsteps: [{name: a, pressure: 1 kPa}]\n"
    writer = ResultsWriter(tmp_path / "sheet", spec, {})
    points, triangles = np.eye(3), np.array([[0, 1, 2]])
    layout = Layout((), (), {}, clamp="end", tip="other", sheets=("sheet",))
    writer.mesh(points, triangles, np.zeros(1, int), ("sheet",), {}, layout)
    writer.increment(made_up.row(1.0, 0.0, 0), {"displacement": np.zeros_like(points)})
    writer.finish("complete")
    refused = called(str(tmp_path / "sheet"), "--to", "json")
    assert "woven_contracting is made of sheets alone" in refused.exception.lines[0]


@pytest.mark.parametrize("name", ["class", "json", "3-pouches"])
def test_a_name_may_be_any_that_a_spec_has(tmp_path, monkeypatch, name):
    """A word of Python, one of its modules, no identifier: files and the unit in them still run."""
    monkeypatch.chdir(tmp_path)
    made_up.write(tmp_path, (0.0,), made_up.SPEC.replace("name: made_up", f"name: {name}"))
    unit = ["--to", "fmu"] if importlib.util.find_spec("pythonfmu") else []
    result = called("moment_0", "--to", "sofa", "--to", "mujoco", *unit)
    assert result.exception is None
    stem = {"3-pouches": "pouches"}.get(name, name)
    for script in ("sofa", "mujoco"):
        file = tmp_path / "results/moment_0-export" / f"{stem}_{script}.py"
        compile(file.read_text(), file.name, "exec")


def test_what_a_folder_is_called_is_a_text_in_every_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    name = 'a<i> """ \\ b'
    made_up.write(tmp_path, (0.0,))
    (tmp_path / "moment_0").rename(tmp_path / name)
    result = called(name, "--to", "sofa", "--to", "mujoco", "-o", "out")
    assert result.exception is None
    page = (tmp_path / "out/reduced.html").read_text()
    assert "<i>" not in page.split("<main")[-1] and "a&lt;i&gt;" in page
    compile((tmp_path / "out/made_up_sofa.py").read_text(), "scene", "exec")

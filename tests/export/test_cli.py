"""`softact export`: what it writes, says and refuses."""

import pytest
from click.testing import CliRunner

from softact.cli.export import export
from softact.errors import SpecError
from softact.export import to_fmu

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
    import json

    called(*folders, "--to", "json", "--pieces", "11", "-o", str(tmp_path / "out"))
    assert json.loads((tmp_path / "out" / "model.json").read_text())["pieces"] == 11

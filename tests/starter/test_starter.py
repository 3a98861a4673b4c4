"""First specs: each family validates, in every size that can be made; three are solved."""

import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

from softact.cli import main as cli
from softact.errors import SpecError
from softact.geometries import GEOMETRIES
from softact.materials import load_card
from softact.results.folder import read
from softact.run import start as runs
from softact.spec import load
from softact.starter import MOTIONS, Wanted, families, family, for_motion, write
from softact.starter.families import _of_defaults

EACH = [(entry.name, does) for entry in families().values() for does in entry.does]
NO_FILE = {entry.name for entry in families().values() if "{{ file }}" not in entry.template}


def wanted(folder: Path, name: str, **values: object) -> Wanted:
    if name in NO_FILE:
        return Wanted(**values)
    part = folder / ("part.step" if name == "from_step" else "part.msh")
    part.touch()
    return Wanted(file=part, **values)


def test_every_geometry_has_a_spec_of_its_own_and_every_motion_a_family():
    assert list(families()) == list(GEOMETRIES)
    assert [entry.name for entry in families().values() if not entry.template] == []
    assert {does for _, does in EACH} == set(MOTIONS)
    for does, (_, simplest) in MOTIONS.items():
        assert for_motion(does)[0].name == simplest


@pytest.mark.parametrize(("name", "does"), EACH)
def test_a_spec_validates_and_is_of_what_was_asked_for(name, does, tmp_path):
    path = tmp_path / "first.yaml"
    path.write_text(write(family(name), wanted(tmp_path, name, does=does), path))
    spec = load(path)
    assert spec.geometry.type == name
    lines = path.read_text().splitlines()
    assert lines[0].startswith("# ") and len(lines) < 40
    assert any("#" in line for line in lines[3:]) and max(map(len, lines)) < 240


# A stack of pouches twice as long has twice as many of them.
IN_PROPORTION = [pair for pair in EACH if pair[0] in NO_FILE - {"woven_elongating"}]


@pytest.mark.parametrize(("name", "does"), IN_PROPORTION)
def test_an_actuator_twice_as_large_has_twice_the_lengths(name, does, tmp_path):
    entry = family(name)
    one, two = (
        load_text(tmp_path, entry, does=does, length=k * entry.length, width=k * entry.width)
        for k in (1, 2)
    )
    written = one.geometry.model_fields_set - {"angle", "alpha"}
    lengths = [key for key in written if isinstance(getattr(one.geometry, key), float)]
    assert len(lengths) > 2
    for key in lengths:
        small, large = getattr(one.geometry, key), getattr(two.geometry, key)
        assert large == pytest.approx(2 * small, rel=0.01), key
    assert [step.loads.keys() for step in one.steps] == [step.loads.keys() for step in two.steps]


def load_text(folder: Path, entry, **values: object):
    path = folder / "first.yaml"
    path.write_text(write(entry, Wanted(**values), path))
    return load(path)


def test_a_softer_material_gets_less_pressure_in_proportion(tmp_path):
    spec = load_text(tmp_path, family("bellows"), material="ecoflex-00-30")
    ratio = load_card("ecoflex-00-30").shear_modulus / load_card("dragon-skin-30").shear_modulus
    (pressure,) = spec.steps[0].pressure.values()
    assert ratio < 0.3
    assert pressure == pytest.approx(8e-3 * ratio, rel=0.05)  # two digits
    spec = load_text(tmp_path, family("bellows"), pressure=0.0123)
    assert spec.steps[0].pressure == {"cavity": 0.0123}


def test_a_card_of_ones_own_counts_from_the_folder_of_the_spec(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("cards").mkdir()
    Path("cards/mine.yaml").write_text("{law: neo_hookean, c10: 0.05 MPa}")
    Path("specs").mkdir()
    path = Path("specs/first.yaml")
    path.write_text(write(family("tube"), Wanted(material="cards/mine.yaml"), path))
    assert 'body: "../cards/mine.yaml"' in path.read_text()
    assert load(path).materials["body"].c10 == 0.05


@pytest.mark.parametrize(
    ("name", "values", "line"),
    [
        ("pneunet", {"does": "twist"}, "a pneunet does not twist, it can bend or grip"),
        ("pneunet", {"length": 20.0, "width": 80.0}, "no pneunet can be 20 mm long and 80 mm wide"),
        ("pneunet", {"material": "ecoflex"}, "there is no material card 'ecoflex'"),
        ("from_step", {}, "name it with --file"),
    ],
)
def test_what_cannot_be_made_is_said(name, values, line, tmp_path):
    with pytest.raises(SpecError) as caught:
        write(family(name), Wanted(**values), tmp_path / "first.yaml")
    assert line in caught.value.lines[0]


def test_a_geometry_without_a_spec_of_its_own_gets_its_defaults(tmp_path):
    spec = load_text(tmp_path, _of_defaults("pneunet"))
    assert spec.geometry == GEOMETRIES["pneunet"]()
    assert spec.steps[0].pressure == {"cavity": pytest.approx(0.01)}


def leave(*arguments: str) -> int | str | None:
    with pytest.raises(SystemExit) as left:
        cli.main(arguments)
    return left.value.code


def test_the_command_takes_flags_and_writes_over_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert leave("new", "--does", "stretch", "--length", "6 cm", "-o", "mine.yaml") == 0
    assert "softact run mine.yaml" in capsys.readouterr().out
    spec = load("mine.yaml")
    assert spec.geometry.type == "bellows"
    assert spec.geometry.length == pytest.approx(60, rel=0.01)
    assert leave("new", "bellows", "-o", "mine.yaml") == 2
    assert "is there already" in capsys.readouterr().err
    for call, said in (
        (("new",), "say what it shall do"),
        (("new", "pneumet"), "did you mean"),
        (("new", "--does", "bond"), "no actuator is known to 'bond'"),
        (("new", "pneunet", "--length", "6"), "has no unit"),
        (("new", "pneunet", "--width", "-6 mm"), "not above 0"),
    ):
        assert leave(*call) == 2
        assert said in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["mine.yaml"]


@pytest.mark.parametrize(
    ("words", "completed"),
    [
        ("new slow", ["slow_pneunet"]),
        ("new --does st", ["stretch"]),
        ("new pneunet --material ecoflex-00-3", ["ecoflex-00-30", "ecoflex-00-30-epfl"]),
    ],
)
def test_the_shell_completes_names(words, completed, monkeypatch, capsys):
    monkeypatch.setenv("_SOFTACT_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", f"softact {words}")
    monkeypatch.setenv("COMP_CWORD", str(len(words.split())))
    leave()
    assert capsys.readouterr().out.split() == [f"plain,{word}" for word in completed]


def test_on_a_terminal_it_asks_for_what_it_was_not_given(tmp_path):
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "softact.cli.main", "new", "--width", "20 mm", "-o", "f.yaml"]
    process = subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=theirs, cwd=tmp_path)
    os.close(theirs)
    # stretch; slow_pneunet by its name; a wrong length, a right one; the usual material
    os.write(ours, b"2\nslow_pneunet\n7\n70 mm\n\n")
    said = b""
    try:
        while part := os.read(ours, 4096):
            said += part
    except OSError:  # the other end has gone
        pass
    assert process.wait(timeout=30) == 0, said.decode()
    assert "What shall it do?" in said.decode() and "no unit" in said.decode()
    spec = load(tmp_path / "f.yaml")
    assert spec.geometry.kind == "linear"
    assert spec.geometry.length == pytest.approx(70, rel=0.01)
    assert spec.geometry.width == pytest.approx(20, rel=0.01)


@pytest.mark.parametrize(
    ("name", "does", "column", "least"),
    [
        ("pneunet", "bend", "bending_angle_deg", 20.0),
        ("bellows", "stretch", "elongation_mm", 2.0),
        ("braided_muscle", "twist", "twist_angle_deg", 5.0),
    ],
)
def test_a_first_spec_does_what_it_shall(name, does, column, least, tmp_path):
    path = tmp_path / "first.yaml"
    path.write_text(write(family(name), Wanted(does=does), path))
    runs.run(load(path), tmp_path / "results", report=False, threads=1)
    results = read(tmp_path / "results")
    assert results.status == "complete"
    assert abs(results.summary[column]) > least

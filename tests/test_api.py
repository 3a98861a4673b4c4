"""softact from Python: the same runs, figures and messages as the command line."""

import inspect
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import softact
from softact import api
from softact.results import folder as result_folder

SPEC = """
name: cube
geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps: [{name: pull, traction: {surface: x_max, value: [20 kPa, 0 kPa, 0 kPa]}}]
solver: {initial_increment: 0.5, max_increment: 0.5}
"""
SWEEP = """
base: cube.yaml
axes: [{path: materials.body.c10, values: [0.1 MPa, 0.2 MPa]}]
"""
FINGER = """
geometry: {type: pneunet, chambers: 2, mesh_size: 7 mm}
materials: {body: elastosil-m4601}
steps: [{name: inflate, pressure: 20 kPa}]
"""
WALLS = """
base: finger.yaml
axes: [{path: geometry.outer_wall, values: [1 mm]}]
"""
DATA = "stretch,nominal stress (MPa)\n" + "".join(
    f"{stretch},{2 * 0.1 * (stretch - stretch**-2)}\n" for stretch in np.linspace(1, 2, 12)
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("api")
    (place / "cube.yaml").write_text(SPEC)
    (place / "cubes.yaml").write_text(SWEEP)
    (place / "rubber.csv").write_text(DATA)
    return place


@pytest.fixture(scope="module")
def sheet(folder):
    return softact.run(folder / "cube.yaml", folder / "out")


def test_every_name_is_offered_and_described():
    for name in api.NAMES:
        found = getattr(softact, name)
        assert name in dir(softact) and inspect.getdoc(getattr(api, name)), name
        if name in ("run", "sweep", "fit"):
            assert inspect.signature(found) == inspect.signature(getattr(api, name))
    with pytest.raises(AttributeError, match="has no attribute 'solver'"):
        softact.solver  # noqa: B018


def test_a_room_that_is_imported_is_called_all_the_same():
    """``import softact.run.start`` makes ``softact.run`` the package."""
    code = (
        "import softact.run.start, softact.fit.fit, softact.sweep.study, softact, sys\n"
        "for room in ('run', 'fit', 'sweep'):\n"
        "    assert callable(getattr(softact, room)), room\n"
        "assert 'softact.api' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_importing_softact_imports_nothing_of_it():
    code = "import softact, sys; print(*sorted(m for m in sys.modules if m.startswith('softact.')))"
    found = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert found.stdout.split() == []


def test_a_run_is_that_of_the_command_line(folder):
    """To the last digit on one process; two may add up in another order."""
    command = [sys.executable, "-m", "softact.cli.main", "run", "cube.yaml", "-o", "command"]
    subprocess.run([*command, "-n", "1"], cwd=folder, check=True, capture_output=True)
    sheet = softact.run(folder / "cube.yaml", folder / "alone", processes=1)
    there, here = folder / "command", sheet.directory
    assert {p.name for p in there.iterdir()} == {p.name for p in here.iterdir()}
    wanted, found = result_folder.read(there), sheet.results
    assert list(wanted.curve) == list(found.curve)
    for name, values in wanted.curve.items():
        np.testing.assert_array_equal(values, found.curve[name], name)


def test_what_a_data_sheet_holds(folder, sheet):
    assert sheet.status == "complete" and sheet.verdict.colour == "green"
    assert repr(sheet) == f"<DataSheet {folder / 'out'}: green>"
    assert sheet.curve["step_fraction"].tolist() == [0, 0.5, 1]
    assert sheet.summary["elongation_mm"] == pytest.approx(sheet.curve["elongation_mm"].iloc[-1])
    assert sheet.spec == softact.load(folder / "cube.yaml")
    grid = sheet.fields()
    moved = sheet.results.field(2, "displacement")
    np.testing.assert_array_equal(grid.point_data["displacement"], moved)
    assert grid.n_cells == len(sheet.results.cells) and "von_mises" in grid.array_names
    assert grid.compute_cell_sizes()["Volume"].sum() == pytest.approx(64)  # mm³: cells in order
    longer = grid.warp_by_vector("displacement").bounds.x_max - 4
    assert longer == pytest.approx(sheet.results.points[:, 0].max() - 4 + moved[:, 0].max())
    assert np.abs(sheet.fields(0).point_data["displacement"]).max() == 0
    with pytest.raises(IndexError):
        sheet.fields(3)
    page = sheet.directory / "report.html"
    page.unlink()
    assert sheet.report() == page and page.is_file()
    assert softact.read(sheet.directory).summary == sheet.summary


def test_changes_have_units_and_are_checked(folder):
    spec = softact.load(folder / "cube.yaml", {"materials.body.c10": "200 kPa"})
    assert spec.materials["body"].c10 == 0.2
    thin = spec.with_(
        {"geometry.height": "0.2 cm", "steps.pull.traction.value.0": "1 kPa"}, name="x"
    )
    assert (thin.name, thin.geometry.height) == ("x", 2)
    assert thin.steps[0].traction.value[0] == 0.001
    assert (spec.name, spec.geometry.height) == ("cube", 4)
    with pytest.raises(softact.SoftactError, match=r"geometry\.hight: unknown key"):
        spec.with_({"geometry.hight": "1 mm"})
    with pytest.raises(softact.SoftactError, match="is a pressure; write a length"):
        spec.with_({"geometry.height": "1 kPa"})


def test_what_it_refuses(folder, tmp_path):
    with pytest.raises(softact.SoftactError, match=r"no run\.json in it"):
        softact.read(tmp_path)
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(softact.SoftactError, match="holds other files"):
        softact.run(folder / "cube.yaml", tmp_path)
    with pytest.raises(softact.SoftactError, match="this is a spec, where a sweep is wanted"):
        softact.sweep(folder / "cube.yaml")
    with pytest.raises(softact.SoftactError, match="there is no option 'colums'"):
        softact.fit(folder / "rubber.csv", colums="a, b")
    with pytest.raises(softact.SoftactError, match="name a file of test data"):
        softact.fit()
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_a_sweep_is_a_table(folder):
    rows = softact.sweep(folder / "cubes.yaml", folder / "sweep", cache=folder / "cache")
    assert rows["status"].tolist() == ["complete", "complete"]
    stretch = rows["elongation_mm"]
    assert 1.5 < stretch[0] / stretch[1] < 3  # half as stiff
    assert (folder / "sweep/sweep.html").is_file()


def test_a_fit_finds_the_law_that_the_data_came_from(folder, tmp_path):
    said = []
    best, *others = softact.fit(
        folder / "rubber.csv", law="neo_hookean", directory=tmp_path, tell=said.append
    )
    assert not others and said
    assert best.candidate.make(best.vector).c10 == pytest.approx(0.1, rel=1e-6)
    assert (tmp_path / "rubber.yaml").is_file()


def test_the_page_is_carried_out(folder, tmp_path, monkeypatch, capsys):
    page = Path(__file__).resolve().parents[1] / "docs/python.md"
    code = "".join(re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.S))
    (tmp_path / "finger.yaml").write_text(FINGER)
    (tmp_path / "walls.yaml").write_text(WALLS)
    (tmp_path / "rubber.csv").write_text(DATA)
    monkeypatch.chdir(tmp_path)
    exec(compile(code, str(page), "exec"), {})
    out = capsys.readouterr().out.splitlines()
    assert out[0].startswith("complete ")
    assert 0 < float(out[2]) < 1  # thicker and with half the pressure: less
    assert float(out[-1]) == pytest.approx(0.1, rel=1e-6)
    assert (tmp_path / "results/thick/report.html").is_file()

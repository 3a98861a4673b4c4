"""Orders, limits and error bars of values that are known, and a study of a made-up solver."""

import csv
import json
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from softact import spec as specs
from softact.cli import main as cli
from softact.converge import output
from softact.converge import study as studies
from softact.converge.carry import carry_into
from softact.converge.richardson import SAFETY, counting, estimate
from softact.converge.study import Convergence, Level, converge, mesh_sizes, refined
from softact.errors import MeshError, SpecError
from softact.measured.curve import Measured
from softact.report import pictures, write_report
from softact.report.remembered import remember
from softact.results.folder import MESH_ERROR, read
from softact.results.own_folder import Output
from softact.sweep import compute as computing
from softact.sweep.cache import Cache
from softact.sweep.record import Record, from_results
from tests import bent_beam

REPOSITORY = Path(__file__).resolve().parents[2]
SPEC = specs.loads(
    "name: beam\ngeometry: {type: block, length: 12 mm, mesh_size: 8 mm}\n"
    "materials: {body: {law: neo_hookean, c10: 0.1 MPa}}\n"
    "steps: [{name: hang, gravity: [0, 0, -1]}]"
)


@pytest.mark.parametrize("order", [1.0, 2.0, 3.0])
@pytest.mark.parametrize("constant", [0.7, -0.7])
def test_order_and_limit_of_a_power_law(order, constant):
    """f(h) = 10 + C hᵖ on meshes that are not refined evenly."""
    sizes = [4.0, 2.5, 1.5, 1.0]
    values = [10 + constant * h**order for h in sizes]
    found = estimate(sizes, values)
    assert found.order == pytest.approx(order, rel=1e-9)
    assert found.limit == pytest.approx(10, rel=1e-9)
    assert found.errors == pytest.approx([SAFETY * abs(constant) * h**order for h in sizes])
    assert found.changes[0] is None
    assert found.changes[1] == pytest.approx(abs((values[1] - values[0]) / values[1]))


@pytest.mark.parametrize(
    ("values", "note"),
    [
        ([10, 12, 11], "up and down"),
        ([10, 11, 12], "do not shrink"),
        ([10, 11, 11], "the same"),
        ([10, 11, 11.000001], "too large"),
        ([10, 11], "two meshes"),
        ([10], "no mesh is finer"),
    ],
)
def test_values_without_an_order_have_no_error_bars(values, note):
    found = estimate([4, 2, 1][: len(values)], values)
    assert (found.order, found.limit) == (None, None)
    assert set(found.errors) == {None}
    assert note in found.note


@pytest.mark.parametrize("values", [[8e-16, -2e-16, 7e-16], [10.00001, 10.0, 10.00002]])
def test_what_is_the_same_on_three_meshes_has_converged(values):
    found = estimate([4, 2, 1], values)
    assert found.last_change < 1e-5
    assert found.limit == values[-1]
    assert found.errors == tuple(SAFETY * abs(v - values[-1]) for v in values)


@pytest.mark.parametrize(
    ("sizes", "meshes"),
    [
        ([4, 2, 1], [0, 1, 2]),
        ([4, 4, 2], [0, 2]),
        ([4, 3.9, 3.5, 3.4], [0, 2]),  # 3.9 is no finer than 4, and 3.4 than 3.5
        ([4, 4.1, 4.2], [0]),
        ([1.1**2, 1.1, 1.0], [0, 1, 2]),
    ],
)
def test_meshes_that_are_hardly_finer_do_not_count(sizes, meshes):
    assert counting(sizes) == meshes


def test_a_mesh_that_does_not_count_changes_neither_order_nor_limit():
    """f(h) = 10 + h², with two meshes twice."""
    sizes = [4, 4, 2, 2, 1]
    found = estimate(sizes, [10 + h**2 for h in sizes])
    assert (found.order, found.limit) == (pytest.approx(2), pytest.approx(10))
    assert found.errors == pytest.approx([SAFETY * h**2 for h in sizes])
    assert found.changes == (None, None, pytest.approx(12 / 14), None, pytest.approx(3 / 11))


def test_a_mesh_is_refined_through_its_walls_too():
    spec = specs.loads(
        "geometry: {type: pneunet, mesh_size: 3 mm, cavity_mesh_size: 6 mm}\n"
        "materials: {body: elastosil-m4601}\nsteps: [{name: up, pressure: 1 kPa}]"
    )
    assert mesh_sizes(refined(spec, 1.5).geometry) == {"mesh_size": 2.0, "cavity_mesh_size": 4.0}
    assert [refined(spec, 1.5, n).geometry.least_steps for n in range(5)] == [1, 2, 3, 4, 6]
    assert [refined(spec, 1.2, n).geometry.least_steps for n in range(5)] == [1, 2, 3, 4, 5]
    assert refined(spec, 1.5, 0).hash == spec.hash


def test_a_finger_whose_walls_are_thinner_than_its_mesh_is_refined():
    """Three chambers of 6 mm with walls of 2 mm in a mesh of 7 mm. By 1.3 and 1.3² sizes alone made
    1,230 tetrahedra twice, five in each box of the grid."""
    text = "materials: {body: elastosil-m4601}\nsteps: [{name: up, pressure: 20 kPa}]"
    walls = "outer_wall: 2 mm, inner_wall: 2 mm, roof: 2 mm"
    spec = specs.loads(
        f"geometry: {{type: pneunet, chambers: 3, {walls}, mesh_size: 7 mm}}\n{text}"
    )
    for size in ("5.38462 mm", "4.14201 mm"):
        alone = spec.geometry.model_validate(
            {"chambers": 3, "mesh_size": size}
            | dict.fromkeys(("outer_wall", "inner_wall", "roof"), "2 mm")
        )
        assert alone.cells() == 1230
    assert [refined(spec, 1.3, n).geometry.cells() for n in range(3)] == [915, 6900, 21870]
    for n in (1, 2):
        assert all(wall.elements >= n + 1 for wall in refined(spec, 1.3, n).geometry.walls())


def test_a_beam_is_refined_and_solved(tmp_path, monkeypatch, capsys):
    """From the command line: a cube's edge more through the beam each time, an order as elements at
    a clamped edge have, and error bars that hold what the finer meshes say."""
    monkeypatch.chdir(tmp_path)
    Path("beam.yaml").write_text(
        "geometry: {type: block, length: 16 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}\n"
        "materials: {body: {law: neo_hookean, c10: 0.1 MPa}}\nmeasures: [tip]\n"
        "steps: [{name: hang, gravity: [0, 0, -1]}]\n"
        "solver: {initial_increment: 1, max_increment: 1}\n"
    )
    with pytest.raises(SystemExit) as left:
        cli.main(["converge", "beam.yaml", "-m", "tip_z_mm"])
    assert left.value.code == 0
    told = json.loads(Path("results/beam-converge/converge.json").read_text())
    assert [level["cells"] for level in told["levels"]] == [5 * 4, 5 * 6 * 2**2, 5 * 9 * 3**2]
    assert [level["steps"]["through_wall"] for level in told["levels"]] == [1, 2, 3]
    found = told["measures"]["tip_z_mm"]
    assert told["verdict"] == found["verdict"] == "within" and 0.5 < found["order"] < 4.5
    assert abs(found["values"][0] - found["values"][2]) < found["error_bars"][0]
    assert "use mesh_size 4 mm: within 5 % of the limit" in capsys.readouterr().out


def test_more_and_more_elements_lie_through_a_wall_of_several():
    text = "materials: {body: elastosil-m4601}\nsteps: [{name: up, pressure: 1 kPa}]"
    spec = specs.loads(f"geometry: {{type: pneunet, chambers: 1, through_wall: 3}}\n{text}")
    assert [refined(spec, 1.5, n).geometry.least_steps for n in range(4)] == [3, 5, 7, 11]


@pytest.fixture(scope="module")
def studied(tmp_path_factory):
    """A solver that is of second order in its mesh size: 40 (1 + h²/1000) degrees."""

    def run(spec, directory, **options):
        angle = 40 * (1 + spec.geometry.mesh_size**2 / 1000)
        bent_beam.write(directory, angle, 1, size={"nx": 6, "ny": 2, "nz": 7})

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(computing, "run", run)
        patch.setattr(studies, "_edge", lambda spec, record, folder: spec.geometry.mesh_size)
        cache = Cache(tmp_path_factory.mktemp("runs"))
        return converge(SPEC, ["bending_angle_deg"], cache, factor=2.0, jobs=2)


def test_study_refines_until_the_measure_stays(studied):
    """Of 8, 4 and 2 mm, 6.4, 1.6 and 0.4 % too much: changes of 4.8/101.6 and 1.2/100.4."""
    assert [level.sizes["mesh_size"] for level in studied.levels] == [8, 4, 2]
    assert studied.converged
    found = studied.estimate("bending_angle_deg")
    assert found.changes[1:] == pytest.approx((4.8 / 101.6, 1.2 / 100.4))
    assert (found.order, found.limit) == (pytest.approx(2), pytest.approx(40))
    # 1.25 times 6.4 % are more than 5 %, 1.25 times 1.6 % are not.
    assert studied.recommended.sizes == {"mesh_size": 4}


def study_of(angles, edges, **more):
    """A study of a measure that is ``angles`` on meshes with cells of ``edges``, mm."""
    study = Convergence(("bending_angle_deg",), 0.05, **more)
    for number, (angle, edge) in enumerate(zip(angles, edges, strict=True)):
        record = Record(
            f"{number:032d}", "complete", "", 1.5, {"bending_angle_deg": angle}, (), (),
            np.zeros((0, 0)), round(1e4 / edge**3), 100,
        )  # fmt: skip
        study.levels.append(Level(refined(SPEC, 2.0, number), record, edge))
    return study


@pytest.mark.parametrize(
    ("angles", "edges", "verdict", "words"),
    [
        # The fault: 6, 5.4 and 4.1 mm made two meshes, one of them twice. Green was wrong.
        ([17.9, 18.9, 18.9], [1.7, 1.5, 1.5], "not converged", "5.3 % in the last step, two mesh"),
        ([18.5, 18.9, 18.9], [1.7, 1.5, 1.5], "not known", "2.1 % in the last step, two meshes"),
        ([18.9, 18.9, 18.9], [1.5, 1.5, 1.5], "not known", "no mesh is finer than the first one"),
        ([18.9, 19.0, 18.9], [4, 2, 1], "not known", "the values go up and down"),
        ([18.9, 25.0, 19.9], [4, 2, 1], "not converged", "the values go up and down"),
        # 20 (1 + h/100): an order of 1, within 5 % but for the coarsest with its bar of 1.25 4 %.
        ([21.0, 20.4, 20.2], [5, 2, 1], "within", "use mesh_size 4 mm, through_wall 2: within 5 %"),
        ([32.0, 26.0, 23.0], [4, 2, 1], "not converged", "error bar 0.19 of the limit"),
    ],
)
def test_what_a_study_says(angles, edges, verdict, words, tmp_path):
    study = study_of(angles, edges)
    assert study.verdict() == verdict
    assert words in output.advice(study)
    assert study.converged == (verdict == "within") == (study.recommended is not None)
    text = output.write(study, "beam", Output(tmp_path, "converge")).read_text()
    head = {"within": "good", "not known": "warn", "not converged": "bad"}[verdict]
    assert re.findall(r"class='banner (\w+)'", text) == [head]
    data = json.loads((tmp_path / "converge.json").read_text())
    assert data["verdict"] == data["measures"]["bending_angle_deg"]["verdict"] == verdict
    known = data["measures"]["bending_angle_deg"]["limit"] is not None
    assert known == ("±" in output.limit_lines(study)[0]) == ("limit (Richardson)" in text)
    assert known != ("not known" in output.limit_lines(study)[0])


def test_a_study_goes_on_while_meshes_do_not_count(tmp_path, monkeypatch):
    """A geometry that makes the same mesh whatever its size: all meshes are tried, none counts."""

    def run(spec, directory, **options):
        bent_beam.write(directory, 40.0, 1, size={"nx": 6, "ny": 2, "nz": 7})

    monkeypatch.setattr(computing, "run", run)
    study = converge(SPEC, ["bending_angle_deg"], Cache(tmp_path), factor=2.0, most=4, jobs=2)
    assert len(study.levels) == 4 and study.counting == [0]
    assert study.verdict() == "not known" and study.recommended is None


def test_a_later_mesh_that_fails_ends_the_study(tmp_path, monkeypatch):
    """Of the first order: three meshes do not do, and the fourth cannot be solved."""

    def run(spec, directory, **options):
        if spec.geometry.mesh_size < 1.5:
            raise MeshError("out of reach")
        angle = 40 * (1 + spec.geometry.mesh_size / 10)
        bent_beam.write(directory, angle, 1, size={"nx": 6, "ny": 2, "nz": 7})

    monkeypatch.setattr(computing, "run", run)
    monkeypatch.setattr(studies, "_edge", lambda spec, record, folder: spec.geometry.mesh_size)
    study = converge(SPEC, ["bending_angle_deg"], Cache(tmp_path), factor=2.0, jobs=2)
    assert [level.sizes["mesh_size"] for level in study.levels] == [8, 4, 2]
    assert study.verdict() == "not converged"
    assert "the next mesh was not solved: out of reach" in output.advice(study)


def test_cell_size_of_sheets_and_of_solids(tmp_path):
    """Of sheets from their area; of a solid of unknown size from the mesh of its run."""
    sheets = specs.load(str(REPOSITORY / "configs" / "woven_contracting.yaml"))
    record = replace(study_of([1.0], [1.0]).levels[0].record, cells=400)
    area = sum(sheets.geometry.volumes()[name] for name in ("pouches", "tabs"))
    assert studies._edge(sheets, record, tmp_path) == pytest.approx((area / 400) ** (1 / 2))
    bent_beam.write(tmp_path / "r", 0.0, 1, size={"nx": 6, "ny": 2, "nz": 7})
    unknown = SimpleNamespace(layout=lambda: bent_beam.LAYOUT, volumes=dict)
    edge = studies._edge(SimpleNamespace(geometry=unknown), record, tmp_path / "r")
    assert edge == pytest.approx((54 * 20 * 4 * 2 / 400) ** (1 / 3))  # of 54 boxes


def test_files(studied, tmp_path):
    output.write(studied, "beam", Output(tmp_path, "converge"))
    data = json.loads((tmp_path / "converge.json").read_text())
    assert data["measures"]["bending_angle_deg"]["values"] == studied.values("bending_angle_deg")
    with open(tmp_path / "converge.csv") as file:
        assert [float(row["mesh_size_mm"]) for row in csv.DictReader(file)] == [8, 4, 2]


def result_of(folder, angle, spec, **more):
    """A result folder that says to be of ``spec``."""
    bent_beam.write(folder, angle, 2, size={"nx": 6, "ny": 2, "nz": 7}, spec_hash=spec.hash, **more)
    return folder


@pytest.fixture
def no_drawing(monkeypatch):
    monkeypatch.setattr(pictures, "drawing", bent_beam.undrawn)


def shown(folder):
    """The text of the report without scripts and pictures."""
    text = (folder / "report.html").read_text()
    text = re.sub(r"<(script|style)\b.*?</\1>", "", text, flags=re.S)
    return re.sub(r"base64,[A-Za-z0-9+/=]+", "", text)


@pytest.mark.usefixtures("no_drawing")
def test_error_bars_in_a_result_folder_and_its_report(studied, tmp_path):
    """Of h = 4 mm: 40 (1 + 0.016) = 40.64°, limit 40°, 1.25 · 0.64 = 0.8°."""
    folder = result_of(tmp_path / "r", 40.64, refined(SPEC, 2.0, 1))
    curve = {"pressure_kPa": np.array([10.0, 40.0]), "bending_angle_deg": np.array([8.0, 32.0])}
    remember(folder, [Measured("angle.csv", "pressure_kPa", curve)])
    carry_into(studied, folder)
    assert "Against measurement" in shown(folder)  # what was measured stays
    verdict = json.loads((folder / "run.json").read_text())["verdict"]
    assert verdict["colour"] == "green"  # 0.8 of 40.64° is within 5 %
    with open(folder / "summary.csv") as file:
        (row,) = csv.DictReader(file)
    assert float(row["bending_angle_deg_mesh_error"]) == pytest.approx(0.8)
    for text in (shown(folder), shown(write_report(folder).parent)):  # as 'softact report' does
        assert "40.64°</div><div class='error'>± 0.8°</div>" in text  # the card
        assert "<td>40.64 ± 0.8</td></tr>" in text  # the table, last state
        assert text.count("± 0.8") == 2 and "(last)" in text
        (line,) = re.findall(r"<tr><th scope='row'>Bending angle</th><td>°</td>.*?</tr>", text)
        cells = re.findall(r"<td[^>]*>(.*?)</td>", line)
        assert cells == ["°", "40.64", "0.8", "40", "2.00", "within 5 % of the limit", ""]
        assert "on the mesh of this run (mesh_size 4 mm, through_wall 2)" in text
        assert "From 3 meshes (mesh_size 8 mm; mesh_size 4 mm, through_wall 2; " in text
        wanted = "wanted was 5 %. The coarsest mesh within it for every figure: mesh_size 4 mm"
        assert wanted in text
        assert "has not converged" not in text


@pytest.mark.usefixtures("no_drawing")
def test_error_bars_go_with_the_run_that_they_are_of(studied, tmp_path):
    folder = result_of(tmp_path / "r", 42.56, SPEC)
    carry_into(studied, folder)
    assert "± 3.2" in shown(folder)  # 1.25 · 6.4 % of 40°, which is more than 5 %
    verdict = json.loads((folder / "run.json").read_text())["verdict"]
    assert (verdict["colour"], verdict["reasons"][0]["kind"]) == ("amber", "mesh")
    assert "the mesh has not converged within 5 %: bending angle" in shown(folder)
    told = json.loads((folder / MESH_ERROR).read_text())
    assert (told["verdict"], told["converged"]) == ("not converged", False)
    told["levels"][0]["spec_hash"] = "another"
    (folder / MESH_ERROR).write_text(json.dumps(told))
    write_report(folder)
    assert "±" not in shown(folder) and "belongs to another spec" in shown(folder)
    for torn in ({}, [], told | {"tolerance": "<b>"}, told | {"level": 7}):
        (folder / MESH_ERROR).write_text(json.dumps(torn))
        write_report(folder)
        assert "±" not in shown(folder) and "mesh_error.json cannot be read" in shown(folder)
    del told["verdict"]
    (folder / MESH_ERROR).write_text(json.dumps(told))
    write_report(folder)
    assert "±" not in shown(folder) and "mesh_error.json is of an older softact" in shown(folder)
    result_of(folder, 42.56, SPEC)  # run again: its error bars have to be carried again
    assert not (folder / MESH_ERROR).exists()


@pytest.mark.usefixtures("no_drawing")
def test_a_result_says_that_the_error_of_its_mesh_is_not_known(tmp_path):
    """No ± and no column where three meshes tell nothing."""
    study = study_of([40.5, 40.0, 40.25], [4, 2, 1])
    folder = result_of(tmp_path / "r", 40.5, SPEC)
    assert "what is known of the mesh" in carry_into(study, folder)
    with open(folder / "summary.csv") as file:
        assert not any("mesh_error" in name for name in next(csv.reader(file)))
    told = json.loads((folder / MESH_ERROR).read_text())
    assert (told["verdict"], told["error_bars"]) == ("not known", {})
    assert "±" not in re.sub("An error bar is.*", "", shown(folder), flags=re.S)
    assert "how far the mesh is from its limit is not known: bending angle" in shown(folder)
    (line,) = re.findall(r"<tr><th scope='row'>Bending angle</th><td>°</td>.*?</tr>", shown(folder))
    cells = re.findall(r"<td[^>]*>(.*?)</td>", line)
    assert cells[1:4] == ["40.5", "not known", "not known"]
    assert cells[-2:] == ["not known", "the values go up and down"]


@pytest.mark.usefixtures("no_drawing")
def test_a_kept_run_that_gets_error_bars_stays_kept(studied, tmp_path):
    """``softact report results/.runs/ab/ab12`` is a way to look at a run of a sweep."""
    cache = Cache(tmp_path / "runs")
    folder = result_of(tmp_path / "r", 42.56, SPEC)
    cache.keep(from_results("ab12", read(folder), 1.0), folder)
    carry_into(studied, cache.folder("ab12"))
    assert cache.find("ab12").measures["bending_angle_deg"] == 42.56
    (cache.folder("ab12") / "summary.csv").write_text("torn")
    assert cache.find("ab12") is None


def test_folders_that_error_bars_do_not_belong_to(studied, tmp_path):
    for folder, words in [
        (result_of(tmp_path / "a", 42.56, refined(SPEC, 3.0)), "another spec"),
        (result_of(tmp_path / "b", 42.56, SPEC, status=None), "not complete"),
        (result_of(tmp_path / "c", 42.06, SPEC), "42.06 there and 42.56 in this study"),
        (tmp_path, "not a result folder"),
    ]:
        with pytest.raises(SpecError, match=words):
            carry_into(studied, folder)
        assert not (folder / MESH_ERROR).exists()


@pytest.mark.parametrize(
    ("measure", "said"),
    [
        ("bending_angel_deg", "has no such column; did you mean 'bending_angle_deg'"),
        ("newton_iterations", "has no such column"),
        ("geometry.length", "has no such column"),
        ("failure", "group of columns; name one of: principal_stress_p999"),
    ],
)
def test_a_measure_that_no_run_has_is_told_before_anything_is_computed(
    measure, said, tmp_path, monkeypatch
):
    monkeypatch.setattr(computing, "run", lambda *a, **o: pytest.fail("a run was computed"))
    with pytest.raises(SpecError, match=said):
        converge(SPEC, [measure], Cache(tmp_path / "runs"))


def test_a_measure_that_is_not_reached(tmp_path, monkeypatch):
    monkeypatch.setattr(
        computing, "run", lambda spec, directory, **o: bent_beam.write(
            directory, 40.0, 2, size={"nx": 6, "ny": 2, "nz": 7})
    )  # fmt: skip
    with pytest.raises(SpecError, match="failure_pressure_kPa: has no value at the end of the run"):
        converge(SPEC, ["bending_angle_deg", "failure_pressure_kPa"], Cache(tmp_path / "runs"))

"""Orders, limits and error bars of values that are known, and a study of a made-up solver."""

import csv
import json
import re

import bent_beam
import numpy as np
import pytest

from softact import spec as specs
from softact.converge import output
from softact.converge import study as studies
from softact.converge.carry import carry_into
from softact.converge.richardson import SAFETY, estimate
from softact.converge.study import converge, mesh_sizes, refined
from softact.errors import SpecError
from softact.fit.measured import Measured
from softact.output import Output
from softact.report import pictures, write_report
from softact.report.remembered import remember
from softact.results import MESH_ERROR, read
from softact.sweep import compute as computing
from softact.sweep.cache import Cache
from softact.sweep.record import from_results

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
    assert found.changes[0] == pytest.approx(abs((values[1] - values[0]) / values[1]))


@pytest.mark.parametrize(
    ("values", "note"),
    [
        ([10, 12, 11], "up and down"),
        ([10, 11, 12], "do not shrink"),
        ([10, 11, 11], "the same"),
        ([10, 11, 11.000001], "too large"),
    ],
)
def test_values_without_an_order_have_error_bars_all_the_same(values, note):
    found = estimate([4, 2, 1], values)
    assert found.order is None
    assert note in found.note
    assert found.limit == values[-1]
    assert found.errors[0] == SAFETY * max(abs(v - values[0]) for v in values)


def test_what_is_zero_but_for_rounding_has_converged():
    found = estimate([4, 2, 1], [8e-16, -2e-16, 7e-16])
    assert found.changes == (0.0, 0.0)
    assert max(found.errors) < 1e-14


def test_all_mesh_sizes_are_refined_alike():
    spec = specs.loads(
        "geometry: {type: pneunet, mesh_size: 3 mm, cavity_mesh_size: 6 mm}\n"
        "materials: {body: elastosil-m4601}\nsteps: [{name: up, pressure: 1 kPa}]"
    )
    assert mesh_sizes(refined(spec, 1.5)) == {"mesh_size": 2.0, "cavity_mesh_size": 4.0}
    assert refined(spec, 1.0).hash == spec.hash


@pytest.fixture(scope="module")
def studied(tmp_path_factory):
    """A solver that is of second order in its mesh size: 40 (1 + h²/1000) degrees."""

    def run(spec, directory, **options):
        angle = 40 * (1 + spec.geometry.mesh_size**2 / 1000)
        bent_beam.write(directory, angle, 1, size={"nx": 6, "ny": 2, "nz": 7})

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(computing, "run", run)
        patch.setattr(studies, "_edge", lambda spec, record: spec.geometry.mesh_size)
        cache = Cache(tmp_path_factory.mktemp("runs"))
        return converge(SPEC, ["bending_angle_deg"], cache, factor=2.0, jobs=2)


def test_study_refines_until_the_measure_stays(studied):
    """Of 8, 4 and 2 mm, 6.4, 1.6 and 0.4 % too much: changes of 4.8/101.6 and 1.2/100.4."""
    assert [level.sizes["mesh_size"] for level in studied.levels] == [8, 4, 2]
    assert studied.converged
    found = studied.estimate("bending_angle_deg")
    assert found.changes == pytest.approx([4.8 / 101.6, 1.2 / 100.4])
    assert (found.order, found.limit) == (pytest.approx(2), pytest.approx(40))
    # 1.25 times 6.4 % are more than 5 %, 1.25 times 1.6 % are not.
    assert studied.recommended.sizes == {"mesh_size": 4}


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
    folder = result_of(tmp_path / "r", 40.64, refined(SPEC, 2.0))
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
        assert cells == ["°", "40.64", "0.8", "40", "2.00", ""]
        assert "on the mesh of this run (mesh size 4 mm)" in text and "From 3 meshes" in text
        assert (
            "wanted was 5 %. The coarsest mesh within it for every figure: mesh size 4 mm" in text
        )


@pytest.mark.usefixtures("no_drawing")
def test_error_bars_go_with_the_run_that_they_are_of(studied, tmp_path):
    folder = result_of(tmp_path / "r", 42.56, SPEC)
    carry_into(studied, folder)
    assert "± 3.2" in shown(folder)  # 1.25 · 6.4 % of 40°
    verdict = json.loads((folder / "run.json").read_text())["verdict"]
    assert (verdict["colour"], verdict["reasons"][0]["kind"]) == ("amber", "mesh")
    told = json.loads((folder / MESH_ERROR).read_text())
    told["levels"][0]["spec_hash"] = "another"
    (folder / MESH_ERROR).write_text(json.dumps(told))
    write_report(folder)
    assert "±" not in shown(folder) and "belongs to another spec" in shown(folder)
    for torn in ({}, [], told | {"tolerance": "<b>"}, told | {"level": 7}):
        (folder / MESH_ERROR).write_text(json.dumps(torn))
        write_report(folder)
        assert "±" not in shown(folder) and "mesh_error.json cannot be read" in shown(folder)
    result_of(folder, 42.56, SPEC)  # run again: its error bars have to be carried again
    assert not (folder / MESH_ERROR).exists()


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

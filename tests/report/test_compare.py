"""Two result folders in one page: differences are those of the closed forms."""

import csv

import numpy as np
import pytest
from click.testing import CliRunner

from softact.cli.compare import compare as command
from softact.errors import SpecError
from softact.report import compare, requirements, targets
from softact.results.folder import read
from softact.results.writer import ResultsWriter
from tests import bent_beam

SIZE = {"nx": 4, "ny": 2, "nz": 7}


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """The bent beam at 200 degrees and, with another length in its spec, at 100 degrees."""
    top = tmp_path_factory.mktemp("compare")
    bent_beam.write(top / "a" / "beam", 200.0, 8, size=SIZE)
    bent_beam.write(top / "b" / "beam", 100.0, 4, size=SIZE)
    spec = top / "b" / "beam" / "spec.yaml"
    spec.write_text(spec.read_text().replace("length: 120 mm", "length: 130 mm"))
    return [top / "a" / "beam", top / "b" / "beam"]


def test_measures_and_differences(folders):
    aim, rows = compare.measures([read(folder) for folder in folders])
    assert aim == 50.0
    row = next(row for row in rows if row.name == "bending_angle_deg")
    assert row.values == pytest.approx((200.0, 100.0))
    assert row.differences() == pytest.approx([-100.0])
    assert row.percents() == pytest.approx([-50.0])
    assert "pressure_kPa" not in [row.name for row in rows]


def test_the_load_is_the_largest_that_all_reach(folders, tmp_path):
    writer = ResultsWriter(tmp_path / "short", "name: short\n", {})
    for n in range(4):
        writer.increment({"pressure_kPa": 10.0 * n, "bending_angle_deg": 30.0 * n})
    writer.finish("complete")
    aim, rows = compare.measures([read(folders[0]), read(tmp_path / "short")])
    assert aim == 30.0
    row = next(row for row in rows if row.name == "bending_angle_deg")
    assert row.values == pytest.approx((120.0, 90.0))  # 4 and 3 degrees per kPa
    stress = next(row for row in rows if row.name == "max_von_mises_MPa")
    assert np.isnan(stress.values[1]) and np.isnan(stress.percents()[0])


def test_only_what_differs_in_the_specs_is_told(folders):
    found = compare.spec_differences([read(folder) for folder in folders])
    assert found == [("geometry.length", ["120 mm", "130 mm"])]


def test_the_command_writes_page_and_tables(folders, tmp_path):
    done = CliRunner().invoke(command, [*map(str, folders), "-o", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    page = (tmp_path / "out" / "compare.html").read_text()
    assert "a/beam" in page and "130 mm" in page  # named by what tells them apart
    with open(tmp_path / "out" / "measures.csv", newline="") as file:
        rows = {row["measure"]: row for row in csv.DictReader(file)}
    angle = rows["bending_angle_deg"]
    assert float(angle["a/beam"]) == pytest.approx(200)
    assert float(angle["b/beam minus a/beam"]) == pytest.approx(-100)
    assert float(angle["b/beam difference_%"]) == pytest.approx(-50)
    with open(tmp_path / "out" / "curves.csv", newline="") as file:
        runs = [row["run"] for row in csv.DictReader(file)]
    assert (runs.count("a/beam"), runs.count("b/beam")) == (9, 5)


def test_folders_that_will_not_do_are_all_told(folders, tmp_path):
    with pytest.raises(SpecError) as told:
        compare.write_comparison([tmp_path, tmp_path / "none", folders[0]], tmp_path / "out")
    assert len(told.value.lines) == 2
    with pytest.raises(SpecError, match="two result folders or more"):
        compare.write_comparison(folders[:1], tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.fixture(scope="module")
def fingers(tmp_path_factory):
    """One that bends by 2 degrees per kPa to 200, and one that presses with 0.08 N per kPa."""
    top = tmp_path_factory.mktemp("fingers")
    curves = {
        "free": {"bending_angle_deg": 2.0},
        "blocked": {"bending_angle_deg": 0.1, "blocked_force_N": 0.08},
    }
    for name, slopes in curves.items():
        writer = ResultsWriter(top / name, f"name: {name}\n", {})
        for pressure in (0.0, 40.0, 100.0):
            row = {column: slope * pressure for column, slope in slopes.items()}
            writer.increment({"pressure_kPa": pressure, **row})
        writer.finish("complete")
    return [top / "free", top / "blocked"]


def test_requirements_stand_beside_the_runs(fingers, tmp_path):
    """The finger of Nguyen and Zhang: 160 degrees, met by 200 of the free run; 7.3 N, met by 8 of
    the blocked one, which is not asked how far it bends."""
    call = [*map(str, fingers), "-o", str(tmp_path), "--targets", "index_finger"]
    done = CliRunner().invoke(command, call)
    assert done.exit_code == 0, done.output
    assert "Published requirements" in (tmp_path / "compare.html").read_text()
    runs = [read(folder) for folder in fingers]
    angle, force = targets.requirements("index_finger")
    assert (angle.bound, force.bound) == (160.0, 7.3)
    assert [requirements.tells(run, angle, runs) for run in runs] == [True, False]
    assert [requirements.tells(run, force, runs) for run in runs] == [False, True]
    assert requirements.tells(runs[1], angle, [runs[1]] * 2)  # nothing else tells it
    cells = requirements.cells("index_finger", runs)
    assert cells == [["met: 200°", "–"], ["–", "met: 8 N"]]
    plots = requirements.plots(["free", "blocked"], runs, [angle, force])
    for plot, name, values, bound in zip(
        plots, ("free", "blocked"), ([0, 80, 200], [0, 3.2, 8]), (160, 7.3), strict=True
    ):
        run, asked = plot.traces
        assert (run["name"], run["y"]) == (name, pytest.approx(values))
        assert (asked["x"], asked["y"]) == ([0, 100], [bound, bound])


def test_an_application_that_is_not_known(fingers, tmp_path):
    with pytest.raises(SpecError, match="index_finger"):
        compare.write_comparison(fingers, tmp_path / "out", ["index_fingr"])
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("after", "kept"),
    [([20.0], [0, None, 10, 20]), ([5.0, 20.0], [0, None, 5, 20]), ([], [0, None, 10])],
)
def test_a_first_inflation_is_a_motion(after, kept, tmp_path):
    """Of its states the one at the end of the step counts alone, unless an equilibrium has its
    load, and the equilibria after it; no line is drawn over what is left out."""
    writer = ResultsWriter(tmp_path / "r", "name: r\n", {})
    steps = ["fill"] * 3 + [f"step {number}" for number in range(len(after))]
    for number, (step, pressure) in enumerate(zip(steps, [0.0, 5.0, 10.0, *after], strict=True)):
        row = {"step": step, "increment": number, "pressure_kPa": pressure}
        writer.increment({**row, "bending_angle_deg": 2 * pressure})
    controls = ["load", "motion", "motion", *["load"] * len(after)]
    history = [
        {"step": step, "converged": True, "control": how}
        for step, how in zip(steps, controls, strict=True)
    ]
    history.insert(2, {"step": "fill", "converged": False, "control": "motion"})
    writer.finish("complete", provenance={"history": history})
    found = requirements.settled(read(tmp_path / "r"))
    assert list(found.curve["pressure_kPa"]) == [value for value in kept if value is not None]
    (plot,) = requirements.plots(["r"], [found], targets.requirements("index_finger")[:1])
    bent = [value if value is None else 2 * value for value in kept]
    assert (plot.traces[0]["x"], plot.traces[0]["y"]) == (kept, bent)

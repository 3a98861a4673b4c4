"""Studies on modules: their specs, figures, refusals, and the whole actuators that confirm them."""

import csv

import pytest

from softact.errors import SpecError
from softact.modules.module_spec import module_specs
from softact.optimise import optimise_page
from softact.optimise.check import check as check_optimisation
from softact.optimise.spec import Optimisation
from softact.optimise.study import Trials
from softact.results.folder import read as read_results
from softact.results.own_folder import Output
from softact.run.start import run
from softact.spec import spec_at
from softact.sweep import compute as computing
from softact.sweep import output, trends
from softact.sweep.cache import Cache
from softact.sweep.module_point import COARSE
from softact.sweep.spec import Sweep, read
from softact.sweep.study import locally, open_study
from tests import bent_beam

BASE = """
model: module
base:
  geometry: {type: pneunet, chambers: 4, chamber_height: 6 mm, base: 3 mm, mesh_size: 4 mm}
  materials: {body: elastosil-m4601}
  steps: [{name: inflate, pressure: 6 kPa}]
"""
CHAMBERS = "axes: [{path: geometry.chambers, name: chambers, values: [3, 4]}]\n"
WALLS = "axes: [{path: geometry.roof, name: roof, from: 0.8 mm, to: 1.6 mm, count: 5}]\n"
MOST = "objectives: [{measure: bending_angle_deg, goal: maximise}]\n"


def opened(folder, text, model=Sweep):
    file = folder / "study.yaml"
    file.write_text(BASE + text)
    return file, *read(file, model)


def study_of(folder, text):
    file, sweep, base = opened(folder, text)
    study = open_study(sweep, base, Cache(folder / "runs"))
    trends.check(file, study)
    return study


def carried_out(study, folder):
    (folder / "out").mkdir(exist_ok=True)
    rows, _, _ = output.carry_out(
        study, locally(1), None, Output(folder / "out", "sweep"), lambda point, answer: None
    )
    return rows


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    """A sweep of three and of four chambers, the better one confirmed, and its folder."""
    folder = tmp_path_factory.mktemp("modules")
    study = study_of(folder, CHAMBERS + MOST + "blocked: [moment, force]\nconfirm: 1\n")
    return study, carried_out(study, folder), folder


def test_figures_are_those_of_so_many_modules(solved):
    """The module is the same one with three chambers and with four."""
    _, rows, _ = solved
    three, four = rows
    angle = three["module_angle_y_deg"]
    assert angle > 0.5
    assert four["module_angle_y_deg"] == pytest.approx(angle, rel=1e-9)
    for row, count in ((three, 3), (four, 4)):
        assert row["status"] == "complete"
        assert row["bending_angle_deg"] == pytest.approx(count * angle, rel=1e-9)
        assert row["actuator_angle_y_deg"] == pytest.approx(count * angle, rel=1e-12)
    assert four["cavity_volume_mm3"] == pytest.approx(4 / 3 * three["cavity_volume_mm3"], rel=1e-9)
    assert four["max_principal_stress_MPa"] == pytest.approx(three["max_principal_stress_MPa"])
    assert not {"tip_x_mm", "elongation_mm", "chord_angle_deg"} & four.keys()
    assert [row["unbeaten"] for row in rows] == ["no", "yes"]


def test_a_blocked_module_exerts_what_softact_module_says(solved, tmp_path):
    study, rows, _ = solved
    base = spec_at(study.base, study.points[0].changes)
    for kind, mine, theirs in (
        ("straight", "blocked_moment_y_Nmm", "module_moment_y_Nmm"),
        ("clamped", "blocked_force_x_N", "module_force_x_N"),
    ):
        spec = module_specs(base, {}).runs[kind]
        spec = spec.with_({"solver.initial_increment": COARSE, "solver.max_increment": COARSE})
        run(spec, tmp_path / kind, report=False, threads=1)
        expected = -read_results(tmp_path / kind).curve[theirs][-1]
        assert abs(expected) > 0.01
        assert rows[0][mine] == pytest.approx(expected, rel=1e-6)


def test_the_best_is_confirmed_by_the_whole_actuator(solved, tmp_path):
    """Beside a run of the whole. Both ends of four chambers are stiff, so modules bend more."""
    study, rows, folder = solved
    with open(folder / "out/confirmed.csv") as file:
        (line,) = csv.DictReader(file)
    run(spec_at(study.base, study.points[1].changes), tmp_path / "whole", report=False, threads=1)
    whole = read_results(tmp_path / "whole").curve["bending_angle_deg"][-1]
    module = rows[1]["bending_angle_deg"]
    assert (line["point"], line["chambers"], line["status"]) == ("1", "4.0", "complete")
    assert float(line["bending_angle_deg_module"]) == pytest.approx(module, rel=1e-12)
    assert float(line["bending_angle_deg_whole"]) == pytest.approx(whole, rel=1e-9)
    deviation = float(line["bending_angle_deg_deviation_percent"])
    assert deviation == pytest.approx(100 * (module / whole - 1), rel=1e-6)
    assert 0 < deviation < 40
    page = (folder / "out/sweep.html").read_text()
    assert "The best as whole actuators" in page
    assert "Each run is of one module" in page


def test_a_second_call_computes_nothing(solved, monkeypatch):
    study, rows, folder = solved
    monkeypatch.setattr(computing, "run", None)
    again = open_study(study.sweep, study.base, Cache(folder / "runs"))
    assert carried_out(again, folder) == rows
    assert again.computed == 0


@pytest.fixture
def made_up(monkeypatch):
    """A module bends by 10 degrees for each mm of its roof, four of them as a whole by 2 less."""

    def solve(spec, directory, **options):
        alone, angle = spec.geometry.module_alone, 10 * spec.geometry.roof
        bent_beam.write(directory, angle if alone else 4 * angle - 2, 2, size={"nx": 6, "ny": 2})

    monkeypatch.setattr(computing, "run", solve)
    monkeypatch.setattr(
        optimise_page, "write_report", lambda folder: (folder / "report.html").touch()
    )


def test_as_many_as_wanted_are_confirmed(tmp_path, made_up):
    study = study_of(tmp_path, WALLS + MOST + "confirm: 3\n")
    carried_out(study, tmp_path)
    with open(tmp_path / "out/confirmed.csv") as file:
        lines = list(csv.DictReader(file))
    assert [line["roof_mm"] for line in lines] == ["1.6", "1.4", "1.2"]
    for line in lines:
        wholly = 40 * float(line["roof_mm"]) - 2
        assert float(line["bending_angle_deg_whole"]) == pytest.approx(wholly)
        percent = float(line["bending_angle_deg_deviation_percent"])
        assert percent == pytest.approx(100 * 2 / wholly)


def test_a_whole_that_stops_early_is_not_compared(tmp_path, monkeypatch):
    """Its last state is at another load."""

    def solve(spec, directory, **options):
        status = "complete" if spec.geometry.module_alone else "no_equilibrium"
        bent_beam.write(directory, 10, 2, status, size={"nx": 6, "ny": 2})

    monkeypatch.setattr(computing, "run", solve)
    study = study_of(tmp_path, WALLS + MOST + "confirm: 1\n")
    carried_out(study, tmp_path)
    with open(tmp_path / "out/confirmed.csv") as file:
        (line,) = csv.DictReader(file)
    assert line["status"] == "no_equilibrium"
    assert line["bending_angle_deg_module"] == "40.0"
    assert line["bending_angle_deg_whole"] == line["bending_angle_deg_deviation_percent"] == ""


def test_an_optimisation_confirms_its_best(tmp_path, made_up):
    text = WALLS.replace("axes", "parameters").replace(", count: 5", "") + MOST
    limit = "constraints: [{measure: bending_angle_deg, below: 50}]\n"
    file, wanted, base = opened(tmp_path, f"{text}{limit}trials: 8\nconfirm: 2\n", Optimisation)
    check_optimisation(file, wanted, base)
    trials = Trials(wanted, base, Cache(tmp_path / "runs"), tmp_path)
    trials.run(1, lambda trial, answer: None)
    told = []
    trials.confirm(1, lambda point, answer: told.append(answer.status))
    assert told == ["complete"] * 2
    (best,) = trials.best()
    assert best.values[0] <= 50
    found, _ = (each.candidate for each in trials.confirmed)
    assert found.number == best.number
    path = optimise_page.write(trials, Output(tmp_path, "optimize"))
    assert "The best as whole actuators" in path.read_text()
    with open(tmp_path / "confirmed.csv") as lines:
        line = next(csv.DictReader(lines))
    assert float(line["bending_angle_deg_whole"]) == pytest.approx(best.values[0] - 2)


def test_the_point_of_a_module_is_a_short_run(tmp_path):
    _, sweep, base = opened(tmp_path, WALLS)
    spec = sweep.spec_at(base)
    assert spec.geometry.module_alone
    assert spec.solver.max_increment == COARSE
    assert "module_stiffness" not in spec.measures
    assert "module" in spec.measures
    given = sweep.spec_at(base, [("solver.max_increment", 0.1), ("measures", ["stress"])])
    assert given.solver.max_increment == 0.1
    assert given.measures == ("stress", "module")


def test_keys_are_others_than_those_of_lone_modules(tmp_path):
    """A kept run's figures are those of the actuator, and with what a blocked one exerts."""
    keys = set()
    for more in ("", "blocked: [moment]\n", "blocked: [force]\n"):
        study = study_of(tmp_path, WALLS + more)
        keys |= {point.key for point in study.points}
    assert len(keys) == 15


@pytest.mark.parametrize(
    ("more", "line"),
    [
        (
            "set: {contact: [{self: outer, friction: 0.2}]}",
            "model: module: contact.0.friction: modules touch each other without friction",
        ),
        ("set: {steps.inflate.gravity: [0, 0, -1]}", "model: module: steps.0.gravity: weight"),
        (
            "set: {steps.inflate.payload: [{surface: tip, force: [0 N, 0 N, 1 N]}]}",
            "model: module: steps.0.payload: a payload hangs on one place",
        ),
        ("set: {geometry.chambers: 1}", "model: module: geometry.chambers: one chamber is no"),
        ("set: {geometry.module_alone: true}", "model: the base is one module already"),
        ("confirm: 3", "confirm: which points are the best?"),
        ("blocked: [moment, moment]", "blocked: names one of them twice"),
        ("design: tolerances", "model: the design tolerances compares with derivatives"),
        (MOST.replace("bending_angle_deg", "reaction_moment_y_Nmm"), "is of the ends of an"),
        (MOST.replace("bending_angle_deg", "tip_x_mm"), "is of the ends of an actuator"),
        (MOST.replace("bending_angle", "bending_angel"), "did you mean 'bending_angle_deg'?"),
        (MOST.replace("bending", "twist").replace("twist_angle", "actuator_angle_x"), "no such"),
        (MOST.replace("bending_angle_deg", "blocked_moment_y_Nmm"), "write 'blocked: [moment]'"),
        (
            MOST.replace("bending_angle_deg", "module_stiffness_stretch_x_stretch_x_N"),
            "unless 'measures' in the base names module_stiffness",
        ),
    ],
)
def test_what_no_module_has_is_refused_in_one_line(tmp_path, more, line):
    axes = "" if "tolerances" in more else WALLS
    with pytest.raises(SpecError) as refused:
        study_of(tmp_path, f"{axes}{more}\n")
    assert len(refused.value.lines) == 1
    assert line in refused.value.lines[0]


def test_what_has_no_module_is_refused(tmp_path):
    (tmp_path / "study.yaml").write_text("""
model: module
base:
  geometry: {type: thick_sphere}
  materials: {body: elastosil-m4601}
  supports: []
  steps: [{name: press, pressure: 1 kPa}]
axes: [{path: geometry.mesh_size, values: [3 mm, 4 mm]}]
""")
    sweep, base = read(tmp_path / "study.yaml", Sweep)
    with pytest.raises(
        SpecError, match=r"model: module: geometry\.type: thick_sphere has no module"
    ):
        open_study(sweep, base, Cache(tmp_path / "runs"))


@pytest.mark.parametrize("key", ["confirm: 2", "blocked: [force]"])
def test_whole_actuators_are_neither_blocked_nor_confirmed(tmp_path, key):
    (tmp_path / "study.yaml").write_text(BASE.replace("module", "full") + WALLS + f"{key}\n")
    with pytest.raises(SpecError, match="is for 'model: module'"):
        read(tmp_path / "study.yaml", Sweep)


def test_gradients_are_refused(tmp_path):
    text = WALLS.replace("axes", "parameters") + MOST + "method: gradient\n"
    with pytest.raises(SpecError, match="model: a module has no derivatives yet"):
        opened(tmp_path, text, Optimisation)

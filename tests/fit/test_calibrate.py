"""`softact calibrate`: known constants are found again, and wrong data is told in plain lines.

The runs of the search tests are formulas; one test solves in earnest.
"""

import csv
import json
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.image import imread

from softact.cli import main as cli
from softact.files.text import csv_text, json_text
from softact.fit.calibrate import calibrate
from softact.fit.calibration import CalibrationRequest
from softact.fit.knobs import read_knobs
from softact.measured.curve import Measured, meaning, predicted
from softact.run.start import run
from softact.spec import load
from softact.sweep import compute as computing
from softact.sweep.cache import Cache

SPEC = """\
name: finger
geometry: {type: pneunet, chambers: 2, mesh_size: 6 mm}
materials: {body: {law: yeoh, c10: 0.11 MPa, c20: 0.02 MPa}}
steps:
  - {name: gravity, gravity: [0, 0, -1]}
  - {name: inflate, pressure: 30 kPa}
measures: [pressure, bending]
"""
BLOCK = """\
name: bar
geometry: {type: block, mesh_size: 10 mm}
materials: {body: {law: yeoh, c10: 0.13 MPa, c20: 0.02 MPa, poissons_ratio: 0.49}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps:
  - {supports: [{surface: x_min, fix: [x, y, z]}, {surface: x_max, move: {x: 8 mm}}]}
solver: {initial_increment: 0.5, max_increment: 0.5}
measures: [elongation, reaction]
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "finger.yaml").write_text(SPEC)
    return tmp_path


def angle(pressure, c10, c20):
    """A finger as a formula: softer than linear at first, stiffer at the end."""
    return 0.08 * pressure / c10 * np.exp(-0.3 * c20 / c10 * pressure / 30)


def write_data(path, c10, c20, pressures=(3, 8, 14, 20, 26, 30), noise=0.0):
    pressures = np.array(pressures, float)
    angles = angle(pressures, c10, c20)
    angles = angles + noise * np.random.default_rng(0).standard_normal(len(angles))
    rows = [f"{p / 100},{np.radians(a)}" for p, a in zip(pressures, angles, strict=True)]
    path.write_text("\n".join(["pressure (bar),Bending angle [rad]", *rows]))


@pytest.fixture
def formula(monkeypatch):
    """Replaces the solver by the formula; returns the list of solved (c10, c20)."""
    solved, ends, carried = [], {"at": 30.0}, []

    def run(spec, directory, **options):
        body = spec.materials["body"]
        solved.append((body.c10, body.c20))
        directory.mkdir(parents=True)
        rows = [dict(step="gravity", pressure_kPa=0.0, bending_angle_deg=v) for v in (0.0, 0.0)]
        pressures = np.linspace(0, 30, 11)[1:]
        rows += [
            dict(step="inflate", pressure_kPa=p, bending_angle_deg=angle(p, body.c10, body.c20))
            for p in pressures[pressures <= ends["at"]]
        ]
        (directory / "curve.csv").write_text(csv_text(rows))
        if carried and options.get("sensitivities"):
            table = slopes(options["sensitivities"], rows, body.c10, body.c20)
            (directory / "sensitivities.csv").write_text(csv_text(table))
        ended = {"status": "complete"}
        if ends["at"] < 30:
            ended = {"status": "no_equilibrium", "messages": ["no equilibrium"]}
        (directory / "run.json").write_text(json_text(ended))

    monkeypatch.setattr(computing, "run", run)
    return SimpleNamespace(solved=solved, ends=ends, carried=carried)


def slopes(paths, rows, c10, c20):
    """Derivatives of the formula's angle by c10 and c20, as a run writes them: per kPa."""
    table = []
    for number, row in enumerate(rows):
        p, value = row["pressure_kPa"], row["bending_angle_deg"]
        x = 0.3 * p / 30  # angle = 0.08 p / c10 exp(−x c20 / c10)
        by = {"c10": value * (x * c20 / c10 - 1) / c10, "c20": -value * x / c10}
        for path in paths:
            of, one = path.rpartition(".")[2], {"increment": number, "parameter": path}
            at = f"{1e3 * {'c10': c10, 'c20': c20}[of]:.10g} kPa"
            for measure, slope in (("pressure_kPa", 0.0), ("bending_angle_deg", by[of] / 1e3)):
                table.append({**one, "measure": measure, "at": at, "derivative": slope,
                              "unit": "", "elasticity": ""})  # fmt: skip
    return table


def softact(capsys, *arguments):
    with pytest.raises(SystemExit) as stop:
        cli.main(["calibrate", *arguments])
    out = capsys.readouterr()
    return stop.value.code, out.out, out.err


VARY = ("--vary", "materials.body.c10", "--vary", "materials.body.c20")


def test_two_constants_are_found_in_few_runs(folder, formula, capsys):
    write_data(folder / "angle.csv", 0.14, 0.03)
    code, out, _ = softact(capsys, "finger.yaml", "--data", "angle.csv", *VARY, "-o", "out")
    assert code == 0
    assert len(formula.solved) == len(set(formula.solved)) <= 15
    assert out.count("run ") >= len(formula.solved)
    numbers = json.loads((folder / "out" / "calibration.json").read_text())
    found = numbers["constants"]
    assert found["materials.body.c10"]["value"] == pytest.approx(140, rel=2e-3)  # kPa
    assert found["materials.body.c20"]["value"] == pytest.approx(30, rel=1e-2)
    assert numbers["rmse_after"]["bending_angle_deg"] < 1e-3
    assert numbers["rmse_before"]["bending_angle_deg"] == pytest.approx(
        np.sqrt(np.mean([(angle(p, 0.11, 0.02) - angle(p, 0.14, 0.03)) ** 2
                         for p in (3, 8, 14, 20, 26, 30)])), rel=1e-3)  # fmt: skip
    body = load(folder / "out" / "finger.yaml").materials["body"]
    assert 1e3 * body.c10 == pytest.approx(found["materials.body.c10"]["value"])
    with open(folder / "out" / "curves.csv") as file:
        rows = list(csv.DictReader(file))
    assert float(rows[2]["measured_bending_angle_deg"]) == pytest.approx(angle(14, 0.14, 0.03))
    assert float(rows[2]["after_bending_angle_deg"]) == pytest.approx(angle(14, 0.14, 0.03), 1e-3)
    assert imread(folder / "out" / "calibration.png").std() > 0.05
    assert (folder / "out" / "run" / "curve.csv").is_file()


def test_the_runs_own_derivatives_take_at_most_half_of_the_runs(folder, formula, capsys):
    """The same synthetic data, once by differences of runs and once with what the runs carry."""
    write_data(folder / "angle.csv", 0.14, 0.03)
    counts, constants = [], []
    for name in ("differences", "own"):
        formula.solved.clear()
        formula.carried += [True] if name == "own" else []
        code, _, _ = softact(
            capsys, "finger.yaml", "--data", "angle.csv", *VARY, "-o", name, "--cache", f"c_{name}"
        )
        assert code == 0
        numbers = json.loads((folder / name / "calibration.json").read_text())
        assert numbers["rmse_after"]["bending_angle_deg"] < 1e-3
        counts.append(len(formula.solved))
        constants.append([v["value"] for v in numbers["constants"].values()])
    assert counts[1] <= counts[0] / 2
    assert constants[1] == pytest.approx([140, 30], rel=1e-2)


def test_the_covariance_is_that_of_many_repetitions(folder, formula):
    """Of 40 measurements with other noise, each calibrated: the scatter of what is found."""
    formula.carried.append(True)
    pressures, found, told = np.arange(2.0, 31.0), [], []
    rng = np.random.default_rng(1)
    clean, spec = angle(pressures, 0.14, 0.03), load(folder / "finger.yaml")
    request = CalibrationRequest(folder / "finger.yaml", folder / "angle.csv", VARY[1::2])
    knobs = read_knobs(request.vary, spec)
    for _ in range(40):
        noisy = clean + 0.1 * rng.standard_normal(len(pressures))
        values = {"pressure_kPa": pressures, "bending_angle_deg": noisy}
        measured = Measured("angle.csv", "pressure_kPa", values)
        outcome = calibrate(request, spec, measured, knobs, list().append, Cache(folder / "runs"))
        found.append(outcome.best.values)
        told.append(outcome.covariance)
    sampled, mean = np.cov(np.array(found).T), np.mean(told, axis=0)
    # 40 repetitions tell a variance to ± 23 %.
    assert np.diag(mean) == pytest.approx(np.diag(sampled), rel=0.5)
    correlation = [c[0, 1] / np.sqrt(c[0, 0] * c[1, 1]) for c in (sampled, mean)]
    assert correlation[1] == pytest.approx(correlation[0], abs=0.1)
    assert abs(correlation[1]) > 0.5


def test_the_interval_holds_the_truth_and_grows_with_the_noise(folder, formula, capsys):
    halves = []
    for noise in (0.05, 0.5):
        write_data(folder / "angle.csv", 0.14, 0.02, range(2, 30), noise)
        softact(capsys, "finger.yaml", "--data", "angle.csv", *VARY[:2], "-o", "out")
        found = json.loads((folder / "out" / "calibration.json").read_text())["constants"]
        entry = found["materials.body.c10"]
        halves.append(entry["confidence_95"])
        assert abs(entry["value"] - 140) < 2 * entry["confidence_95"]
    assert halves[1] == pytest.approx(10 * halves[0], rel=0.3)


def test_a_bound_is_kept_and_told(folder, formula, capsys):
    write_data(folder / "angle.csv", 0.14, 0.02)
    knob = "materials.body.c10=0.1 MPa..120 kPa"
    code, out, _ = softact(capsys, "finger.yaml", "--data", "angle.csv", "--vary", knob)
    assert code == 0
    assert "materials.body.c10 is at a bound" in out
    assert max(c10 for c10, _ in formula.solved) <= 0.12 * (1 + 1e-9)


def test_the_number_of_runs_is_limited(folder, formula, capsys):
    write_data(folder / "angle.csv", 0.14, 0.03)
    code, out, _ = softact(
        capsys, "finger.yaml", "--data", "angle.csv", *VARY, "--max-runs", "4"
    )  # fmt: skip
    assert (code, len(formula.solved)) == (0, 4)
    assert "stopped after 4 runs" in out


def test_a_run_that_ends_early_is_told(folder, formula, capsys):
    write_data(folder / "angle.csv", 0.14, 0.03)
    formula.ends["at"] = 12.0
    code, _, err = softact(capsys, "finger.yaml", "--data", "angle.csv", *VARY)
    assert code == 4
    assert (
        "no equilibrium" in err
        and "pressure_kPa goes from 3 to 30, the run only from 0 to 12" in err
    )
    assert not (folder / "results/finger-calibrated").exists()


WRONG_DATA = {
    "an unknown column": ("pressure_kPa,angle\n1,2\n", "'angle' is no column of a run; did you"),
    "no unit": ("pressure,bending_angle_deg\n1,2\n", "names no unit; write for example 'pressure_"),
    "another unit": (
        "pressure mm,bending_angle_deg\n1,2\n",
        "'mm' is a length, and a unit such as",
    ),
    "one column": ("pressure_kPa\n1\n", "two columns or more are wanted"),
    "the same twice": ("pressure_kPa,pressure bar\n1,2\n", "two columns are pressure_kPa"),
    "words": (
        "pressure_kPa,bending_angle_deg\n1,x\n",
        "bad.csv:2: column 'bending_angle_deg': 'x'",
    ),
    "not a number": ("pressure_kPa,bending_angle_deg\n1,inf\n", "'inf' is not a finite number"),
    "no value": ("pressure_kPa,bending_angle_deg\n1,nan\n", "no row has a value in every column"),
    "no rows": ("pressure_kPa,bending_angle_deg\n", "headings but no values"),
    "zeros": ("pressure_kPa,bending_angle_deg\n1,0\n2,0\n", "zero throughout"),
    "no curve": ("pressure_kPa,bending_angle_deg\n1,3\n1,4\n", "the same in all rows"),
    "one point": ("pressure_kPa,bending_angle_deg\n1,3\n2,4\n", None),
}


@pytest.mark.parametrize("case", WRONG_DATA)
def test_wrong_data_is_told_before_any_run(case, folder, formula, capsys):
    text, told = WRONG_DATA[case]
    (folder / "bad.csv").write_text(text)
    vary = VARY if told else (*VARY, "--vary", "geometry.roof")
    code, out, err = softact(capsys, "finger.yaml", "--data", "bad.csv", *vary)
    assert code == 2
    assert (told or "2 values do not determine 3 constants") in err
    assert (out, formula.solved) == ("", [])


WRONG_KNOBS = {
    "materials.body.c1": "materials.body has no value 'c1'; did you mean 'c10'?",
    "materials.body": "stands for several values",
    "geometry.chambers": "'2' is no value that can be varied",
    "materials.body.c30": "is 0 in the spec; give bounds",
    "materials.body.c10=1 kPa": "are no bounds; write LOW..HIGH",
    "materials.body.c10=1 kPa..2 mm": "'mm' is a length",
    "materials.body.c10=200 kPa..300 kPa": "110 kPa is not between the bounds",
    "materials.body.c10=200 kPa..100 kPa": "is not below the upper one",
    "geometry.outer_wall=-1 mm..2 mm": "at the bound --set geometry.outer_wall=-1 mm",
    "geometry.mesh_size": "says how fine the mesh is",
    "geometry.through_wall": "says how fine the mesh is",
    "steps.deflate.pressure": "'steps' has no entry 'deflate' (it has 2 entries, counted from 0)",
}


@pytest.mark.parametrize("knob", WRONG_KNOBS)
def test_a_value_that_cannot_be_varied_is_told(knob, folder, formula, capsys):
    write_data(folder / "angle.csv", 0.14, 0.03)
    code, out, err = softact(capsys, "finger.yaml", "--data", "angle.csv", "--vary", knob)
    assert code == 2
    assert err.startswith("--vary ") and WRONG_KNOBS[knob] in err
    assert (out, formula.solved) == ("", [])


def test_knobs_are_found_by_the_name_of_a_step_and_in_a_card(folder):
    options = ["steps.inflate.pressure.cavity=10 kPa..0.05 MPa", "materials.body.c10"]
    spec = load(folder / "finger.yaml", ["materials.body=elastosil-m4601"])
    pressure, c10 = read_knobs(options, spec)
    assert (pressure.value, pressure.unit, pressure.low, pressure.high) == (30, "kPa", 10, 50)
    assert (c10.text(c10.value), c10.low, c10.high) == ("110 kPa", 11, 1100)


def test_headings():
    columns = ["pressure_upper_kPa", "cavity_volume_mm3", "reaction_moment_x_Nmm", "step_fraction"]
    assert meaning("Pressure upper (MPa)", columns) == ("pressure_upper_kPa", 1e3)
    assert meaning("cavity volume mL", columns) == ("cavity_volume_mm3", 1e3)
    assert meaning("reaction_moment_x N*m", columns) == ("reaction_moment_x_Nmm", 1e3)
    assert meaning("step fraction", columns) == ("step_fraction", 1.0)


def test_the_curve_between_increments_and_of_the_right_step():
    """A cubic is met within 1e-3 between 10 increments; a vacuum runs backwards."""
    x = -np.linspace(0, 1, 11)
    curve = {
        "step": np.array(["gravity"] * 3 + ["suck"] * 10, dtype=object),
        "pressure_kPa": np.concatenate([[0.0, 0.0], x]),
        "bending_angle_deg": np.concatenate([[5.0, 3.0], x + x**3]),
    }
    wanted = np.array([-0.05, -0.37, -0.98])
    measured = Measured("m.csv", "pressure_kPa", {"pressure_kPa": wanted,
                                                  "bending_angle_deg": wanted})  # fmt: skip
    found = predicted(curve, measured)["bending_angle_deg"]
    np.testing.assert_allclose(found, wanted + wanted**3, atol=1e-3)
    further = Measured("m.csv", "pressure_kPa", {"pressure_kPa": 1.1 * x, "bending_angle_deg": x})
    assert predicted(curve, further) is None


def test_a_real_block_is_calibrated_within_one_percent(folder, capsys):
    """A clamped bar pulled to a stretch of 1.8: force over elongation gives C10 back."""
    (folder / "bar.yaml").write_text(BLOCK)
    truth = load(folder / "bar.yaml", ["materials.body.c10=0.15 MPa"])
    run(truth, folder / "truth", report=False)
    with open(folder / "truth" / "curve.csv") as file:
        rows = [(float(r["elongation_mm"]), r["reaction_x_N"]) for r in csv.DictReader(file)]
    table = [f"{x / 10};{force}" for x, force in rows[1:]]
    (folder / "pull.csv").write_text("\n".join(["elongation cm;reaction x N", *table]))
    code, out, err = softact(
        capsys, "bar.yaml", "--data", "pull.csv", "--vary", "materials.body.c10", "-o", "out",
        "--max-runs", "3",
    )  # fmt: skip
    assert (code, err) == (0, "")
    assert "by differences" not in out  # the abscissa is what is prescribed
    assert load(folder / "out" / "bar.yaml").materials["body"].c10 == pytest.approx(0.15, rel=0.01)
    assert json.loads((folder / "out" / "run" / "run.json").read_text())["status"] == "complete"
    assert not (folder / "out" / "run" / "report.html").exists()


def test_columns_are_named_where_the_data_have_other_headings(folder, formula, capsys):
    write_data(folder / "angle.csv", 0.14, 0.03)
    text = (folder / "angle.csv").read_text().replace("pressure (bar),Bending angle [rad]", "p,phi")
    (folder / "angle.csv").write_text(text)
    code, _, err = softact(capsys, "finger.yaml", "--data", "angle.csv", *VARY)
    assert code == 2 and formula.solved == []
    assert "read it with: softact calibrate finger.yaml --data angle.csv --vary materials" in err
    assert "--columns 'pressure_kPa, bending_angle_deg'" in err
    names = "pressure bar, bending angle rad"
    code, _, _ = softact(
        capsys, "finger.yaml", "--data", "angle.csv", "--columns", names, *VARY, "-o", "out"
    )
    assert code == 0
    numbers = json.loads((folder / "out" / "calibration.json").read_text())
    assert numbers["constants"]["materials.body.c10"]["value"] == pytest.approx(140, rel=2e-3)

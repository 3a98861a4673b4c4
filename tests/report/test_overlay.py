"""A measured curve over a run's: the deviations are those that were put in."""

import numpy as np
import pytest
from click.testing import CliRunner

from softact import spec as specs
from softact.cli.report import report
from softact.cli.run import run
from softact.errors import SpecError
from softact.measured.curve import Measured, read_measured
from softact.report import overlay, pictures, write_report
from softact.report.remembered import remembered
from softact.results.folder import MEASURED, read
from softact.run import start as runs
from tests import bent_beam

ANGLE, INCREMENTS = 200.0, 8  # in proportion to the pressure, 50 kPa at the end


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    directory = tmp_path_factory.mktemp("overlay") / "beam"
    bent_beam.write(directory, ANGLE, INCREMENTS, size={"nx": 4, "ny": 2, "nz": 7})
    return directory


def measured(tmp_path, text, headings=None):
    path = tmp_path / "angle.csv"
    path.write_text(text)
    return path, ["pressure_kPa", "bending_angle_deg", "tip_x_mm"], headings


def test_deviations_are_those_that_were_put_in(folder, tmp_path):
    # The run: 400 degrees per bar. Measured 43 to 163 degrees, so a tenth of the range is 12, and
    # a difference of 12 is not more than that.
    apart = np.array([-3.0, 0.0, 4.0, 12.0, 17.0])
    bar = np.array([0.1, 0.2, 0.3, 0.35, 0.45])
    rows = [
        f"{float(p)!r},{float(a)!r}"
        for p, a in zip(bar, np.radians(400 * bar - apart), strict=True)
    ]
    text = "Pressure (bar), Bending angle / rad\n" + "\n".join(rows) + "\n"
    found = read_measured(*measured(tmp_path, text)[:2])
    (d,) = overlay.deviations(read(folder).curve, found)
    assert d.span == pytest.approx(120.0)
    assert (d.count, d.compared) == (5, 5)
    assert d.rmse == pytest.approx(np.sqrt(np.mean(apart**2)))
    assert (d.largest, d.largest_at) == pytest.approx((17.0, 45.0))
    assert d.parts_at == pytest.approx(45.0)


def test_points_beyond_the_run_are_counted_and_left_out(folder, tmp_path):
    text = "pressure_kPa;bending_angle_deg\n25;101\n50;201\n60;500\n"
    found = read_measured(*measured(tmp_path, text)[:2])
    (d,) = overlay.deviations(read(folder).curve, found)
    assert (d.count, d.compared) == (3, 2)
    assert (d.rmse, d.largest, d.parts_at) == pytest.approx((1.0, -1.0, None))
    assert "1 of 3 points beyond the run" in overlay.tell(d)


def test_headings_given_beside_the_file(folder, tmp_path):
    path, columns, _ = measured(tmp_path, "# no headings\n0.010,40\n0.030,120\n")
    found = read_measured(path, columns, headings=["pressure N/mm2", "bending_angle degrees"])
    (d,) = overlay.deviations(read(folder).curve, found)
    assert (d.compared, d.rmse) == (2, pytest.approx(0, abs=1e-9))
    with pytest.raises(SpecError, match=r"angle.csv:2: the table has no headings"):
        read_measured(path, columns)


def test_the_command_draws_and_tells(folder, tmp_path):
    path, _, _ = measured(
        tmp_path, "pressure_kPa,bending_angle_deg,tip_x_mm\n10,42,100\n40,158,50\n"
    )
    done = CliRunner().invoke(report, [str(folder), "--measured", str(path)])
    assert done.exit_code == 0, done.output
    assert "bending_angle_deg" in done.output and "RMSE 2°" in done.output
    page = (folder / "report.html").read_text()
    assert "Against measurement" in page and "Bending angle: run and measurement" in page
    assert "deviations.csv" in page


@pytest.fixture
def no_drawing(monkeypatch):
    monkeypatch.setattr(pictures, "drawing", bent_beam.undrawn)


def call(folder, *options):
    """What `softact report` says, and the page."""
    done = CliRunner().invoke(report, [str(folder), *map(str, options)])
    assert done.exit_code == 0, done.output
    return done.output, (folder / "report.html").read_text()


@pytest.mark.usefixtures("no_drawing")
def test_every_later_report_shows_what_was_measured(tmp_path):
    """In any unit, also when the file is gone; a file is replaced by itself; and forgotten only
    when that is asked for."""
    bent_beam.write(tmp_path / "r", ANGLE, INCREMENTS, size={"nx": 4, "ny": 2, "nz": 7})
    one, other = tmp_path / "one.csv", tmp_path / "other.csv"
    one.write_text("Pressure (bar), Bending angle (deg)\n0.1,42\n0.4,158\n")
    other.write_text("pressure_kPa,tip_x_mm\n10,100\n40,50\n")
    call(tmp_path / "r", "--measured", one)
    call(tmp_path / "r", "--measured", other)
    one.unlink()
    said, page = call(tmp_path / "r")
    assert "RMSE 2°" in said and "against" in said and "other.csv" in said
    assert "Bending angle: run and measurement" in page and "Tip x: run and measurement" in page
    one.write_text("pressure_kPa,bending_angle_deg\n10,45\n40,155\n")
    said, _ = call(tmp_path / "r", "--measured", one)
    assert "RMSE 5°" in said and "RMSE 2°" not in said
    said, page = call(tmp_path / "r", "--forget-measured")
    assert "RMSE" not in said and "Against measurement" not in page


@pytest.mark.usefixtures("no_drawing")
@pytest.mark.parametrize("text", ["torn", "{}", '{"curves": [{"source": "a", "x": "b"}]}'])
def test_a_damaged_copy_is_told_and_the_report_stands(tmp_path, text):
    bent_beam.write(tmp_path / "r", ANGLE, 2, size={"nx": 4, "ny": 2, "nz": 7})
    (tmp_path / "r" / MEASURED).write_text(text)
    page = write_report(tmp_path / "r").read_text()
    assert "measured.json: cannot be read; delete it" in page and "Key figures" in page


def test_a_run_keeps_what_was_measured(tmp_path):
    """From the moment its folder is there, and through a resumed run; a new run begins anew."""
    text = """
    geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
    materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
    steps: [{name: pull, traction: {surface: x_max, value: [10 kPa, 0 kPa, 0 kPa]}}]
    """
    values = {"step_fraction": np.array([0.5, 1.0]), "elongation_mm": np.array([0.02, 0.04])}
    curve = Measured("pull.csv", "step_fraction", values)
    runs.run(specs.loads(text), tmp_path / "r", report=False, measured=[curve])
    (found,) = remembered(tmp_path / "r")
    assert (found.source, found.x) == (curve.source, curve.x)
    assert {name: list(column) for name, column in found.values.items()} == {
        name: list(column) for name, column in values.items()
    }
    further = specs.loads(text.replace("10 kPa", "20 kPa"))
    runs.run(further, tmp_path / "r", report=False, resume=True)
    assert len(remembered(tmp_path / "r")) == 1
    runs.run(specs.loads(text), tmp_path / "r", report=False)
    assert remembered(tmp_path / "r") == []


@pytest.mark.parametrize(
    "text, fault",
    [
        ("pressure_kPa,bending_angle_N\n1,2\n2,3\n", "'bending_angle_N'"),
        ("pressure_kPa,colour\n1,2\n", "'colour' is no column of a run"),
        ("pressure_kPa,bending_angle_deg\n1,x\n", "angle.csv:2: column 'bending_angle_deg'"),
        ("pressure_kPa,bending_angle_deg\n", "no values"),
    ],
)
def test_wrong_tables_are_told(folder, tmp_path, text, fault):
    path, columns, _ = measured(tmp_path, text)
    with pytest.raises(SpecError, match=fault.replace("(", r"\(")):
        read_measured(path, columns)


def test_run_reads_the_file_before_it_solves(tmp_path):
    arguments = ["configs/pneunet_small.yaml", "-o", str(tmp_path / "r"), "--measured", "nope.csv"]
    done = CliRunner().invoke(run, arguments)
    assert isinstance(done.exception, SpecError)
    assert "nope.csv: there is no such file" in str(done.exception)
    assert not (tmp_path / "r").exists()


def test_run_says_how_it_would_read_a_file_with_other_headings(tmp_path):
    path = tmp_path / "angle.csv"
    path.write_text("p (kPa),phi\n10,42\n40,158\n")
    spec = "configs/pneunet_small.yaml"
    done = CliRunner().invoke(run, [spec, "-o", str(tmp_path / "r"), "--measured", str(path)])
    assert isinstance(done.exception, SpecError)
    assert (
        f"read it with: softact run {spec} --measured {path} --columns "
        "'pressure_kPa, bending_angle_deg'" in str(done.exception)
    )
    assert not (tmp_path / "r").exists()


def test_what_was_left_out_of_a_measured_file_is_told(folder, tmp_path):
    path, _, _ = measured(tmp_path, "pressure_kPa;bending_angle_deg\n10;42\n20;N/A\n40;158,0\n")
    done = CliRunner().invoke(report, [str(folder), "--measured", str(path)])
    assert done.exit_code == 0, done.output
    assert "1 of 3 rows lack a value and are left out, first line 3" in done.output
    assert "RMSE 2°" in done.output

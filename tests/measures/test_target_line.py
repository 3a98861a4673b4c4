"""A line of the actuator and the points that it is to pass."""

from __future__ import annotations

import numpy as np
import pytest

from softact import spec as specs
from softact.errors import SoftactError, SpecError
from softact.measures.target_line import distances
from softact.results.folder import read
from softact.run.start import run
from softact.sensitivities import stored
from tests.tolerances.test_sweep import stretch

BAR = """
geometry: {type: block, length: 10 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
materials: {body: {law: neo_hookean, c10: 20 kPa}}
supports: [{surface: x_min, fix: [x]}, {surface: y_min, fix: [y]}, {surface: z_min, fix: [z]}]
solver: {initial_increment: 1, max_increment: 1}
measures: [tip, target_line]
target_line: {file: FILE, through: [3 mm, 0 mm, 0 mm]}
steps: [{name: pull, traction: {surface: x_max, value: [10 kPa, 0 kPa, 0 kPa]}}]
"""


def test_distances_to_straight_pieces():
    """Beside a piece, beyond an end, and at a corner from outside."""
    line = np.array([[0.0, 0, 0], [4, 0, 0], [4, 0, -3]])
    points = np.array([[1.0, 0, 2], [-3, 4, 0], [7, 0, 4], [4, 0, -2]])
    assert distances(points, line[:-1], line[1:]) == pytest.approx([2, 5, 5, 0])


def test_distances_of_a_bar_that_is_pulled_and_their_derivatives(tmp_path):
    """The axis of the bar stays where it is and its end goes to λ L: a point 3 mm beside it is 3 mm
    away, one 5 mm beyond that end and on the axis x − λ L, whose derivative by L is −λ and by c10
    −L dλ/dc10."""
    end = 10 * stretch(20.0)
    (tmp_path / "line.csv").write_text(f"x (cm),z (mm)\n0.5,3\n{(end + 5) / 10!r},0\n")
    spec = specs.loads(BAR.replace("FILE", str(tmp_path / "line.csv")))
    paths = ("geometry.length", "materials.body.c10")
    run(spec, tmp_path / "run", report=False, threads=1, sensitivities=paths)
    curve = read(tmp_path / "run").curve
    assert curve["tip_x_mm"][-1] == pytest.approx(end, rel=1e-4)
    assert curve["target_distance_max_mm"][-1] == pytest.approx(5.0, abs=2e-3)
    assert curve["target_distance_p8_mm"][-1] == pytest.approx(
        ((3**8 + 5**8) / 2) ** (1 / 8), abs=2e-3
    )
    assert curve["target_distance_rms_mm"][-1] == pytest.approx(np.sqrt(17.0), abs=2e-3)
    found = {
        s.parameter: s.derivative
        for s in stored.read(tmp_path / "run")
        if s.row == 1 and s.measure == "target_distance_max_mm"
    }
    slope = (stretch(20.01) - stretch(19.99)) / 0.02
    assert found["geometry.length"] == pytest.approx(-stretch(20.0), rel=1e-3)
    assert found["materials.body.c10"] == pytest.approx(-10 * slope, rel=2e-3)


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (None, "line.csv: cannot be read"),
        ("x (mm),z (mm)\n1,2\n", "two rows are wanted"),
        ("x,z\n1,2\n3,4\n", "'x' has no unit"),
        ("x (mm),z (kPa)\n1,2\n3,4\n", "z (kPa)"),
        ("x (mm),x (mm)\n1,2\n3,4\n", "once for each axis"),
        ("x (mm),z (mm)\n1,2\n3\n", "row 3 has 1 cells, and the header 2"),
        ("x (mm),z (mm)\n1,2\n3,nan\n", "row 3 holds"),
    ],
)
def test_a_file_that_is_no_line_is_told_in_a_line(tmp_path, content, why):
    if content is not None:
        (tmp_path / "line.csv").write_text(content)
    with pytest.raises(SpecError) as raised:
        specs.loads(BAR.replace("FILE", str(tmp_path / "line.csv")))
    (line,) = raised.value.lines
    assert "target_line" in line and why in line


def test_a_line_outside_of_the_body_is_told(tmp_path):
    (tmp_path / "line.csv").write_text("x (mm),z (mm)\n1,2\n3,4\n")
    text = BAR.replace("FILE", str(tmp_path / "line.csv")).replace(
        "3 mm, 0 mm, 0", "0 mm, 0 mm, 40"
    )
    spec = specs.loads(text)
    with pytest.raises(
        SoftactError, match=r"target_line.through: the line leaves the body: .* outs"
    ):
        run(spec, tmp_path / "run", report=False, threads=1)


def test_only_a_spec_with_a_target_has_its_distances():
    from softact.measured.curve import run_columns

    text = BAR.replace("target_line: {file: FILE, through: [3 mm, 0 mm, 0 mm]}\n", "")
    assert not [c for c in run_columns(specs.loads(text)) if "target" in c]

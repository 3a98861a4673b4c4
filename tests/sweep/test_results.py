"""Rows, files, trends and indices of a study, against the angle that its runs were given."""

import csv
import io
import subprocess
import sys

import h5py
import numpy as np
import pytest
from pyarrow import parquet

from softact.results.own_folder import Output
from softact.sweep import compute as computing
from softact.sweep import sensitivity, sweep_page, table
from softact.sweep.cache import Cache
from softact.sweep.spec import Sweep, read
from softact.sweep.study import locally, open_study
from softact.sweep.trends import verdicts
from tests.sweep.folders import CUBE, instead_of_run

AXES = """
axes:
  - {path: geometry.length, values: [4 mm, 6 mm, 0 mm, 8 mm]}
  - {name: side, path: [geometry.width, geometry.height], values: [4 mm, 5 mm]}
"""


def study_of(tmp_path, text, design=None):
    (tmp_path / "sweep.yaml").write_text(CUBE + text)
    sweep, base = read(tmp_path / "sweep.yaml", Sweep)
    points = design(sweep).points if design else None
    study = open_study(sweep, base, Cache(tmp_path / "runs"), design=points)
    study.compute(locally(2), lambda point, answer: None)
    return study


@pytest.fixture(autouse=True)
def without_solver(monkeypatch):
    monkeypatch.setattr(computing, "run", instead_of_run)


def test_a_row_for_each_point_with_its_parameters_measures_and_cause(tmp_path):
    study = study_of(tmp_path, AXES)
    table.write(study, Output(tmp_path, "sweep"))
    with open(tmp_path / "sweep.csv") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 8
    for row in rows:
        length = float(row["geometry.length_mm"])
        if length:
            assert (row["status"], row["verdict"]) == ("complete", "green")
            assert float(row["bending_angle_deg"]) == 10.0 * length
        else:
            assert (row["status"], row["verdict"]) == ("invalid_spec", "")
            assert row["bending_angle_deg"] == ""
            assert "would vanish" in row["cause"]
    read_back = parquet.read_table(tmp_path / "sweep.parquet").to_pylist()
    assert [r["bending_angle_deg"] for r in read_back] == [
        float(r["bending_angle_deg"]) if r["bending_angle_deg"] else None for r in rows
    ]
    assert [r["run"] for r in read_back] == [r["run"] for r in rows]


def test_parquet_has_numbers_texts_and_gaps():
    rows = [
        {"point": 0, "cause": "", "wall_mm": 1.5, "law": "yeoh", "never": ""},
        {"point": 1, "cause": "Ωber 5 °", "wall_mm": "", "law": "", "never": ""},
        {"point": 2, "cause": "x", "wall_mm": float("nan"), "law": "ogden"},
    ]
    read_back = parquet.read_table(io.BytesIO(table.parquet(rows)))
    kinds = ["int64", "string", "double", "string", "string"]
    assert [str(field.type) for field in read_back.schema] == kinds
    columns = read_back.to_pydict()
    assert np.isnan(columns["wall_mm"].pop())
    assert columns == {
        "point": [0, 1, 2], "cause": ["", "Ωber 5 °", "x"], "wall_mm": [1.5, None],
        "law": ["yeoh", "", "ogden"], "never": ["", "", ""],
    }  # fmt: skip


def test_a_table_does_not_wait_for_heavy_modules():
    program = (
        "import sys; from softact.sweep import study, sweep_page, table\n"
        "table.parquet([{'point': 0, 'wall_mm': 1.5, 'law': 'yeoh'}])\n"
        "sys.exit(repr({'pandas', 'scipy', 'pint', 'matplotlib'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stderr.strip() == "set()"


def test_curves_of_all_runs_in_one_file(tmp_path):
    study = study_of(tmp_path, AXES)
    table.write(study, Output(tmp_path, "sweep"))
    with h5py.File(tmp_path / "curves.h5") as file:
        keys = file["run"].asstr()[()]
        for key, first, count in zip(keys, file["first"], file["count"], strict=True):
            angles = file["columns/bending_angle_deg"][first : first + count]
            assert np.array_equal(angles, study.answers[key].record.curve("bending_angle_deg"))
    assert len(keys) == 6


def test_one_at_a_time_fills_in_what_the_base_has(tmp_path):
    study = study_of(tmp_path, "design: one_at_a_time\n" + AXES)
    rows = table.rows(study)
    assert (rows[0]["geometry.length_mm"], rows[0]["side_mm"]) == (4.0, 4.0)
    assert [(r["geometry.length_mm"], r["side_mm"]) for r in rows[-2:]] == [(4.0, 4.0), (4.0, 5.0)]
    assert rows[0]["run"] == rows[1]["run"] == rows[-2]["run"]  # one run for all three
    assert study.computed == 4


@pytest.mark.parametrize(
    ("does", "holds"), [("rise", True), ("fall", False), ("peak", False), ("dip", False)]
)
def test_trends_are_seen(tmp_path, does, holds):
    trend = f"trends: [{{measure: bending_angle_deg, axis: geometry.length, does: {does}}}]\n"
    study = study_of(tmp_path, trend + AXES)
    (verdict,) = verdicts(study, table.rows(study))
    assert verdict.holds is holds
    assert "4: 40, 6: 60, 8: 80" in verdict.text


def test_trends_of_one_at_a_time_count_the_base_once(tmp_path):
    trend = "trends: [{measure: bending_angle_deg, axis: geometry.length, does: rise}]\n"
    study = study_of(tmp_path, "design: one_at_a_time\n" + trend + AXES)
    (verdict,) = verdicts(study, table.rows(study))
    assert verdict.holds, verdict.text


def test_trend_of_a_measure_that_is_not_there_cannot_be_told(tmp_path):
    trend = "trends: [{measure: grip_N, axis: side, does: rise}]\n"
    study = study_of(tmp_path, trend + AXES)
    (verdict,) = verdicts(study, table.rows(study))
    assert verdict.holds is None


RANGES = """
design: {kind: grid, samples: 64}
axes:
  - {path: geometry.length, from: 4 mm, to: 8 mm}
  - {path: geometry.width, from: 4 mm, to: 8 mm}
"""


@pytest.mark.parametrize("kind", ["sobol", "morris"])
def test_indices_of_a_measure_that_one_axis_makes_alone(tmp_path, kind):
    """The angle is 10 deg for each mm of length: Sobol's index is 1, Morris's effect 40 deg."""

    samples = {}

    def design(sweep):
        fewer = sweep.design.model_copy(update={"samples": 8})
        small = sweep.model_copy(update={"design": fewer})
        samples["of"] = sensitivity.sample_of(kind, small)
        return samples["of"]

    study = study_of(tmp_path, RANGES, design)
    found = sensitivity.indices(samples["of"], study, table.rows(study))
    angle = {r["axis"]: r for r in found.rows if r["measure"] == "bending_angle_deg"}
    if kind == "sobol":
        assert angle["geometry.length"]["total"] == pytest.approx(1.0, abs=0.3)
        assert angle["geometry.width"]["total"] == pytest.approx(0.0, abs=1e-9)
    else:
        assert angle["geometry.length"]["mean_effect"] == pytest.approx(40.0)
        assert angle["geometry.width"]["mean_effect"] == pytest.approx(0.0, abs=1e-9)
    assert found.notes == []


def test_points_that_are_not_simply_trusted_are_told(tmp_path, monkeypatch):
    """A made-up beam of 42 mm is bent to 420°, through itself."""
    study = study_of(tmp_path, "axes:\n  - {path: geometry.length, values: [4 mm, 42 mm]}\n")
    green, amber = table.rows(study)
    assert (green["verdict"], amber["verdict"]) == ("green", "amber: overlap")
    banner = sweep_page.points_banner([green, amber])
    assert "1 of them are solved, but not simply to be trusted (overlap: 1)" in banner
    assert "banner warn" in banner

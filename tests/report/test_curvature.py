"""Curvature along the axis in a report: the plot of the block bent to an arc, and its file."""

import csv

import numpy as np
import pytest

from softact import api
from softact.report import curvature, write_report
from softact.results.along import COLUMNS
from softact.results.folder import read
from tests import bent_beam
from tests.report.test_headline import write

ARC = 1e3 * np.radians(bent_beam.ANGLE) / bent_beam.LENGTH  # 1/m


@pytest.fixture(scope="module")
def beam(tmp_path_factory):
    folder = tmp_path_factory.mktemp("curvature") / "beam"
    bent_beam.write(folder, bent_beam.ANGLE, 4)
    return folder


def test_the_plot_shows_the_arcs(beam):
    """One line for each pictured state, level but for the end walls; and no plot of a twist."""
    (plot,) = curvature.write(read(beam), 4).plots
    assert plot.title == "Curvature along the axis"
    assert [trace["name"] for trace in plot.traces] == ["12.5 kPa", "25 kPa", "37.5 kPa", "50 kPa"]
    for part, trace in enumerate(plot.traces, 1):
        np.testing.assert_allclose(trace["y"][1:-1], ARC * part / 4, rtol=1e-5)


def test_the_file_has_all_states(beam):
    curvature.write(read(beam), 4)
    with open(beam / "curvature.csv", newline="", encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    assert list(table[0]) == ["state", "pressure_kPa", *COLUMNS] and len(table) == 5 * 23
    last = [float(row["curvature_per_m"]) for row in table if row["state"] == "4"]
    np.testing.assert_allclose(last[1:-1], ARC, rtol=1e-5)
    frame = api.read(beam).along
    assert list(frame.columns) == list(table[0]) and len(frame) == len(table)
    assert frame["curvature_per_m"].tolist() == [float(row["curvature_per_m"]) for row in table]


def test_an_old_file_goes_where_nothing_is_bent(tmp_path):
    bent_beam.write(tmp_path / "r", 0.1, 2)
    (tmp_path / "r/curvature.csv").write_text("old")
    assert curvature.write(read(tmp_path / "r"), 4) == curvature.Drawn()
    assert not (tmp_path / "r/curvature.csv").exists()


def test_a_report_without_it_says_why(tmp_path):
    """Fields that cannot be read leave the plot out, and the rest of the page stands."""
    results = write(tmp_path / "r", [{"pressure_kPa": 1.0 * n} for n in range(3)])
    assert curvature.write(results, 4) == curvature.Drawn()  # one element: no slices
    bent_beam.write(tmp_path / "b", 90.0, 2)
    results = read(tmp_path / "b")
    (tmp_path / "b/fields.h5").write_bytes(b"nothing")
    drawn = curvature.write(results, 4)
    assert not drawn.plots and drawn.fault.startswith("curvature.csv is missing:")
    assert "fields.h5" in drawn.fault
    page = write_report(tmp_path / "b").read_text(encoding="utf-8")
    assert "Curvature along the axis" not in page

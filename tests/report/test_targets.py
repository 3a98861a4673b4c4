"""Published requirements against runs whose figures have closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from softact.cli.report import report
from softact.report import body, targets
from softact.results.folder import read
from softact.results.writer import ResultsWriter
from softact.units import DENSITY
from tests import bent_beam


@pytest.fixture(scope="module")
def beam(tmp_path_factory):
    """The bent beam, 200 degrees at 50 kPa, 120 x 16 x 14 mm."""
    directory = tmp_path_factory.mktemp("targets") / "beam"
    bent_beam.write(directory, 200.0, 8, size={"nx": 60, "ny": 4, "nz": 7})
    return directory


def made(tmp_path, **columns):
    """A result folder without a mesh."""
    writer = ResultsWriter(tmp_path / "r", "name: r\n", {})
    count = len(next(iter(columns.values())))
    for n in range(count):
        writer.increment({name: float(values[n]) for name, values in columns.items()})
    writer.finish("complete")
    return read(tmp_path / "r")


def verdict(results, name, text):
    (asked,) = [r for r in targets.requirements(name) if r.text.startswith(text)]
    return targets.judge(results, asked)


def test_the_file_holds_what_the_papers_print():
    """Agarwal's Fig. 1a: blocked force (N), at (kPa), size (mm)."""
    printed = {
        "glove": (3.0, 50, 150), "trunk_belt": (25, 200, 150), "neck": (5.0, 200, 75),
        "hip": (20, None, 100), "wrist": (2.0, 50, 50), "ankle": (2.0, 50, 50),
        "heart": (6.0, 70, 75), "exoskeleton": (6.0, 40, 85),
    }  # fmt: skip
    for name, (force, at, size) in printed.items():
        asked = {r.figure: r for r in targets.requirements(name)}
        assert (asked["blocked_force_N"].bound, asked["blocked_force_N"].at) == (force, at)
        assert (asked["size_mm"].bound, asked["size_mm"].least) == (size, False)
    glove = {r.text: r for r in targets.requirements("glove")}
    assert glove["Profile < 0.025 m"].bound == 25.0
    assert glove["Degrees of curvature 270° (similar to fingers)"].bound == 270.0


def test_size_profile_and_mass_of_the_beam(beam):
    results = read(beam)
    assert body.extent(results) == pytest.approx([120, 16, 14])
    assert body.profile(results) == pytest.approx(14)
    assert body.mass(results) is None  # its spec names no material
    beam_with = beam / "spec.yaml"
    beam_with.write_text(bent_beam.SPEC + "materials: {body: {density: 1130 kg/m^3}}\n")
    wall = bent_beam.WALL
    solid = 120 * 16 * 14 - (120 - 2 * wall) * (16 - 2 * wall) * (14 - 2 * wall)
    assert body.mass(read(beam)) == pytest.approx(1130 * solid * 1e-9)
    assert DENSITY.parse("1130 kg/m^3") == pytest.approx(1.13e-9)


def test_verdicts_of_the_beam(beam):
    results = read(beam)
    assert verdict(results, "glove", "Bend up to").verdict == targets.MET
    assert verdict(results, "glove", "Degrees of curvature").verdict == targets.NOT_MET
    assert verdict(results, "glove", "Degrees of curvature").fulfilment == pytest.approx(
        20000 / 270
    )
    assert verdict(results, "glove", "Size scale").fulfilment == pytest.approx(125)
    assert verdict(results, "neck", "Size scale").verdict == targets.NOT_MET
    assert verdict(results, "glove", "3.0 N").verdict == targets.UNKNOWN


def test_a_force_counts_at_the_pressure_that_is_asked_for(tmp_path):
    results = made(tmp_path, pressure_kPa=[0, 30, 80], blocked_force_N=[0, 1.2, 3.2])
    found = verdict(results, "wrist", "2.0 N @ 50 kPa")  # 0.04 N/kPa: 2 N at 50 kPa
    assert (found.verdict, found.found) == (targets.MET, pytest.approx(2.0))
    assert verdict(results, "exoskeleton", "6.0 N").verdict == targets.NOT_MET
    neck = verdict(results, "neck", "5.0 N @ 200 kPa")  # more than the run has is not known
    assert neck.verdict == targets.UNKNOWN and "ends at 80 kPa" in neck.why


def test_a_force_counts_while_the_finger_is_bent(tmp_path):
    columns = {"pressure_kPa": [0, 25, 50], "blocked_force_N": [0, 4, 8]}
    straight = made(tmp_path, **columns, bending_angle_deg=[0, 5, 10])
    assert verdict(straight, "glove", "3.0 N").verdict == targets.UNKNOWN
    bent = made(tmp_path, **columns, bending_angle_deg=[0, 100, 160])
    assert verdict(bent, "glove", "3.0 N").verdict == targets.MET


def test_nothing_is_known_of_what_no_run_tells(beam):
    results = read(beam)
    told = [targets.judge(results, r) for r in targets.requirements("glove") if not r.figure]
    assert {v.verdict for v in told} == {targets.UNKNOWN}
    assert all(np.isnan(v.fulfilment) for v in told)


def test_the_command(beam):
    done = CliRunner().invoke(report, [str(beam), "--targets", "glove"])
    assert done.exit_code == 0, done.output
    assert "Assistive glove: 4 met, 1 not met, 6 not known" in done.output
    page = (beam / "report.html").read_text()
    assert "Published requirements" in page and "targets_glove.csv" in page
    done = CliRunner().invoke(report, [str(beam), "--targets", "golve"])
    assert "did you mean 'glove'?" in str(done.exception)


def test_an_angle_between_markers_as_of_the_whole_length(beam, tmp_path):
    """90 degrees between markers 30 mm from both ends of 120 mm: 180 degrees of the whole."""
    found = made(tmp_path, pressure_kPa=[0, 50], bending_angle_deg=[0, 90], tip_x_mm=[90, 40])
    layout = read(beam).layout
    assert body.whole_bending(replace(found, layout=layout)) == pytest.approx([0, 90])
    between = replace(found, layout=replace(layout, base="base"))
    assert layout.length == 120
    assert body.whole_bending(between) == pytest.approx([0, 180])
    asked = targets.requirements("index_finger")[0]
    assert targets.judge(between, asked).verdict == targets.MET
    assert targets.judge(found, asked).verdict == targets.NOT_MET

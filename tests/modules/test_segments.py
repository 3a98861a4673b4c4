"""An arm of several segments, each with cavities of its own: its module, and its rod."""

import re

import numpy as np
import pytest

from softact.errors import SpecError
from softact.modules import rod_run, table_file
from softact.modules.driven import driven
from softact.modules.module_spec import module_specs
from softact.modules.rod_run import Chain
from softact.modules.segments import Segments
from softact.modules.walk import Grid
from softact.results.folder import read
from softact.run.start import run
from softact.spec import Spec
from softact.sweep.module_point import point_of

GRID = Grid(3, 1)
S_SHAPE = {"segment_1_cavity_2": "30 kPa", "segment_2_cavity_1": "40 kPa"}
SPEC = {
    "name": "arm",
    "geometry": {
        "type": "omnidirectional",
        "modules": 4,
        "segments": 2,
        "symmetry": True,
        "mesh_size": "8 mm",
    },
    "materials": {"body": "elastic-resin-uncured"},
    "solver": {"initial_increment": 0.5, "max_increment": 0.5},
    "steps": [
        {"name": "first", "pressure": {"segment_1_cavity_2": "30 kPa"}},
        {"name": "second", "pressure": S_SHAPE},
    ],
}


@pytest.fixture(scope="module")
def spec():
    return Spec.model_validate(SPEC)


@pytest.fixture(scope="module")
def table(spec, tmp_path_factory):
    known = tmp_path_factory.mktemp("table") / table_file.JSON
    return table_file.made_or_read(spec, known, False, lambda said: None, GRID).table


def pressed(spec, **pressures):
    """The spec with one step, kPa."""
    given = {name: f"{value} kPa" for name, value in pressures.items()}
    return spec.with_({"steps": [{"name": "press", "pressure": given}]})


def test_its_module_is_that_of_one_segment(spec):
    """The segment at the clamp, under its pressures."""
    one = spec.with_(
        {
            "geometry.segments": 1,
            "steps": [
                {"name": name, "pressure": {"cavity_2": "30 kPa"}} for name in ("first", "second")
            ],
        }
    )
    found, wanted = (module_specs(s, {}) for s in (spec, one))
    assert found.runs["free"] == wanted.runs["free"]
    assert found.pitches == wanted.pitches == 4
    assert tuple(found.runs["free"].layout().cavities) == ("cavity_1", "cavity_2")


def test_a_segment_without_loads_has_no_module(spec):
    with pytest.raises(SpecError, match="none loads the segment at the clamp"):
        module_specs(pressed(spec, segment_2_cavity_1=5), {})


def test_a_study_on_modules_is_of_one_segment(spec):
    with pytest.raises(SpecError, match=re.escape("geometry.segments: a study on modules is of")):
        point_of(spec)


def test_the_groups_are_those_of_a_module(spec):
    """A cavity of one segment and that of another are the same one of a module."""
    found = driven(spec)
    assert found.groups == ({"cavity_1": 1.0}, {"cavity_2": 1.0})
    assert found.high == pytest.approx([0.04, 0.03])
    assert found.goals == pytest.approx(
        np.array([[[0.0, 0.03], [0.0, 0.0]], [[0.0, 0.03], [0.04, 0.0]]])
    )


def test_segments_with_the_same_pressures_are_one_of_twice_the_modules(spec, table):
    """Each to rounding: the same law, the same pieces, the same ends; and each has half the air but
    for what its own end lacks."""
    both = pressed(
        spec, segment_1_cavity_1=20, segment_2_cavity_1=20, segment_1_cavity_2=9,
        segment_2_cavity_2=9,
    )  # fmt: skip
    single = spec.with_(
        {
            "geometry.segments": 1,
            "geometry.modules": 8,
            "steps": [{"name": "press", "pressure": {"cavity_1": "20 kPa", "cavity_2": "9 kPa"}}],
        }
    )
    rods = [rod_run.run(Chain(one, table), 2) for one in (both, single)]
    assert not any(rod.stopped for rod in rods)
    two, one = (rod.rows[-1] for rod in rods)
    for name in ("bending_angle_deg", "tip_x_mm", "tip_z_mm", "reaction_z_N"):
        assert two[name] == pytest.approx(one[name], abs=1e-9)
    assert abs(one["bending_angle_deg"]) > 5
    channel = table.ends.at(np.zeros(2))[1][0]  # of a passage that is not there
    assert two["cavity_volume_segment_1_cavity_1_mm3"] == pytest.approx(
        (one["cavity_volume_cavity_1_mm3"] - channel) / 2, rel=1e-9
    )


def test_each_segment_takes_its_own_curvature(spec, table):
    """Nothing weighs on it: each bends as so many free modules at its pressures as the ends leave
    it, whatever the other one does."""
    rod = rod_run.run(Chain(spec, table), 2)
    assert not rod.stopped
    angle = 0.0
    for pressures in ([0.0, 0.03], [0.04, 0.0]):
        idle, _ = table.ends.at(np.array(pressures))
        curvature = table.free_curvature(np.array(pressures))[0]
        angle += np.degrees(curvature * table.pitch * (4 - idle / 2))
    last = rod.rows[-1]
    assert last["bending_angle_deg"] == pytest.approx(angle, abs=1e-6)
    assert last["curvature_change_percent"] == pytest.approx(0.0, abs=1e-6)
    bent = rod.strains[-1][:, 1]
    # What the ends take beyond what they take under a force lies in the modules beside them.
    assert bent[2:8] == pytest.approx(np.full(6, bent[2])) and bent[2] < -1e-3
    assert bent[8:14] == pytest.approx(np.full(6, bent[8])) and bent[8] > 1e-3
    assert bent[0] == pytest.approx(bent[1]) and bent[15] == pytest.approx(bent[14])
    assert 0.5 < bent[0] / bent[2] < 1.5 and 0.5 < bent[15] / bent[8] < 1.5


def test_beside_the_whole_arm(spec, table, tmp_path):
    """One segment, then the other one the other way: what each turns within 3 %, the tip within
    2 % of the length, the air of each cavity within 1 %."""
    assert run(spec, tmp_path / "run", report=False).status == "complete"
    whole = read(tmp_path / "run").curve
    rows = rod_run.run(Chain(spec, table), 2).rows
    before = np.zeros(2)
    for step in ("first", "second"):
        at = np.flatnonzero(whole["step"] == step)[-1]
        row = [row for row in rows if row["step"] == step][-1]
        angles = np.array([whole["bending_angle_deg"][at], row["bending_angle_deg"]])
        turned, by_rod = angles - before
        assert by_rod == pytest.approx(turned, rel=0.03)
        assert abs(turned) > 5
        for name in ("tip_x_mm", "tip_z_mm"):
            assert row[name] == pytest.approx(whole[name][at], abs=0.02 * spec.geometry.length)
        for cavity in spec.layout().cavities:
            name = f"cavity_volume_{cavity}_mm3"
            assert row[name] == pytest.approx(whole[name][at], rel=0.01)
            pressure = f"pressure_{cavity}_kPa"
            assert row[pressure] == pytest.approx(whole[pressure][at], abs=1e-9)
        before = angles


def test_pressures_in_time_go_to_their_segments(spec, table):
    chain = Chain(spec, table)
    found = chain.of_groups({"segment_1_cavity_1": 0.01, "segment_2_cavity_2": 0.02})
    assert found == pytest.approx(np.array([[0.01, 0.0], [0.0, 0.02]]))


def test_pieces_of_three_segments():
    """Nine modules, of which the two ends take one and a half: the first and the last segment have
    2.25 that bend, the middle one all of its three, and each has six pieces."""
    segments = Segments.of_chain(9, 3, 1.5)
    assert segments.bending == pytest.approx([2.25, 3.0, 2.25])
    lengths = segments.spread(segments.bending)
    assert lengths == pytest.approx(np.repeat([0.375, 0.5, 0.375], 6))
    curved = np.zeros((18, 3))
    curved[6:12, 1], curved[13:, 1] = 2.0, 0.5
    assert segments.steepest(curved) == pytest.approx(1.0)  # not from segment to segment

"""A table of a module and the rod of it, beside the whole actuator."""

import csv
import json
import re
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

from softact.cli.main import softact
from softact.errors import SpecError
from softact.modules import rod_run, table_file
from softact.modules import table as table_rooms
from softact.modules.chain import Standing
from softact.modules.driven import driven
from softact.modules.rod_run import Chain
from softact.modules.walk import Grid
from softact.results.folder import read
from softact.run.start import run
from softact.spec import Spec, load

GRID = Grid(3, 1)
SPEC = {
    "name": "small",
    "geometry": {
        "type": "pneunet",
        "chambers": 5,
        "chamber_height": "12 mm",
        "base": "3 mm",
        "mesh_size": "4 mm",
    },
    "materials": {"body": "elastosil-m4601"},
    "contact": "none",
    "solver": {"initial_increment": 0.5, "max_increment": 0.5},
    "steps": [
        {"name": "weight", "gravity": [0, 0, -1], "payload": {"force": ["0 N", "0 N", "-0.02 N"]}},
        {"name": "inflate", "pressure": "12 kPa"},
    ],
}


def made(spec, folder, given=False):
    said = []
    known = folder / table_file.JSON
    return table_file.made_or_read(spec, known, given, said.append, GRID), said


@pytest.fixture(scope="module")
def spec():
    return Spec.model_validate(SPEC)


@pytest.fixture(scope="module")
def folder(spec, tmp_path_factory):
    """With the table's files."""
    folder = tmp_path_factory.mktemp("table")
    made(spec, folder)[0].write(*(folder / name for name in table_file.FILES))
    return folder


@pytest.fixture(scope="module")
def table(folder):
    return table_file.read(folder / table_file.JSON).table


def test_states_that_are_not_in_the_fit(table):
    assert len(table.walked.samples.places) >= 25 and table.walked.lost == 0
    assert table.energy.names == ("curvature_y", "force_x", "force_z", "pressure")
    assert table.errors.max() < 1e-2


def test_both_files_hold_the_same(table, folder):
    plain = json.loads((folder / table_file.JSON).read_text())
    samples = table.walked.samples
    with h5py.File(folder / table_file.HDF5) as file:
        assert file["energy/constants"][:] == pytest.approx(plain["energy"]["constants"])
        assert file["walked/samples/first"].shape == samples.first.shape
        assert file["pitch"].attrs["unit"] == "mm"
    found, scale = table.energy.first(samples.places), np.abs(samples.first).max(axis=0)
    assert (np.abs(found - samples.first).max(axis=0) / scale).max() < 1e-2


def test_what_the_ends_take_from_three_modules(table):
    """Half a module each time, which the clamp and the tip's wall hold."""
    assert 0.3 < table.ends.stiff < 1.0
    idle, air = table.ends.at(np.array([6e-3]))
    assert table.ends.idle.min() <= idle <= table.ends.idle.max()
    assert 0.3 < idle < 1.0 and 0 < air[0] < 500


def test_the_ends_bend_less_and_the_rest_as_a_module_let_go(spec, table):
    """Under a pressure alone every piece is free of moment; what is idle lies at the ends."""
    pressures = np.array([9e-3])  # MPa
    chain = Chain(spec.with_({"steps": [{"name": "up", "pressure": "9 kPa"}]}), table)
    standing = Standing(chain, replace(chain.at_rest(), pressures=pressures[None]))
    rod = standing.rod
    curved = rod.strains(rod.settle(rod.straight(), standing.loads))[:, 1]
    (free,) = table.free_curvature(pressures)[table.turns]
    idle, _ = table.ends.at(pressures)
    assert curved[2:-2] == pytest.approx(free, rel=1e-8)
    whole = (chain.segments.modules - idle) * table.pitch * free
    assert curved @ chain.lengths == pytest.approx(whole, rel=1e-8)
    assert curved[:2].sum() == pytest.approx(curved[-2:].sum(), rel=1e-8)


def test_less_load_takes_the_same_table_and_more_does_not(spec, folder):
    _, said = made(spec.with_({"steps.inflate.pressure": "8 kPa"}), folder)
    assert said == [f"table: that of {folder / table_file.JSON}"]
    for path, value in {
        "steps.inflate.pressure": "14 kPa",
        "steps.weight.payload.force": ["0 N", "0 N", "-1 N"],
        "geometry.roof": "1.5 mm",
        # It swings: weight and payload pull three times as much.
        "steps.weight": SPEC["steps"][0]
        | {"payload": {"force": ["0 N", "0 N", "-0.1 N"]}, "duration": "1 s", "dynamics": True},
    }.items():
        with pytest.raises(SpecError, match="is the table of another module, or of less than"):
            made(spec.with_({path: value}), folder, given=True)


def test_a_finger_that_swings_comes_to_where_it_hangs(spec, table):
    """Under its weight in two ways: the mean of a slow swing is the state at rest, and what holds
    the clamp swings about the weight."""
    slow = spec.with_({"steps": slow_steps()})
    moving = [
        dict(step, duration="2 s", dynamics=True, amplitude="smooth") for step in slow_steps()
    ]
    still = rod_run.run(Chain(slow, table), 2).rows
    found = rod_run.run(Chain(spec.with_({"steps": moving}), table), 20)
    assert not found.stopped
    last = found.rows[-1]
    assert last["time_s"] == pytest.approx(4.0)
    assert last["bending_angle_deg"] == pytest.approx(still[-1]["bending_angle_deg"], abs=1.0)
    assert last["reaction_z_N"] == pytest.approx(still[-1]["reaction_z_N"], rel=0.05)


def slow_steps():
    return [{"name": "weight", "gravity": [0, 0, -1]}, *SPEC["steps"][1:]]


def test_beside_the_whole_actuator(spec, table, tmp_path):
    """Weight, payload and pressure: the angle within 3 %, the tip within 1 % of the length, air
    within 1 %."""
    assert run(spec, tmp_path / "run", report=False).status == "complete"
    whole = read(tmp_path / "run").curve
    rod = rod_run.run(Chain(spec, table), 2)
    assert not rod.stopped
    for row in rod.rows[2:]:
        at = (whole["step"] == row["step"]) & np.isclose(
            whole["step_fraction"], row["step_fraction"]
        )
        (at,) = np.flatnonzero(at)
        assert row["bending_angle_deg"] == pytest.approx(whole["bending_angle_deg"][at], rel=0.03)
        for name in ("tip_x_mm", "tip_z_mm"):
            length = spec.geometry.layout().length
            assert row[name] == pytest.approx(whole[name][at], abs=0.01 * length)
        volume = next(v for name, v in whole.items() if name.startswith("cavity_volume"))
        assert row["cavity_volume_mm3"] == pytest.approx(volume[at], rel=0.01)
        assert row["reaction_z_N"] == pytest.approx(whole["reaction_z_N"][at], rel=0.01)


def test_it_stands_on_a_plate(spec, table):
    """What presses on the plate, hangs on the finger and holds the clamp is in balance."""
    plate = {
        "type": "block",
        "center": ["30 mm", "0 mm", "-10 mm"],
        "size": ["100 mm"] * 2 + ["20 mm"],
    }
    blocked = spec.with_({"obstacles": {"plate": plate | {"load_cell": True}}})
    blocked = blocked.with_({"steps.inflate.pressure": "8 kPa"})
    rod = rod_run.run(Chain(blocked, table), 4)
    assert not rod.stopped
    last = rod.rows[-1]
    assert last["blocked_force_N"] > 0.01
    assert last["contact_force_plate_z_N"] == pytest.approx(last["blocked_force_N"])
    weight = rod.rows[4]["reaction_z_N"] + rod.rows[4]["contact_force_plate_z_N"]
    assert last["reaction_z_N"] + last["blocked_force_N"] == pytest.approx(weight, rel=0.02)
    assert last["tip_z_mm"] > -0.1 + spec.geometry.base / 2  # the tip did not go through


def test_a_law_that_contact_breaks_is_refused():
    table_rooms.refuse_kinks(0.019)
    with pytest.raises(SpecError, match=r"contact: the law of the module is off by 4.9 %"):
        table_rooms.refuse_kinks(0.049)


def test_what_a_rod_is_not_asked(spec, table):
    changes = {
        "contact": [{"self": "outer", "friction": 0.2}],
        "obstacles": {
            "ball": {"type": "sphere", "center": ["9 mm"] * 3, "radius": "1 mm", "active": False}
        },
    }
    with pytest.raises(SpecError) as error:
        rod_run.check(spec.with_(changes))
    assert "contact: modules touch each other without friction" in str(error.value)
    assert "obstacles.ball.active: what a rod may touch stands there" in str(error.value)
    with pytest.raises(SpecError, match=r"walked over its pressure; no step has one"):
        driven(spec.with_({"steps": SPEC["steps"][:1]}))
    across = spec.with_({"steps.weight.gravity": [0, 1, 0]})
    with pytest.raises(
        SpecError, match=r"steps\.weight\.gravity: pulls out of the actuator's plane"
    ):
        rod_run.Chain(across, table).acting(0, rod_run.Chain(across, table).at_rest())


def test_which_cavities_go_together():
    arm = {"type": "omnidirectional", "modules": 3, "symmetry": False}
    steps = [
        {"name": "a", "pressure": {"cavity_1": "10 kPa", "cavity_2": "5 kPa"}},
        {
            "name": "b",
            "pressure": {"cavity_1": "20 kPa", "cavity_2": "10 kPa", "cavity_3": "-4 kPa"},
        },
    ]
    data = {"name": "arm", "geometry": arm, "materials": {"body": "ecoflex-00-30"}, "steps": steps}
    found = driven(Spec.model_validate(data))
    assert found.groups == ({"cavity_1": 1.0, "cavity_2": 0.5}, {"cavity_3": 1.0})
    assert found.low == pytest.approx([0.0, -0.004]) and found.high == pytest.approx([0.02, 0.0])
    assert found.goals == pytest.approx(np.array([[[0.01, 0.0]], [[0.02, -0.004]]]))


def test_amplitudes_that_come_back_leave_the_pressure_where_it_was(spec, tmp_path):
    """A swing of the pressure and pressures in time: where a step goes to, how far it reaches, and
    where the next one begins."""
    (tmp_path / "in_time.csv").write_text("time_s,pressure_kPa\n0,1\n0.1,9\n0.2,2\n")
    moves = {"dynamics": True, "amplitude": {"sine": {"frequency": "5 Hz", "cycles": 1}}}
    steps = [
        {"name": "up", "pressure": "3 kPa"},
        {"name": "swing", "pressure": "7 kPa"} | moves,
        {"name": "wait", "gravity": [0, 0, -1]},
        {"name": "file", "amplitude": {"file": str(tmp_path / "in_time.csv")}, "dynamics": True},
        {"name": "rest", "gravity": [0, 0, 0]},
    ]
    found = driven(spec.with_({"steps": steps}))
    assert found.goals[:, 0, 0] == pytest.approx([3e-3, 7e-3, 3e-3, 3e-3, 2e-3])
    assert found.high == pytest.approx([9e-3]) and found.low == pytest.approx([0.0])


@pytest.fixture
def command(folder, spec, tmp_path, monkeypatch):
    """Calls the command with a pressure, its table's grid being that of these tests."""
    monkeypatch.setattr(table_file, "Grid", lambda: GRID)

    def called(pressure):
        changed = spec.with_({"steps.inflate.pressure": pressure})
        (tmp_path / "small.yaml").write_text(changed.to_yaml())
        arguments = ["rod", str(tmp_path / "small.yaml"), "-o", str(tmp_path / "out")]
        table = ["--table", str(folder / table_file.JSON)]
        return CliRunner().invoke(softact, [*arguments, *table, "--increments", "2"])

    return called


def test_the_command(command, tmp_path):
    done = command("9 kPa")
    assert done.exit_code == 0, done.output
    rows = list(csv.DictReader((tmp_path / "out/curve.csv").open()))
    assert [row["step"] for row in rows] == ["weight"] * 3 + ["inflate"] * 2
    assert float(rows[-1]["pressure_kPa"]) == pytest.approx(9.0)
    assert f"{float(rows[-1]['bending_angle_deg']):.4g}" in done.output
    assert "Line of the rod" in (tmp_path / "out/rod.html").read_text()
    assert (tmp_path / "out" / table_file.HDF5).is_file()


def test_the_command_says_where_a_rod_stops(command, tmp_path, monkeypatch):
    monkeypatch.setattr(table_rooms, "ROOM", -0.4)
    stopped = command("9 kPa")
    assert stopped.exit_code == 4
    assert "is outside of the table" in stopped.output
    assert "is outside of the table" in (tmp_path / "out/rod.html").read_text()


def test_more_than_the_table_has_room_for(command):
    refused = command("15 kPa")
    assert refused.exception and "or of less than 15 kPa" in str(refused.exception)


def test_a_broken_table(tmp_path):
    (tmp_path / "t.json").write_text("{")
    with pytest.raises(SpecError, match=r"t\.json: is no table of 'softact module --table'"):
        table_file.read(tmp_path / "t.json")
    with pytest.raises(SpecError, match="cannot be read"):
        table_file.read(tmp_path / "none.json")


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        (
            {"steps.inflate.duration": "1 s"},
            "steps.1.duration: a rod has a clock with dynamics: true alone",
        ),
        (
            {
                "steps.inflate.duration": "1 s",
                "steps.inflate.dynamics": True,
                "materials.body": {
                    "law": "neo_hookean",
                    "c10": "0.1 MPa",
                    "density": "1000 kg/m^3",
                    "viscoelastic": {"g": [0.2], "tau": ["1 s"], "constants": "long_time"},
                },
            },
            "materials.body: a rod in motion has no memory of its material",
        ),
        ({"geometry": {"type": "thick_sphere"}}, "thick_sphere has no module that repeats"),
    ],
)
def test_what_has_no_rod_is_told(spec, changes, why):
    data = spec.model_dump(mode="json", exclude_none=True)
    if "geometry" in changes:
        data |= {"supports": [], "steps": [{"name": "up", "pressure": "1 kPa"}], **changes}
        changed = Spec.model_validate(data)
    else:
        changed = spec.with_(changes)
    with pytest.raises(SpecError, match=re.escape(why)):
        rod_run.check(changed)


def test_sheets_have_no_rod():
    pouches = load(Path(__file__).parents[2] / "configs/woven_contracting.yaml")
    with pytest.raises(SpecError, match="sheets: a rod is of a solid actuator, not of sheets"):
        rod_run.check(pouches)


def test_a_gradient_that_is_too_strong_is_refused(spec, table, monkeypatch):
    """Few modules that bend by a load at the tip: the last one hardly does. With the limit where it
    is five chambers pass, and with a lower one they do not."""
    chain = Chain(spec, table)
    steepest = max(row["curvature_change_percent"] for row in rod_run.run(chain, 4).rows)
    assert 25 < steepest < rod_run.TOO_STEEP
    monkeypatch.setattr(rod_run, "TOO_STEEP", 0.8 * steepest)
    monkeypatch.setattr(rod_run, "BY_TABLE", 0.01)
    found = rod_run.run(chain, 4)
    assert "from one module to the next; a module is one among equals" in found.stopped
    shown = [row["curvature_change_percent"] for row in found.rows]
    assert len(shown) < 9 and max(shown, default=0.0) <= 0.8 * steepest

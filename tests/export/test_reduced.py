"""The fit recovers a model that was put in, and says what it cannot know."""

import dataclasses

import numpy as np
import pytest

from softact.errors import SpecError
from softact.export import errors, fitting, job, masses, reduced, sources, states
from softact.results.folder import read

from . import made_up


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    return sources.runs(made_up.write(tmp_path_factory.mktemp("made_up")))


@pytest.fixture(scope="module")
def model(runs):
    return reduced.fit(runs)


def test_curvature_stiffness_and_volume_are_those_put_in(model):
    table = {name: np.array(values, float) for name, values in model.data["table"].items()}
    p = table["pressure_kPa"]
    assert table["rest_bending_y"] == pytest.approx(made_up.curvature(p), rel=2e-3, abs=1e-6)
    assert table["stiffness_bending_y"] == pytest.approx(made_up.stiffness(p), rel=3e-3)
    assert table["rest_stretch"] == pytest.approx(0.0, abs=1e-4)
    at_rest = made_up.volume(p, made_up.curvature(p))
    assert table["rest_volume_mm3"] == pytest.approx(at_rest, rel=1e-3)
    assert model.data["components"] == ["bending_y", "stretch"]


def test_the_rod_lies_where_the_cavities_and_the_neutral_line_are(model):
    data = model.data
    assert (data["start_mm"], data["active_length_mm"], data["end_mm"]) == pytest.approx(
        (made_up.START, made_up.ACTIVE, made_up.END)
    )
    assert data["offset_z_mm"] == pytest.approx(made_up.NEUTRAL, abs=1e-3)


def test_what_the_loads_tell_is_fitted_and_the_rest_assumed(model):
    why = model.data["stiffness_from"]
    assert why["bending_y"].startswith("fitted") and why["stretch"].startswith("assumed")


def test_an_unloaded_run_does_not_tell_the_stiffness(runs):
    """Of a box of one material it is then E times the second moment about the neutral line."""
    found = reduced.fit(runs[:1])
    assert found.data["stiffness_from"]["bending_y"].startswith("assumed")
    about = made_up.WIDTH * made_up.HEIGHT**3 / 12
    about += made_up.WIDTH * made_up.HEIGHT * found.data["offset_z_mm"] ** 2
    shear, bulk = 0.2, 0.2 * 2 * 1.499 / (3 * 0.002)
    modulus = 9 * bulk * shear / (3 * bulk + shear)
    # The part of the box between the clamp's end and the tip's: points of six tets only.
    assert found.data["table"]["stiffness_bending_y"][0] == pytest.approx(modulus * about, rel=0.3)
    free = found.states.turned[:, 1] / made_up.ACTIVE
    assert free == pytest.approx(made_up.curvature(found.states.pressure), rel=1e-9, abs=1e-12)


def test_deviations_are_those_that_were_put_in(model):
    """Angle of all free states off by 0.5 degrees, volume by 7 mm³."""
    found = model.states.part(~model.states.held)
    turned = found.turned + np.array([0.0, np.radians(0.5), 0.0])
    off = dataclasses.replace(found, turned=turned, volume=found.volume - 7.0)
    said = {deviation.name: deviation for deviation in errors.against(model, off)}
    assert said["bending angle"].largest == pytest.approx(0.5, abs=0.02)
    assert said["bending angle"].rms == pytest.approx(0.5, abs=0.02)
    assert said["volume"].largest == pytest.approx(7.0, abs=1.0)
    whole = np.degrees(np.ptp(model.states.turned[:, 1]))
    assert said["bending angle"].percent == pytest.approx(100 * 0.5 / whole, rel=0.05)
    moment = next(d for name, d in said.items() if name == "tip's place")
    assert moment.unit == "mm"


def test_each_run_is_met_by_a_fit_to_the_others(model):
    how, found = errors.unseen(model)
    assert how.startswith("each run")
    said = {deviation.name: deviation for deviation in found}
    assert said["bending angle"].percent < 1.0
    assert said["mean moment of a held tip, bending_y"].percent < 1.0


def test_a_model_of_a_stiffness_that_is_not_the_runs_is_seen_to_be_off(model):
    """Half of the stiffness moves the held states' moments by half."""
    table = dict(model.data["table"])
    table["stiffness_bending_y"] = [v / 2 for v in table["stiffness_bending_y"]]
    data = {**model.data, "table": table}
    soft = dataclasses.replace(model, data=data, rod=type(model.rod)(data))
    said = {d.name: d for d in errors.against(soft, model.states)}
    assert said["mean moment of a held tip, bending_y"].percent == pytest.approx(50.0, abs=1.0)


def test_unloading_is_left_out_and_counted(runs, tmp_path):
    (folder,) = made_up.write(tmp_path, moments=(0.0,))
    path = folder / "curve.csv"
    head, *rows = path.read_text().splitlines()
    path.write_text("\n".join([head, *rows, *rows[-2:5:-1]]) + "\n")
    run = dataclasses.replace(read(folder), increments=tuple("x" * len(rows)))
    found = states.gather([run], np.array([0.0, 0.0, 5.0]))
    assert found.left_out[states.UNLOADING] == 4
    assert len(found) == len(rows)


def test_a_state_under_another_load_is_left_out(tmp_path):
    (folder,) = made_up.write(tmp_path, moments=(0.0,))
    run = read(folder)
    pushed = {f"reaction_{c}_N": np.zeros(11) for c in "xyz"}
    pushed["reaction_z_N"][7:] = -0.5  # as of an obstacle that nothing else tells of
    run = dataclasses.replace(run, curve=run.curve | pushed)
    found = states.gather([run], np.array([0.0, 0.0, 5.0]))
    assert found.left_out[states.OTHER_LOAD] == 4
    assert len(found) == 7


def test_masses_of_the_parts_add_up(runs, model):
    total = 1e-9 * made_up.LENGTH * made_up.WIDTH * made_up.HEIGHT
    assert model.body.masses.sum() == pytest.approx(total)
    lumps = masses.lumps(np.array([[1.0, 0, 0], [3.0, 2, 0], [8.0, 0, 0]]),
                         np.array([1.0, 3.0, 5.0]), [0.0, 5.0, 10.0])  # fmt: skip
    assert lumps.mass == pytest.approx([4.0, 5.0])
    assert lumps.centre[0] == pytest.approx([2.5, 1.5, 0.0])
    # About their centre: arms of (1.5, 1.5) and (0.5, 0.5).
    assert lumps.inertia[0, 2, 2] == pytest.approx(1.0 * 4.5 + 3.0 * 0.5)
    assert lumps.inertia[0, 0, 1] == pytest.approx(-(1.0 * 2.25 + 3.0 * 0.25))


def test_a_compliance_is_told_from_a_function_of_the_pressure():
    p = np.tile(np.linspace(0, 10, 12), 3)
    load = np.repeat([-1.0, 0.0, 2.0], 12)
    values = 0.01 * p + 0.002 * p**2 + (0.02 + 0.003 * p / 10) * load
    rest, compliance = fitting.strain(p, values, load, 1.0)
    assert compliance.terms == pytest.approx((0.02, 0.003), rel=1e-6)
    assert rest(p) == pytest.approx((0.01 * p + 0.002 * p**2), abs=1e-6)
    assert fitting.strain(p[:12], values[:12], load[:12], 1.0)[1].terms == ()


def test_runs_that_do_not_fit_together_are_refused(tmp_path, runs):
    other = dataclasses.replace(
        runs[1], spec_yaml=runs[1].spec_yaml.replace("c10: 0.1", "c10: 0.2")
    )
    with pytest.raises(SpecError, match="its materials differs from that of"):
        reduced.fit([runs[0], other])


def test_folders_that_are_none_are_told_one_by_one(tmp_path):
    (tmp_path / "sweep.csv").write_text("point,status\n0,complete\n")
    with pytest.raises(SpecError) as told:
        sources.runs([tmp_path / "no", tmp_path])
    assert len(told.value.lines) == 2
    assert "no run.json" in told.value.lines[0] and "no column run" in told.value.lines[1]


def test_runs_of_a_sweep_that_are_gone_are_told(tmp_path):
    (tmp_path / "sweep.csv").write_text("point,run,status\n0,abcdef,complete\n")
    with pytest.raises(SpecError, match="1 of its 1 runs are not in"):
        sources.runs([tmp_path], tmp_path / "cache")
    assert not (tmp_path / "cache").exists()


def test_a_load_that_no_equilibrium_bears_is_told_in_a_line(model):
    class Buckled:
        pieces = model.rod.pieces

        def solve(self, *loads):
            raise ArithmeticError

    mean = reduced.strains(model.states, model.data)
    with pytest.raises(SpecError, match="smaller payloads"):
        reduced.shapes(Buckled(), model.states, mean)


def test_the_head_says_what_it_is_and_how_far_it_is_off(runs):
    prepared = job.prepare(runs)
    head = "\n".join(prepared.about)
    for words in ("made_up: reduced model", "33 states, 0 to 20 kPa", "bending angle: at most",
                  "each run by a fit to the others", "stiffness of bending_y: fitted",
                  "assumed: masses and inertia", "assumed: damping"):  # fmt: skip
        assert words in head


def test_a_box_has_the_inertia_of_a_box(model):
    mass = model.body.masses.sum()
    (whole,) = [masses.lumps(model.body.places, model.body.masses, [0.0, made_up.LENGTH])]
    assert whole.centre[0] == pytest.approx([made_up.LENGTH / 2, 0.0, 0.0], abs=1e-12)
    sides = np.array([made_up.LENGTH, made_up.WIDTH, made_up.HEIGHT])
    exact = mass / 12 * (np.sum(sides**2) - sides**2)
    assert np.diag(whole.inertia[0]) == pytest.approx(exact)


def test_a_curve_is_monotone_where_its_knots_are():
    """A spline through a step overshoots; the curve does not."""
    p = np.linspace(0.0, 10.0, 30)
    found = fitting.Curve(np.linspace(0.0, 10.0, 9), np.array([0, 0, 0, 0, 1, 1, 1, 1, 1.0]))
    assert (np.diff(found(p)) >= 0).all() and found(p).max() <= 1.0


def test_a_moment_that_does_not_show_in_the_reactions_is_another_load(tmp_path):
    (folder,) = made_up.write(tmp_path, moments=(0.0,))
    run = read(folder)
    torque = "{surface: x_max, moment: [0 N*mm, 1 N*mm, 0 N*mm]}"
    steps = f"steps:\n  - {{name: inflate, torque: {torque}}}"
    other = run.spec_yaml.replace(run.spec_yaml[run.spec_yaml.index("steps:") :], steps)
    with pytest.raises(SpecError, match=r"no state can be used: .*11 under another load"):
        states.gather([dataclasses.replace(run, spec_yaml=other)], np.array([0.0, 0.0, 5.0]))


def test_states_of_a_motion_are_left_out(tmp_path):
    (folder,) = made_up.write(tmp_path, moments=(0.0,))
    run = read(folder)
    control = np.array(["load"] * 8 + ["motion"] * 3, dtype=object)
    run = dataclasses.replace(run, curve={**run.curve, "control": control})
    found = states.gather([run], np.array([0.0, 0.0, 5.0]))
    assert found.left_out[states.MOVING] == 3 and len(found) == 8


def test_points_of_a_sweep_without_results_are_left_out(tmp_path):
    cache = tmp_path / "cache"
    (folder,) = made_up.write(tmp_path, moments=(0.0,))
    (cache / "ab").mkdir(parents=True)
    folder.rename(cache / "ab" / "abc")
    (tmp_path / "sweep.csv").write_text("point,run,status\n0,abc,complete\n1,abd,failed\n")
    assert [run.directory.name for run in sources.runs([tmp_path], cache)] == ["abc"]
    (tmp_path / "sweep.csv").write_text("point,run,status\n1,abd,failed\n")
    with pytest.raises(SpecError, match="none of the 1 runs of this sweep has results"):
        sources.runs([tmp_path], cache)

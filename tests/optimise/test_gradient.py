"""Optimisation by gradients: known optima of formulas and of a bar that is pulled; bad input."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from softact import spec as specs
from softact.errors import MeshError, SpecError
from softact.files.text import csv_text, json_text
from softact.optimise.gradient import Descent
from softact.optimise.spec import Optimisation
from softact.optimise.study import Trials
from softact.results.folder import read as read_results
from softact.sweep import compute as computing
from softact.sweep.cache import Cache
from softact.sweep.spec import read
from tests.tolerances.test_sweep import stretch

FILE = """
base:
  geometry: {type: block, length: 10 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
  materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
  supports: [{surface: x_min, fix: [x, y, z]}]
  steps: [{name: hang, gravity: [0, 0, -1]}]
method: gradient
parameters:
  - {path: geometry.length, from: 4 mm, to: 20 mm}
  - {path: geometry.width, from: 0.3 cm, to: 0.8 cm}
objectives: [{measure: bending_angle_deg, goal: maximise}]
constraints: [{measure: tip_x_mm, below: 12}]
trials: 60
starts: 2
"""


def hill(x: float, y: float) -> dict[str, tuple[float, float, float]]:
    """Measure -> value and its derivatives by length and width in mm."""
    u, v = x - 9, y - 5
    angle = 100 - u**2 - 2 * v**2 - u * v
    return {"bending_angle_deg": (angle, -2 * u - v, -4 * v - u), "tip_x_mm": (x + y, 1.0, 1.0)}


def waves(x: float, y: float) -> dict[str, tuple[float, float, float]]:
    """Three hills along the length, the last one highest."""
    angle = 50 + 10 * math.cos(2 * math.pi * (x - 5) / 6) + x
    slope = 1 - 10 * 2 * math.pi / 6 * math.sin(2 * math.pi * (x - 5) / 6)
    return {"bending_angle_deg": (angle, slope, 0.0), "tip_x_mm": (y, 0.0, 1.0)}


@pytest.fixture
def made_up(monkeypatch):
    """Replaces the solver by a formula; returns what is to be changed of it and the designs."""

    class MadeUp:
        formula = staticmethod(hill)
        fails_beyond = 100.0
        without = ""
        solved: list = []  # noqa: RUF012
        near: list = []  # noqa: RUF012
        followed = True

    def run(spec, directory, **options):
        x, y = spec.geometry.length, spec.geometry.width
        followed = options["sensitivities"] or ()  # none: the best design from the beginning
        MadeUp.solved += [(x, y)] if followed else []
        MadeUp.near += [options["near"]] if followed else []
        MadeUp.followed = bool(followed)
        if x > MadeUp.fails_beyond:
            raise MeshError("block: gmsh crashed")
        directory.mkdir(parents=True)
        found, lines = MadeUp.formula(x, y), []
        row = {"step": "hang", "increment": 0, "step_fraction": 1.0}
        row |= {name: value for name, (value, *_) in found.items()}
        for name, (_, *slopes) in found.items():
            for path, at, slope in zip(followed, (x, y), slopes, strict=False):
                line = {"increment": 0, "measure": name, "parameter": path, "at": f"{at} mm"}
                line |= {"derivative": slope, "unit": "", "elasticity": ""}
                lines += [line] if path != MadeUp.without else []
        (directory / "curve.csv").write_text(csv_text([row]))
        (directory / "sensitivities.csv").write_text(csv_text(lines))
        (directory / "run.json").write_text(json_text({"status": "complete"}))
        (directory / "spec.yaml").write_text(spec.to_yaml())

    monkeypatch.setattr(computing, "run", run)
    MadeUp.solved, MadeUp.near = [], []
    return MadeUp


def descended(folder, text=FILE, warn=lambda line: None):
    folder.mkdir(exist_ok=True)
    (folder / "opt.yaml").write_text(text, encoding="utf-8")
    wanted, base = read(folder / "opt.yaml", Optimisation)
    study = Trials(wanted, base, Cache(folder / "runs"), folder)
    Descent(study, lambda trial, answer: None, warn).run()
    return study


def test_the_optimum_of_a_hill_at_a_constraint_is_met(tmp_path, made_up):
    """min u² + 2 v² + u v with u + v ≤ −2: by Lagrange u = −3/2, v = −1/2, so 96.5 at 7.5 and 4.5
    mm. The axis is in cm, the derivatives by mm."""
    study = descended(tmp_path)
    (best,) = study.best()
    # Room of 0.05 % of 12 mm at a multiplier of 3.5 per mm costs 0.02.
    assert best.values[0] == pytest.approx(96.5, abs=0.04)
    found = study.coordinates(best)
    assert float(found["geometry.length"].split()[0]) == pytest.approx(7.5, abs=0.1)
    assert float(found["geometry.width"].split()[0]) == pytest.approx(0.45, abs=0.01)
    assert len(study.done) <= 25


def test_bounds_hold_and_a_lower_limit_is_kept(tmp_path, made_up):
    """With u + v ≥ 3 and a width of at most 5.5 mm: v = 0.5, u = 2.5."""
    text = FILE.replace("below: 12", "above: 17").replace("to: 0.8 cm", "to: 0.55 cm")
    study = descended(tmp_path, text)
    (best,) = study.best()
    assert best.values[0] == pytest.approx(100 - 2.5**2 - 0.5 - 1.25, abs=0.08)
    assert max(y for _, y in made_up.solved) <= 5.5 + 1e-9


def test_several_starts_find_the_highest_hill(tmp_path, made_up):
    """Maxima where sin(2π (x − 5)/6) = 6/(20π): near 5.09, 11.09 and 17.09 mm."""
    made_up.formula = staticmethod(waves)
    free = FILE.replace("constraints: [{measure: tip_x_mm, below: 12}]\n", "")
    found = {}
    for starts in (1, 4):
        study = descended(tmp_path / str(starts), free.replace("starts: 2", f"starts: {starts}"))
        (best,) = study.best()
        found[starts] = float(study.coordinates(best)["geometry.length"].split()[0])
    exact = 17 + 3 / math.pi * math.asin(6 / (20 * math.pi))
    assert found[4] == pytest.approx(exact, abs=0.05)
    assert found[1] < 14  # the first start is on another hill


def test_a_run_that_fails_cuts_the_step(tmp_path, made_up):
    made_up.fails_beyond = 7.0
    study = descended(tmp_path, FILE.replace("starts: 2", "starts: 3"))
    failed = [t for t in study.done if t.values is None]
    assert failed
    assert all("gmsh crashed" in t.user_attrs["cause"] for t in failed)
    (best,) = study.best()
    assert best.values[0] > hill(6.0, 4.5)["bending_angle_deg"][0]


def test_the_same_command_computes_nothing_again_and_more_trials_go_on(tmp_path, made_up):
    text = FILE.replace("trials: 60", "trials: 3")
    assert len(descended(tmp_path, text).done) == 3
    assert len(descended(tmp_path, text).done) == len(made_up.solved) == 3
    study = descended(tmp_path)
    assert len(study.done) == len(made_up.solved) == len(set(made_up.solved)) > 3
    assert study.best()[0].values[0] == pytest.approx(96.5, abs=0.04)


def test_the_reference_is_the_first_start_and_a_killed_trial_is_no_other_design(tmp_path, made_up):
    text = FILE + "reference: {geometry.length: 8 mm, geometry.width: 4 mm}\n"
    study = descended(tmp_path, text.replace("trials: 60", "trials: 2"))
    assert study.done[0].values == [hill(8.0, 4.0)["bending_angle_deg"][0]]
    study.study.enqueue_trial({"geometry.length": 20.0, "geometry.width": 0.3})
    study.study.enqueue_trial({"geometry.length": 5.0, "geometry.width": 0.3})
    study.study.ask()  # under way when the command is killed
    again = descended(tmp_path, text)
    assert again.best()[0].values[0] == pytest.approx(96.5, abs=0.04)
    assert len(again.done) == len(made_up.solved) == len(set(made_up.solved))
    for trial in again.done:  # each has the values of its own design
        x, y = (float(v.split()[0]) for v in again.coordinates(trial).values())
        assert trial.values[0] == pytest.approx(hill(x, 10 * y)["bending_angle_deg"][0])


def test_a_derivative_that_is_not_there_is_told(tmp_path, made_up):
    made_up.without = "geometry.width"
    with pytest.raises(SpecError, match=r"trial 0 has no derivative of bending_angle_deg by geom"):
        descended(tmp_path)


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("goal: maximise}]", "goal: maximise}, {measure: tip_x_mm, goal: minimise}]",
         "the method gradient has one objective"),
        ("from: 4 mm, to: 20 mm", "values: [4 mm, 5 mm]", "the method gradient varies ranges"),
        ("method: gradient", "method: gradients", "method"),
    ],
)  # fmt: skip
def test_what_has_no_gradient_is_told(old, new, why, tmp_path):
    with pytest.raises(SpecError) as raised:
        descended(tmp_path, FILE.replace(old, new))
    (line,) = raised.value.lines
    assert why in line


def test_friction_has_no_gradient(tmp_path):
    text = FILE.replace("  supports", "  obstacles: {t: {type: plane, point: [0 mm, 0 mm, -9 mm], "
                        "normal: [0, 0, 1], friction: 0.1}}\n  supports")  # fmt: skip
    text = text.replace("{path: geometry.width, from: 0.3 cm, to: 0.8 cm}",
                        "{path: obstacles.t.friction, from: 0.1, to: 0.3}")  # fmt: skip
    with pytest.raises(SpecError, match=r"method gradient: obstacles.t.friction: with friction"):
        descended(tmp_path, text)


BAR = """
base:
  geometry: {type: block, length: 8 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
  materials: {body: {law: neo_hookean, c10: 20 kPa}}
  supports: [{surface: x_min, fix: [x]}, {surface: y_min, fix: [y]}, {surface: z_min, fix: [z]}]
  solver: {initial_increment: 1, max_increment: 1}
  measures: [tip, energy]
  steps: [{name: pull, traction: {surface: x_max, value: [10 kPa, 0 kPa, 0 kPa]}}]
method: gradient
parameters:
  - {path: geometry.length, from: 4 mm, to: 12 mm}
  - {path: materials.body.c10, from: 15 kPa, to: 40 kPa}
objectives: [{measure: tip_x_mm, goal: maximise}]
constraints: [{measure: strain_energy_mJ, below: 0.08}]
reference: {geometry.length: 10 mm, materials.body.c10: 30 kPa}
trials: 10
starts: 1
"""


def test_the_longest_bar_of_so_much_energy_is_met_in_ten_runs(tmp_path):
    """λ L is largest at the largest length, with the modulus at which V c10 (λ² + 2/λ − 3) is the
    energy allowed: softer is longer."""

    def energy(c10: float) -> float:
        s = stretch(c10)
        return 12 * 16 * c10 * 1e-3 * (s**2 + 2 / s - 3)

    c10 = brentq(lambda c: energy(c) - 0.08, 15.0, 40.0)
    study = descended(tmp_path, BAR)
    (best,) = study.best()
    found = study.coordinates(best)
    assert float(found["geometry.length"].split()[0]) == pytest.approx(12.0)
    assert float(found["materials.body.c10"].split()[0]) == pytest.approx(c10, rel=0.01)
    assert best.values[0] == pytest.approx(12 * stretch(c10), rel=2e-3)
    assert len(study.done) <= 10
    assert np.isfinite(best.values[0])
    assert study.end_only and study.whole(best) == ""
    whole = read_results(study.cache.folder(study.sheet_key(best)))
    assert whole.curve["tip_x_mm"][-1] == pytest.approx(best.values[0], rel=1e-6)
    assert not (whole.directory / "sensitivities.csv").exists()


def test_a_run_from_the_beginning_that_differs_is_told(tmp_path, made_up):
    """The last state that was found is one to which the actuator does not come."""

    def other(x: float, y: float) -> dict[str, tuple[float, float, float]]:
        found = hill(x, y)
        angle, *slopes = found["bending_angle_deg"]
        return found | {"bending_angle_deg": (angle if made_up.followed else 20.0, *slopes)}

    made_up.formula = staticmethod(other)
    said: list[str] = []
    study = descended(tmp_path, warn=said.append)
    (best,) = study.best()
    assert said == [
        f"trial {best.number}: from the beginning the run has bending_angle_deg 20.0, not "
        f"{best.values[0]:.6g}: its state is not the one that the actuator comes to"
    ]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("goal: maximise}]", "goal: maximise, take: largest}]"),
        ("bending_angle_deg, goal", "pressure_work_mJ, goal"),
        ("  supports: [{surface: x_min, fix: [x, y, z]}]",
         "  contact: [{self: z_max, friction: 0.2}]\n"
         "  supports: [{surface: x_min, fix: [x, y, z]}]"),
    ],
)  # fmt: skip
def test_what_hangs_on_the_way_has_all_states(tmp_path, made_up, old, new):
    assert old in FILE
    (tmp_path / "opt.yaml").write_text(FILE.replace(old, new), encoding="utf-8")
    wanted, base = read(tmp_path / "opt.yaml", Optimisation)
    assert not Trials(wanted, base, Cache(tmp_path / "runs"), tmp_path).end_only


def test_each_run_starts_from_the_nearest_design_that_is_done(tmp_path, made_up):
    study = descended(tmp_path)
    places = made_up.solved
    assert made_up.near[0] is None
    for number, near in enumerate(made_up.near[1:], 1):
        spec = specs.load(near / "spec.yaml")
        there = np.array([spec.geometry.length / 16, spec.geometry.width / 5])
        here = np.array([places[number][0] / 16, places[number][1] / 5])
        known = [np.linalg.norm(np.array([x / 16, y / 5]) - here) for x, y in places[:number]]
        assert np.linalg.norm(there - here) == pytest.approx(min(known), abs=1e-12)
    assert len(made_up.near) == len(study.done)

"""What stands at the head of a data sheet and in its table: what moved, how far, in which step."""

import html
import re

import numpy as np
import pytest

from softact.mesh.layout import Layout
from softact.report import curves, headline, key_figures, labels, view, write_report
from softact.results.folder import read
from softact.results.writer import ResultsWriter
from softact.verdict.reached import reached

LENGTH = 80.0
LAYOUT = Layout(regions=("body",), surfaces=("clamp", "tip"), cavities={}, length=LENGTH)


def write(folder, rows, status="complete", layout=LAYOUT, spec="name: r\n"):
    """A result folder with these rows and one tetrahedron."""
    writer = ResultsWriter(folder, spec, {})
    points = np.vstack([np.zeros(3), 10 * np.eye(3)])
    triangles = {"clamp": np.array([[0, 2, 3]]), "tip": np.array([[1, 2, 3]])}
    writer.mesh(points, np.array([[0, 1, 2, 3]]), np.zeros(1), ["body"], triangles, layout)
    usual = {"step": "inflate", "unstable_modes": 0, "control": "load"}
    for number, row in enumerate(rows):
        part = number / (len(rows) - 1)
        writer.increment({"step_fraction": part, **usual, **row}, {"displacement": points * 0})
    writer.finish(status)
    return read(folder)


def bent(*pairs, **more):
    return [{"pressure_kPa": p, "bending_angle_deg": a, **more} for p, a in pairs]


def texts(results):
    return [(f.label.name, f.value, f.note) for f in headline.figures(results)]


def test_a_contracting_pouch_is_headlined_by_its_contraction(tmp_path):
    """Not by an angle of zero; noise is no motion."""
    rows = [{"pressure_kPa": 50.0 * n, "elongation_mm": -3.0 * n, "bending_angle_deg": 1e-7 * n,
             "twist_angle_deg": 0.02 * n} for n in range(5)]  # fmt: skip
    results = write(tmp_path / "r", rows)
    assert texts(results) == [
        ("Pressure", 200.0, ""), ("Contraction", 12.0, "15 % of the length"),
    ]  # fmt: skip
    assert headline.state_text(results, 4) == "contraction 12 mm"
    assert headline.short(results, "elongation_mm", -6.0) == "6 mm contraction"


def test_a_bent_finger_is_headlined_by_its_angle_alone(tmp_path):
    """Where it is bent, the tip's way along the axis is no elongation."""
    rows = [{"pressure_kPa": 10.0 * n, "elongation_mm": -12.0 * n, "bending_angle_deg": 40.0 * n,
             "twist_angle_deg": 0.5 * n} for n in range(5)]  # fmt: skip
    assert headline.told(write(tmp_path / "r", rows)) == ["bending_angle_deg"]


def test_what_is_held_back_is_told_by_what_it_exerts(tmp_path):
    rows = [{"pressure_kPa": 10.0 * n, "bending_angle_deg": 2.0 * n, "blocked_force_N": 0.3 * n}
            for n in range(5)]  # fmt: skip
    found = headline.told(write(tmp_path / "r", rows))
    assert found == ["blocked_force_N", "bending_angle_deg"]


HELD_TIP = {"blocked_torque_Nmm": 0.0, "strain_energy_mJ": 1000.0}


def test_a_held_muscle_is_told_by_its_pull_and_a_held_twister_by_its_torque(tmp_path):
    """What the solver leaves of the others, 1e-5 of the stored energy, is nothing. A torque counts
    by the force that it is over 80 mm: 8 N mm is 0.1 N, and nothing beside 10 N."""
    muscle = {"pull_N": 10.0, "blocked_axial_torque_Nmm": 8.0}
    results = write(tmp_path / "m", [HELD_TIP | muscle | {"pressure_kPa": 1.0 * n} for n in (0, 1)])
    assert headline.told(results) == ["pull_N"]
    twister = {"pull_N": -1.0, "blocked_axial_torque_Nmm": 800.0, "blocked_torque_Nmm": 1e-3}
    results = write(tmp_path / "t", [HELD_TIP | twister | {"pressure_kPa": 1.0} for n in (0, 1)])
    assert headline.told(results) == ["blocked_axial_torque_Nmm"]
    assert headline.state_text(results, 1) == "blocked axial torque 800 N·mm"
    assert headline.figure(results, "pull_N", 1).text == "push 1 N"
    assert headline.short(results, "pull_N", -1.0) == "1 N push"


def test_a_muscle_that_lifts_is_told_by_its_contraction_and_its_pull(tmp_path):
    rows = [{"pressure_kPa": 50.0 * n, "elongation_mm": -4.0 * n, "pull_N": 20.0,
             "strain_energy_mJ": 1000.0} for n in range(4)]  # fmt: skip
    results = write(tmp_path / "lifts", rows)
    assert [(f.label.name, f.value) for f in headline.figures(results)] == [
        ("Pressure", 150.0), ("Contraction", 12.0), ("Pull", 20.0),
    ]  # fmt: skip
    free = write(tmp_path / "free", [row | {"pull_N": 1e-4} for row in rows])
    assert headline.told(free) == ["elongation_mm"]
    finger = [row | {"bending_angle_deg": 90.0 * n} for n, row in enumerate(rows)]
    assert headline.told(write(tmp_path / "bends", finger)) == ["bending_angle_deg"]


def chosen(folder, tiles):
    """A bent finger whose spec chooses its tiles."""
    rows = [{"pressure_kPa": 10.0 * n, "bending_angle_deg": 40.0 * n, "tip_z_mm": -9.0 * n,
             "cavity_volume_mm3": 4000.0} for n in range(3)]  # fmt: skip
    return write(folder, rows, spec=f"name: r\ntiles: [{tiles}]\n")


def test_the_spec_chooses_the_tiles(tmp_path):
    """They, and no others, in their order, in their units; the first is under the pictures."""
    results = chosen(tmp_path / "r", "tip_z_mm, cavity_volume_mm3, pressure_kPa")
    assert texts(results) == [
        ("Pressure", 20.0, ""), ("Tip z", -18.0, ""), ("Cavity volume", 4000.0, ""),
    ]  # fmt: skip
    assert headline.state_text(results, 1) == "tip z −9 mm"
    assert headline.short(results, "cavity_volume_mm3", 4000.0) == "4 mL cavity volume"
    assert not headline.missing(results)
    page = write_report(tmp_path / "r").read_text(encoding="utf-8")
    cards = re.findall(r"<div class=.?card.?>.*?</div>", page, re.S)
    assert len(cards) == 3 and not any("ending" in card for card in cards)


def test_a_tile_that_the_run_has_not_is_said(tmp_path):
    results = chosen(tmp_path / "r", "blocked_force_N, bending_angle_deg")
    (line,) = headline.missing(results)
    assert line.startswith("tiles: the run has no column 'blocked_force_N'")
    assert headline.told(results) == ["bending_angle_deg"]
    page = write_report(tmp_path / "r").read_text(encoding="utf-8")
    assert line.split(";")[0] in html.unescape(page)


UP = [(0.0, 0.0), (20.0, 60.0), (30.0, 140.0)]
DOWN = [(29.0, 160.0), (26.0, 155.0)]


def limited(folder, after=(), status="no_equilibrium"):
    """Up to 30 kPa, then on over the limit with falling pressures, unstable."""
    unstable = {"unstable_modes": 1, "control": "volume"}
    return write(folder, [*bent(*UP), *bent(*DOWN, **unstable), *bent(*after)], status)


def test_over_a_limit_the_largest_stable_load_and_the_largest_motion_are_named(tmp_path):
    results = limited(tmp_path / "r")
    far = reached(results)
    assert (far.largest, far.main, far.limit) == (2, 2, True)
    assert texts(results) == [
        ("Largest stable pressure", 30.0, ""),
        ("Bending angle", 140.0, "at 30 kPa, stable"),
        ("Largest bending angle reached", 160.0, "at 29 kPa, not stable"),
    ]
    assert headline.title(results) == "At the largest stable load, 30 kPa"
    assert view.states(results, 4)[-1] == 2  # the pictures end there, too


def test_a_run_that_snaps_and_goes_on_is_told_by_its_end(tmp_path):
    results = limited(tmp_path / "r", [(33.0, 180.0), (45.0, 200.0)], "complete")
    assert reached(results).main == 6
    assert texts(results) == [("Pressure", 45.0, ""), ("Bending angle", 200.0, "")]
    assert headline.title(results) == "At the last state, 45 kPa"


def test_a_run_that_catches_itself_below_its_limit_is_told_by_both(tmp_path):
    results = limited(tmp_path / "r", [(24.0, 190.0)])
    assert texts(results) == [
        ("Largest stable pressure", 30.0, ""),
        ("Bending angle", 140.0, "at 30 kPa, stable"),
        ("Largest bending angle reached", 190.0, "at 24 kPa"),
    ]


def test_with_friction_a_falling_traced_path_is_not_stable(tmp_path):
    """LU factors have no inertia: no unstable mode is ever counted."""
    rows = [*bent(*UP), *bent(*DOWN, control="arc")]
    assert (
        list(reached(write(tmp_path / "r", rows, "no_equilibrium")).stable)
        == [True] * 3 + [False] * 2
    )


def steps_of(folder, **more):
    """Gravity, inflation to 40 kPa, and a payload under that pressure."""
    rows = [{"step": "gravity", "pressure_kPa": 0.0, "tip_z_mm": -1.0 * n} for n in range(3)]
    rows += [
        {"step": "inflate", "pressure_kPa": 10.0 * n, "tip_z_mm": -2.0 + 5.0 * n}
        for n in range(1, 5)
    ]
    rows += [{"step": "lift", "pressure_kPa": 40.0, "tip_z_mm": 18.0 - 4.0 * n} for n in (1, 2)]
    return write(folder, [row | more for row in rows])


def test_the_table_goes_by_step_and_state(tmp_path):
    """A step at constant pressure has a column of its own, and so has the state before it."""
    results = steps_of(tmp_path / "r")
    stops, rows = key_figures.table(results)
    assert [(stop.step, stop.text) for stop in stops] == [
        ("gravity", "0 kPa"), ("gravity", "0 kPa"), ("inflate", "10 kPa"), ("inflate", "20 kPa"),
        ("inflate", "30 kPa"), ("inflate", "40 kPa"), ("lift", "40 kPa (last)"),
    ]  # fmt: skip
    ((name, unit, said),) = rows
    assert (name, unit) == ("tip_z_mm", "mm")
    wanted = [0, -2, 3, 8, 13, 18, 10]
    assert [float(text.replace("−", "-")) for text in said] == wanted


def test_the_table_has_the_largest_stable_load_of_a_limit(tmp_path):
    stops = key_figures.stops(limited(tmp_path / "r"))
    assert [stop.text for stop in stops if "stable" in stop.text] == ["30 kPa (largest stable)"]
    assert stops[-1].text == "26 kPa (last)" and [s.row for s in stops] == sorted(
        stop.row for stop in stops
    )


def test_the_table_of_many_steps_stays_short(tmp_path):
    rows = [
        {"step": f"step {k}", "pressure_kPa": 100.0 * (n if k % 2 == 0 else 4 - n) / 4, "x_mm": 1.0}
        for k in range(6) for n in range(1, 5)
    ]  # fmt: skip
    stops = key_figures.stops(write(tmp_path / "r", rows))
    assert len(stops) <= 1 + 6 + 6
    assert {stop.step for stop in stops} == {f"step {k}" for k in range(6)}


def test_a_table_without_a_pressure_names_starts_and_ends(tmp_path):
    rows = [{"step": "pull", "reaction_x_N": 1.0 + n} for n in range(3)]
    assert [stop.text for stop in key_figures.stops(write(tmp_path / "r", rows))] == [
        "start", "end (last)",
    ]  # fmt: skip


def test_the_pictures_are_at_most_as_many_as_they_say(tmp_path):
    """Four, not five, where the load falls again; and the ends of the steps are among them."""
    results = steps_of(tmp_path / "r")
    assert view.states(results, 4) == [3, 5, 6, 8]  # at thirds of 40 kPa, and two ends
    up_and_down = write(tmp_path / "u", bent(*UP, (40.0, 150.0), (20.0, 60.0), (10.0, 30.0)))
    for count in (1, 2, 3, 4):
        found = view.states(up_and_down, count)
        assert len(found) <= count and found[-1] == 5


@pytest.mark.parametrize(
    "name, size, shown",
    [("reaction_moment_x_Nmm", 2.6e-10, False), ("reaction_moment_x_Nmm", 2.6e-4, True),
     ("reaction_y_N", 1e-8, False), ("reaction_y_N", 1e-5, True),
     ("tip_y_mm", 1e-7, False), ("tip_y_mm", 1e-4, True), ("twist_angle_deg", 1e-6, False)],
)  # fmt: skip
def test_noise_is_no_figure(name, size, shown, tmp_path):
    """Beside a stored energy of 30 mJ in an actuator of 80 mm."""
    rows = [{"pressure_kPa": 10.0 * n, name: size * n, "strain_energy_mJ": 15.0 * n}
            for n in range(3)]  # fmt: skip
    assert (name in curves.measures(write(tmp_path / "r", rows))) is shown


def test_the_axis_of_no_bending_is_no_figure(tmp_path):
    for angle, shown in ((1e-9, False), (30.0, True)):
        rows = [{"pressure_kPa": 1.0 * n, "bending_angle_deg": angle * n, "bending_axis_z": 1.0}
                for n in range(3)]  # fmt: skip
        results = write(tmp_path / f"{angle}", rows)
        assert ("bending_axis_z" in curves.measures(results)) is shown


@pytest.mark.parametrize(
    "name, text, meant",
    [("principal_stress_p999_MPa", "Principal stress exceeded in 0.1 % of the volume (MPa)",
      "exceeded in 0.1 % of the region's volume"),
     ("principal_stress_p999_core_MPa",
      "Principal stress exceeded in 0.1 % of the volume, core (MPa)", "exceeded in 0.1 %"),
     ("principal_stress_peak_MPa", "Principal stress at its highest node (MPa)",
      "grows under refinement"),
     ("failure_pressure_peak_kPa", "Failure pressure by the highest node (kPa)", "nodal mean"),
     ("failure_pressure_kPa", "Failure pressure (kPa)", "reaches the strength"),
     ("volume_change_max", "Volume change at the worst point (%)", "mostly at a sharp corner"),
     ("pressure_upper_kPa", "Pressure upper (kPa)", "pressure in the cavity"),
     ("pressure_kPa", "Pressure (kPa)", "pressure in the cavity"),
     ("max_von_mises_MPa", "Largest von Mises stress (MPa)", "largest von Mises stress"),
     ("nothing_known_mm", "Nothing known (mm)", "")],
)  # fmt: skip
def test_each_figure_says_what_it_is(name, text, meant):
    assert str(labels.column(name)) == text
    assert meant in labels.meaning(name)
    assert "p999" not in text and "peak" not in text


def test_what_rounds_to_zero_has_no_sign():
    assert labels.number(-1e-5, largest=6.85) == "0.000"
    assert labels.number(-0.5, largest=6.85) == "−0.500"

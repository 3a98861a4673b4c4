"""Force over angle and pressure: of an actuator whose force is known, from runs that hold it."""

import numpy as np
import pytest

from softact.report import force_angle
from softact.report.force_angle import ANGLE, CELL

STIFFNESS, SLOPE = 0.05, 4.0  # N/deg; deg/kPa: force = STIFFNESS (SLOPE pressure - angle)


def held_at(begin, end=20.0, states=9):
    """Columns of a run that bends freely up to a pressure and is held there from then on."""
    free, hold = np.linspace(0, begin, 5), np.linspace(begin, end, states)[1:]
    pressure = np.concatenate([free, hold])
    angle = SLOPE * np.minimum(pressure, begin)
    force = STIFFNESS * (SLOPE * pressure - angle)
    on = np.concatenate([np.zeros(len(free), bool), np.ones(len(hold), bool)])
    tip = {f"tip_force_{c}_N": np.where(on, part * force, np.nan)
           for c, part in zip("xyz", (0.6, 0.0, -0.8), strict=True)}  # fmt: skip
    return {"pressure_kPa": pressure, ANGLE: angle, **tip}


def runs(*begins):
    """Their held states, by the force of the tip."""
    found = []
    for columns in map(held_at, begins):
        (exerted,) = force_angle.forces(columns).values()
        found.append(force_angle.held(columns, exerted))
    return found


def test_a_characteristic_falls_to_zero_where_the_actuator_would_be_free():
    points = force_angle.characteristic(runs(0.5, 5.0, 10.0, 15.0), 12.0)
    assert points[:, 0] == pytest.approx([2.0, 20.0, 40.0, 48.0])  # the last: free at 12 kPa
    assert points[:, 1] == pytest.approx(STIFFNESS * (SLOPE * 12.0 - points[:, 0]), abs=1e-12)


def test_curves_and_map():
    curves, picture = force_angle.plots(runs(0.5, 5.0, 10.0), "Force of the held tip (N)")
    assert curves.x == "Bending angle (°)" and curves.y == "Force of the held tip (N)"
    assert len(curves.traces) == 5  # all end at 20 kPa: even parts up to it
    assert curves.traces[-1]["name"] == "20 kPa"
    trace = picture.traces[0]
    angle, pressure = np.meshgrid(trace["x"], trace["y"])
    z = np.array(trace["z"], float)  # None becomes NaN
    exact = STIFFNESS * (SLOPE * pressure - angle)
    there = np.isfinite(z)
    np.testing.assert_allclose(z[there], exact[there], atol=1e-3)
    assert (exact[there] > -1e-6).all()  # nothing is known of angles beyond the free one
    inside = (angle >= 2.0) & (angle <= 40.0) & (exact > 0.05) & (pressure > 0.6)
    assert there[inside].mean() > 0.95
    assert [len(column) for column in picture.table.values()] == [z.size] * 3


def test_no_figure_where_all_hold_at_one_angle():
    assert force_angle.plots(runs(5.0, 5.0), "Force of the held tip (N)") == []
    assert force_angle.plots([], "Force (N)") == []
    assert force_angle.forces({"pressure_kPa": np.arange(3.0), ANGLE: np.arange(3.0)}) == {}


def test_a_load_cell_counts_from_its_contact():
    pressure = np.array([0.0, 5.0, 10.0, 15.0, 20.0])
    columns = {"pressure_kPa": pressure, ANGLE: 2 * pressure, CELL: np.array([0, 0, 0, 0.3, 0.6])}
    (exerted,) = force_angle.forces(columns).values()
    run = force_angle.held(columns, exerted)
    assert run.pressure.tolist() == [10.0, 15.0, 20.0]
    assert run.exerted.tolist() == [0.0, 0.3, 0.6]
    assert run.at(12.5) == pytest.approx((25.0, 0.15))
    assert run.at(9.0) is None

"""Cycles and creep out of a curve, against what is known of curves in closed form."""

from types import SimpleNamespace

import numpy as np
import pytest

from softact.verdict import in_time


def curve(times, steps, **columns):
    return SimpleNamespace(curve={"time_s": times, "step": np.array(steps), **columns})


def test_area_of_ellipses():
    """p = 20 (1 − cos ωt), V = 500 − 50 cos(ωt − δ): the loop's area is π a b sin δ. Twice."""
    phase, delta = np.linspace(0.0, 4 * np.pi, 801), 0.3
    pressure, volume = 20 * (1 - np.cos(phase)), 500 - 50 * np.cos(phase - delta)
    both = curve(
        phase / 10, ["cycles"] * len(phase), pressure_kPa=pressure, cavity_volume_mm3=volume
    )
    found = in_time.cycles(both)
    assert [c.step for c in found] == ["cycles"] * 2
    for number, cycle in enumerate(found):
        assert cycle.begin == pytest.approx(number * np.pi / 5, abs=1e-9)
        assert cycle.lost == pytest.approx(np.pi * 20 * 50 * np.sin(delta) / 1e3, rel=1e-4)
    rising = np.linspace(0.0, np.pi, 20001)
    work = np.trapezoid if hasattr(np, "trapezoid") else np.trapz
    loading = work(20 * (1 - np.cos(rising)), 500 - 50 * np.cos(rising - delta)) / 1e3
    assert found[0].work == pytest.approx(loading, rel=1e-4)
    (first, second) = in_time.lines(both)
    assert first.startswith("step 'cycles', cycle 1: 0.9284 of ")
    assert "cycle 2" in second


def test_creep_of_an_exponential():
    """1 − exp(−t/τ), held for 5 τ: 63 % and 95 % of what is seen, by the inverse."""
    times = np.linspace(0.0, 10.0, 2001)
    angle = 40 + 5 * (1 - np.exp(-times / 2))
    steps = ["up"] + ["held"] * (len(times) - 1)
    held = curve(times, steps, pressure_kPa=np.full_like(times, 20.0), bending_angle_deg=angle)
    (creep,) = in_time.creeps(held)
    whole = 1 - np.exp(-5)
    assert (creep.step, creep.column) == ("held", "bending_angle_deg")
    assert creep.end - creep.begin == pytest.approx(5 * whole)
    assert creep.to_63 == pytest.approx(-2 * np.log(1 - 0.63 * whole), rel=1e-4)
    assert creep.to_95 == pytest.approx(-2 * np.log(1 - 0.95 * whole), rel=1e-4)
    (line,) = in_time.lines(held)
    assert line.startswith("step 'held': bending angle creeps from 40 to 44.97 deg in 10 s")


def test_nothing_is_said_without_a_clock_or_a_cycle():
    ramp = np.linspace(0.0, 1.0, 11)
    steps = ["up"] * 11
    columns = {"pressure_kPa": 10 * ramp, "cavity_volume_mm3": 100 + ramp}
    assert not list(in_time.lines(curve(ramp, steps, **columns)))
    assert not list(in_time.lines(SimpleNamespace(curve={"step": np.array(steps), **columns})))

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


@pytest.mark.parametrize("begins", [0.0, 0.5])
def test_a_small_to_and_fro_on_the_way_is_no_cycle(begins):
    """One cycle of 40 kPa, whether its step begins low or high; ripples of 0.3 kPa on it."""
    turns = np.linspace(begins, begins + 2.0, 4001)
    pressure = 20 * (1 - np.cos(2 * np.pi * turns)) + 0.3 * np.sin(2 * np.pi * 60 * turns)
    volume = 500 + pressure
    both = curve(turns, ["go"] * 4001, pressure_kPa=pressure, cavity_volume_mm3=volume)
    found = in_time.cycles(both)
    assert len(found) == (2 if begins == 0.0 else 1)
    assert all(cycle.end - cycle.begin == pytest.approx(1.0, abs=0.02) for cycle in found)
    assert all(abs(cycle.lost) < 1e-3 * cycle.work + 0.02 for cycle in found)


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


def filled(payload=(0.0, -3.0)):
    """A vessel of 1000 mm³ that fills to 20 kPa as 1 − exp(−t/τ), overshoots by 1 % and stays."""
    times = np.linspace(0.0, 3.0, 601)
    pressure = 20 * (1 - np.exp(-times / 0.3))
    pressure[-50:] += 0.2 * np.sin(np.linspace(0, np.pi, 50))
    ambient, litre = in_time.AMBIENT * 1e3, in_time.NORMAL_LITRE / 1e-3
    used = pressure * 1000 / litre
    columns = {
        "pressure_kPa": pressure,
        "cavity_volume_mm3": np.full_like(times, 1000.0) + times,
        "air_used_nl": used,
        "air_flow_nl_per_min": np.gradient(used, times) * 60,
        "air_exergy_mJ": used * ambient,
        "pressure_work_mJ": times * 2,
        "payload_energy_mJ": np.linspace(*payload, len(times)),
    }
    return curve(times, ["fill"] * len(times), **columns)


def test_a_swing_about_a_pressure_that_stays_is_no_cycle():
    assert in_time.cycles(filled()) == []


def test_what_a_supply_has_filled():
    """Air by the closed form of a rigid vessel; 63 % after τ ln(1/0.37), 95 % after τ ln 20."""
    (one,) = in_time.supplied(filled())
    assert one.pressure == pytest.approx(20.0, rel=1e-3)
    assert one.to_63 == pytest.approx(0.3 * np.log(1 / 0.37), rel=2e-3)
    assert one.to_95 == pytest.approx(0.3 * np.log(20), rel=2e-3)
    assert one.work == pytest.approx(6.0) and one.lifted == pytest.approx(-3.0)
    assert one.used == pytest.approx(20.0 * 1000 / (in_time.NORMAL_LITRE / 1e-3), rel=1e-3)
    assert one.flow == pytest.approx(60 * one.used / 0.3, rel=0.02)


def test_a_payload_that_sinks_has_no_efficiency():
    (line,) = in_time.lines(filled())
    assert "6 mJ of work, the payload sinks by 3 mJ, at most " in line and "efficiency" not in line
    (line,) = in_time.lines(filled((0.0, 3.0)))
    exergy = filled().curve["air_exergy_mJ"][-1]
    assert f"3 mJ on the payload (efficiency {3 / exergy:.3%})" in line

"""Gain and phase of steps that swing, against a first-order lag: gain 1/√(1 + ω²τ²), atan ωτ."""

from types import SimpleNamespace

import numpy as np
import pytest
import scipy.integrate

from softact.report import curves
from softact.verdict.frequency_response import band, harmonics, lines

TAU, RATIO = 0.05, 3.0  # s, degrees for 1 kPa
FREQUENCIES = (0.1, 1.0, 5.0, 10.0)


def lagging(frequencies=FREQUENCIES, drive=20.0, increments=60, cycles=6):
    """A run in which an angle follows the pressure with a time constant."""
    columns = {name: [] for name in ("step", "time_s", "pressure_kPa", "bending_angle_deg")}
    steps, start, angle = [], 0.0, 0.0
    for number, frequency in enumerate(frequencies):
        times = np.linspace(0, cycles / frequency, increments * cycles + 1)

        def pressure(t, frequency=frequency):
            return drive * (1 - np.cos(2 * np.pi * frequency * t)) / 2

        found = scipy.integrate.solve_ivp(
            lambda t, y, pressure=pressure: (RATIO * pressure(t) - y) / TAU,
            (0, times[-1]), [angle], t_eval=times, rtol=1e-9, atol=1e-9,
        )  # fmt: skip
        rows = slice(0 if number == 0 else 1, None)
        angle = found.y[0, -1]
        columns["step"] += [f"at_{frequency:g}"] * len(times[rows])
        columns["time_s"] += list(start + times[rows])
        columns["pressure_kPa"] += list(pressure(times[rows]))
        columns["bending_angle_deg"] += list(found.y[0][rows])
        start += times[-1]
        sine = {"sine": {"frequency": f"{frequency} Hz", "cycles": cycles}}
        steps.append({"name": f"at_{frequency:g}", "amplitude": sine})
    curve = {name: np.array(values) for name, values in columns.items()}
    return SimpleNamespace(curve=curve, spec={"steps": steps})


def test_a_first_order_lag():
    found = harmonics(lagging())
    turns = 2 * np.pi * np.array(FREQUENCIES) * TAU
    assert [one.frequency for one in found] == list(FREQUENCIES)
    assert [one.gain for one in found] == pytest.approx(RATIO / np.hypot(1, turns), rel=2e-3)
    assert [one.lag for one in found] == pytest.approx(np.degrees(np.arctan(turns)), abs=0.2)
    assert [one.mean for one in found] == pytest.approx([30.0] * 4, rel=1e-2)
    assert found[0].drive == "pressure_kPa" and found[0].amplitude == pytest.approx(30, rel=2e-3)


def test_the_band_ends_where_the_gain_has_fallen_to_71_percent():
    """At 1/(2πτ) = 3.18 Hz, wherever the steps beside it lie."""
    for frequencies in ((0.1, 3.0, 3.4), FREQUENCIES):
        found = band(harmonics(lagging(frequencies)))
        assert found == pytest.approx((1 / (2 * np.pi * TAU), True), rel=5e-3)
    assert band(harmonics(lagging((0.1, 1.0)))) == (1.0, False)
    assert band(harmonics(lagging((1.0,)))) is None


def test_the_words():
    *each, last = lines(lagging())
    assert each[1].startswith("step 'at_1': at 1 Hz bending angle swings by 28.59 deg")
    assert each[1].endswith("gain 2.862 deg/kPa, 17.4 deg behind the pressure")
    assert last.startswith("the gain falls to 71 % of that at 0.1 Hz at 3.")
    assert "stays above" in list(lines(lagging((0.1, 1.0))))[-1]


def test_without_a_pressure_the_loads_are_the_drive():
    run = lagging((1.0,))
    half = run.curve["pressure_kPa"].max() / 2
    wanted = harmonics(run)[0]
    del run.curve["pressure_kPa"]
    (one,) = harmonics(run)
    assert one.drive == "" and one.gain == pytest.approx(half * wanted.gain, rel=1e-3)
    assert one.lag == pytest.approx(wanted.lag, abs=0.1)


def test_less_than_a_cycle_and_no_sine_say_nothing():
    assert harmonics(lagging((1.0,), cycles=1)) != []
    short = lagging((1.0,))
    short.spec["steps"][0]["amplitude"]["sine"]["frequency"] = "0.1 Hz"
    assert harmonics(short) == []
    short.spec["steps"][0]["amplitude"] = "ramp"
    assert harmonics(short) == [] and list(lines(short)) == []


def test_the_report_has_gain_and_phase_over_the_frequency():
    gain, phase = curves._over_frequency(lagging())
    assert gain.logarithmic and gain.y == "Gain (°/kPa)" and gain.x == "Frequency (Hz)"
    assert list(gain.series[0][1]) == list(FREQUENCIES) and phase.series[0][2][-1] < -70
    assert curves._over_frequency(lagging((1.0,))) == []


def test_the_report_draws_the_last_cycle_at_each_frequency():
    (chart,) = curves._loops(lagging())
    assert chart.title == "Bending angle, last cycle" and chart.x == "Pressure (kPa)"
    assert [name for name, _, _ in chart.series] == [f"{f:g} Hz" for f in FREQUENCIES]
    for _, pressure, angle in chart.series:
        assert len(pressure) == 61 and np.ptp(pressure) == pytest.approx(20, rel=1e-6)
        assert abs(pressure[-1] - pressure[0]) < 1e-6 and abs(angle[-1] - angle[0]) < 0.02 * 20
    assert curves._loops(lagging((1.0,))) == []

"""Constants with memory out of records that were made with known ones, by other formulas.

Loops by Ogden and Roxburgh's closed form with scipy's erf, rates and creep by the differential
equation of each Maxwell element (``tests.analytic.maxwell``).
"""

import json
import re

import numpy as np
import pytest
import yaml
from scipy.special import erf

import softact
from softact.cli.main import main
from softact.errors import SpecError
from softact.fit.candidates import chosen
from softact.fit.memory_fit import Question, best, fit_memory
from softact.fit.record import Record, read_records
from softact.fit.sheet import TestSheet
from softact.materials import parse_material
from softact.materials.viscoelastic import Viscoelastic
from tests.analytic import maxwell

NEO = chosen("neo_hookean", False)[0]
C10, R, M, BETA = 0.1, 1.6, 0.02, 0.15
LOOPS = ((1.0, 1.3), (1.3, 1.0), (1.0, 1.6), (1.6, 1.0), (1.0, 1.9), (1.9, 1.0))
ACROSS = {"uniaxial": lambda s: s**-0.5, "equibiaxial": lambda s: s, "planar": lambda s: 1 + 0 * s}
MADE = Viscoelastic(g=[0.15, 0.1], tau=["0.3 s", "12 s"], constants="long_time")


def loops(mode="uniaxial", ways=LOOPS, r=R, m=M, beta=BETA, noise=0.0, seed=0):
    """A record of neo-Hooke's law with softening: cycles to stretches that grow."""
    stretch = np.concatenate([np.linspace(a, b, 30)[i > 0 :] for i, (a, b) in enumerate(ways)])
    across = ACROSS[mode](stretch)
    energy = C10 * (stretch**2 + across**2 + (stretch * across) ** -2 - 3)
    peak = np.maximum.accumulate(energy)
    eta = 1 - erf((peak - energy) / np.maximum(m + beta * peak, 1e-300)) / r
    stress = eta * 2 * C10 * (stretch**2 - (stretch * across) ** -2) / stretch
    scatter = noise * stress.max() * np.random.default_rng(seed).standard_normal(len(stress))
    return Record("loops", mode, stretch, stress + scatter)


def softened(record):
    return best(fit_memory([record], Question(NEO, softens=True)))


@pytest.mark.parametrize("mode", ACROSS)
def test_exact_loops_give_their_constants(mode):
    found = softened(loops(mode))
    assert found.vector == pytest.approx([C10], rel=1e-5)
    assert found.softening == pytest.approx({"r": R, "m": M, "beta": BETA}, rel=1e-4)


def test_the_constants_of_loops_are_in_their_intervals():
    """0.5 % of noise, 20 records: each of the four in its 95 % interval, less three standard
    deviations of a count of 20."""
    truth = {"r": R, "m": M, "beta": BETA}
    inside = []
    for seed in range(20):
        found = softened(loops(noise=5e-3, seed=seed))
        assert set(found.softening) == set(truth)
        near = [abs(found.softening[n] - v) <= found.softening_error[n] for n, v in truth.items()]
        inside.append([*near, abs(found.vector[0] - C10) <= found.law_error[0]])
    assert np.mean(inside, axis=0).min() > 0.80


def test_one_of_m_and_beta_where_the_other_is_nothing():
    """By BIC, with noise."""
    assert set(softened(loops(beta=0.0, noise=3e-3)).softening) == {"r", "m"}
    assert set(softened(loops(m=0.0, beta=0.4, noise=3e-3)).softening) == {"r", "beta"}


def test_peaks_that_are_alike_do_not_part_m_from_beta():
    found = softened(loops(ways=((1.0, 1.6), (1.6, 1.0), (1.0, 1.6), (1.6, 1.1))))
    width = M + BETA * C10 * (1.6**2 + 2 / 1.6 - 3)
    assert found.peaks_alike
    assert found.softening == pytest.approx({"r": R, "m": width}, rel=1e-4)


def ramps(noise=0.0, seed=0):
    """Neo-Hooke's law pulled to 1.5 and back to 1.1 at three rates."""
    records, rng = [], np.random.default_rng(seed)
    for rate in (0.02, 0.2, 2.0):
        times = np.linspace(0.0, 0.9 / rate, 91)
        stretch = np.where(times < 0.5 / rate, 1 + rate * times, 1.5 - rate * (times - 0.5 / rate))
        force = maxwell.force_of_stretch(
            MADE.prony,
            lambda t, r=rate: 1 + r * t if t < 0.5 / r else 1.5 - r * (t - 0.5 / r),
            times,
        )
        stress = np.array(force) * (1 + 0 * times)
        scatter = noise * stress.max() * rng.standard_normal(len(stress))
        records.append(Record(f"rate {rate}", "uniaxial", stretch, stress + scatter, times))
    return records


def test_several_rates_give_the_elements_and_the_law():
    found = best(fit_memory(ramps(1e-3), Question(NEO, creeps=True)))
    assert found.vector == pytest.approx([maxwell.C10], rel=5e-3)
    assert len(found.series.g) == 2
    assert (np.abs(found.series.g - MADE.g) <= 1.5 * found.series.g_error + 2e-3).all()
    np.testing.assert_allclose(found.series.g, MADE.g, rtol=0.03)
    np.testing.assert_allclose(found.series.tau, MADE.tau, rtol=0.05)
    assert (found.series.g_error < 0.01).all()


def held(noise=0.0, seed=0):
    """Loaded to 0.2 MPa in 0.5 s and held for 60 s: the stretch is noisy, not the stress."""
    times = np.concatenate([np.linspace(0.0, 0.5, 21), 0.5 + np.geomspace(0.02, 60.0, 100)])
    stress = 0.2 * np.minimum(times / 0.5, 1.0)
    stretch = np.array(
        maxwell.stretch_of_force(MADE.prony, lambda t: 0.2 * min(t / 0.5, 1.0), times)
    )
    scatter = noise * np.random.default_rng(seed).standard_normal(len(times))
    return Record("held", "uniaxial", stretch + scatter, stress, times)


def test_creep_gives_the_elements_and_the_law():
    found = best(fit_memory([held(2e-4)], Question(NEO, creeps=True, by_stretch=True)))
    assert found.vector == pytest.approx([maxwell.C10], rel=0.01)
    assert len(found.series.g) == 2
    np.testing.assert_allclose(found.series.g, MADE.g, rtol=0.05)
    np.testing.assert_allclose(found.series.tau, MADE.tau, rtol=0.1)
    assert found.series.rms < 6e-4


def test_both_memories_at_once():
    """Made by the integral itself: the elements are driven by the softened stress."""
    from softact.fit.history import History
    from softact.materials.mullins import Mullins

    law = NEO.constants(np.array([C10]))
    softening = Mullins(r=R, m=f"{M} MPa", beta=BETA)
    records = []
    for duration in (1.0, 60.0):
        stretch = loops().stretch
        times = np.linspace(0.0, duration, len(stretch))
        made = Record(f"{duration}", "uniaxial", stretch, stretch, times)
        stress = History(made).stress(NEO.law, law, softening, MADE.prony)
        records.append(Record(made.name, "uniaxial", stretch, stress, times))
    found = best(fit_memory(records, Question(NEO, softens=True, creeps=True)))
    assert found.vector == pytest.approx([C10], rel=1e-3)
    assert found.softening == pytest.approx({"r": R, "m": M, "beta": BETA}, rel=1e-2)
    np.testing.assert_allclose(found.series.g, MADE.g, rtol=1e-2)


def write(path, record, heading="time (s),stretch,nominal stress (kPa)"):
    times = np.arange(len(record.stretch)) if record.times is None else record.times
    rows = [
        f"{t!r},{s!r},{1e3 * p!r}"
        for t, s, p in zip(
            times.tolist(), record.stretch.tolist(), record.stress.tolist(), strict=True
        )
    ]
    path.write_text("\n".join([heading, *rows]))


def command(tmp_path, *arguments):
    with pytest.raises(SystemExit) as stop:
        main(["fit", *arguments, "-o", str(tmp_path / "out")])
    return stop.value.code


def test_command_writes_a_card_that_holds_what_was_found(tmp_path, capsys):
    file = tmp_path / "loops.csv"
    write(file, loops(noise=1e-3))
    assert command(tmp_path, str(file), "--cyclic", "--law", "neo_hookean") == 0
    told = capsys.readouterr().out
    assert re.search(r"r, m, beta: 0\.\d+%.*<- taken", told)
    law = parse_material(yaml.safe_load((tmp_path / "out/loops.yaml").read_text()))
    assert law.mullins.r == pytest.approx(R, rel=0.02)
    assert law.mullins.m == pytest.approx(M, rel=0.05)
    assert law.c10 == pytest.approx(C10, rel=0.01)
    numbers = json.loads((tmp_path / "out/loops.json").read_text())
    assert numbers[0]["mullins_confidence_95"]["r"] < 0.02
    assert (tmp_path / "out/loops.png").stat().st_size > 10_000


def test_a_card_of_rates_runs(tmp_path, capsys):
    """Fitted at three rates, then a block under the card, held at a pressure: it creeps."""
    files = []
    for i, record in enumerate(ramps(1e-3)):
        files.append(tmp_path / f"rate{i}.csv")
        write(files[-1], record)
    assert command(tmp_path, *map(str, files), "--rates", "--law", "neo_hookean") == 0
    card = yaml.safe_load((tmp_path / "out/rate0.yaml").read_text())
    assert len(card["viscoelastic"]["g"]) == 2
    spec = {
        "name": "held",
        "geometry": {"type": "thick_sphere", "mesh_size": "4 mm"},
        "materials": {"body": card},
        "steps": [
            {"name": "up", "pressure": "10 kPa", "duration": "10 ms"},
            {"name": "held", "duration": "10 s", "amplitude": "hold"},
        ],
    }
    (tmp_path / "spec.yaml").write_text(yaml.safe_dump(spec))
    sheet = softact.run(tmp_path / "spec.yaml", tmp_path / "run", processes=1, report=False)
    assert sheet.status == "complete"
    volume = sheet.curve["cavity_volume_mm3"].to_numpy()
    assert volume[-1] > volume[list(sheet.curve["step"]).index("held")] > volume[0]


@pytest.mark.parametrize(
    "rows,line",
    [
        (lambda t: t - 3.0, "loops.csv:2: time -3 s is below zero"),
        (lambda t: np.where(t == 7, 2.0, t), "loops.csv:9: time runs back from 6 s to 2 s"),
    ],
)
def test_times_that_cannot_be(tmp_path, capsys, rows, line):
    file, made = tmp_path / "loops.csv", loops()
    write(file, Record("loops", "uniaxial", made.stretch, made.stress, rows(np.arange(175.0))))
    assert command(tmp_path, str(file), "--rates") == 2
    told = capsys.readouterr().err.strip().splitlines()
    assert len(told) == 1 and line in told[0]
    assert not (tmp_path / "out").exists()


def test_what_cannot_be_fitted(tmp_path, capsys):
    made = loops()
    with pytest.raises(SpecError, match="the stretch never goes back"):
        fit_memory([loops(ways=LOOPS[:1])], Question(NEO, softens=True))
    with pytest.raises(SpecError, match="wrong sign"):
        softened(Record("a", "uniaxial", made.stretch, -made.stress))
    file = tmp_path / "plain.csv"
    write(file, made, "number,stretch,nominal stress (kPa)")
    with pytest.raises(SpecError, match=r"no column of time; head one 'time \(s\)'"):
        read_records(TestSheet(file=file), timed=True)
    write(file, made, "time,stretch,nominal stress (kPa)")
    with pytest.raises(SpecError, match=r"'time' has no unit; write 'time \(s\)'"):
        read_records(TestSheet(file=file), timed=True)
    write(file, made, "time (mm),stretch,nominal stress (kPa)")
    with pytest.raises(SpecError, match=r"'time \(mm\)': "):
        read_records(TestSheet(file=file), timed=True)
    with pytest.raises(SpecError, match="--loading would tear the record"):
        read_records(TestSheet(file=file, loading=True), timed=False)
    assert command(tmp_path, str(file), "--cyclic", "--law", "all") == 2
    assert "name one law" in capsys.readouterr().err
    assert command(tmp_path, str(file), "--cyclic", "--relative") == 2
    assert "--relative does not go with" in capsys.readouterr().err

"""Maxwell elements out of relaxation tests that were made with known ones."""

import numpy as np
import pytest

from softact.cli.main import main
from softact.errors import SpecError
from softact.fit.relaxation import best, fit_series, relaxation_of
from softact.materials.viscoelastic import Viscoelastic
from tests.analytic import maxwell

TIMES = np.concatenate([[0.0], np.geomspace(0.01, 100.0, 200)])
G, TAU = (0.15, 0.1), (0.3, 12.0)


def record(noise=0.0, seed=1):
    """σ = 1 + Σ b exp(−t/τ), b = g/g∞, with noise in parts of the largest."""
    rest = 1 - sum(G)
    clean = 1 + sum(g / rest * np.exp(-TIMES / tau) for g, tau in zip(G, TAU, strict=True))
    return clean + noise * clean[0] * np.random.default_rng(seed).standard_normal(len(TIMES))


def fitted(noise, seed=1):
    return best(fit_series(relaxation_of(TIMES, record(noise, seed))))


def test_exact_data_give_their_elements():
    found = fitted(0.0)
    np.testing.assert_allclose(found.g, G, rtol=1e-4)
    np.testing.assert_allclose(found.tau, TAU, rtol=1e-3)
    read = eval_yaml(found.text)
    assert read.constants == "long_time"
    np.testing.assert_allclose(read.g, G, rtol=1e-3)


def eval_yaml(text):
    import yaml

    return Viscoelastic.model_validate(yaml.safe_load(text)["viscoelastic"])


def test_the_truth_is_in_the_intervals_as_often_as_they_say():
    """0.3 % of noise, 30 records: two elements by BIC; each of the four constants in its 95 %
    interval, less three standard deviations of a count of 30 (0.95 in 100 records). Where the
    largest point counts as the beginning of the hold, the first one is in 0.63 of them."""
    inside = []
    for seed in range(30):
        found = fitted(3e-3, seed)
        assert len(found.g) == 2
        assert (found.g_error < 0.003).all() and (found.tau_error < 1.06).all()
        times = np.abs(np.log(found.tau / TAU)) <= np.log(found.tau_error)
        inside.append([*(np.abs(found.g - G) <= found.g_error), *times])
    assert np.mean(inside, axis=0).min() > 0.83


def test_nothing_relaxes():
    """Noise about a constant has no elements."""
    stress = 1 + 1e-3 * np.random.default_rng(3).standard_normal(len(TIMES))
    stress[0] = stress.max() + 1e-6
    fits = fit_series(relaxation_of(TIMES, stress))
    assert len(best(fits).g) == 0


def test_what_relaxes_in_the_loading_is_counted():
    """A neo-Hookean bar pulled to 1.1 in 0.3 s, by the integral in time of ``maxwell``: without the
    loading the fast element would be half as large."""
    made = Viscoelastic(g=list(G), tau=[f"{t} s" for t in TAU], constants="long_time")
    times = np.concatenate([np.linspace(0.0, 0.3, 7), 0.3 + np.geomspace(0.02, 60.0, 80)])
    force = maxwell.force_of_stretch(made.prony, lambda t: 1 + 0.1 * min(t / 0.3, 1.0), times)
    found = best(fit_series(relaxation_of(times, np.array(force))))
    np.testing.assert_allclose(found.g, G, rtol=0.03)
    np.testing.assert_allclose(found.tau, TAU, rtol=0.03)


def test_command(tmp_path, capsys):
    file = tmp_path / "held.csv"
    rows = [f"{1e3 * t},{20 * s}" for t, s in zip(TIMES, record(1e-3), strict=True)]
    file.write_text("\n".join(["Time [ms],stress (kPa)", *rows]))
    with pytest.raises(SystemExit) as stop:
        main(["fit", str(file), "--relaxation"])
    assert stop.value.code == 0
    told = capsys.readouterr().out.rstrip().splitlines()
    assert any("elements: 2," in line and line.endswith("<- taken") for line in told)
    assert told[-1].startswith("viscoelastic: {g: [0.1")
    assert [p.name for p in tmp_path.iterdir()] == ["held.csv"]


@pytest.mark.parametrize(
    "times,stress,line",
    [
        ([0, 1, 0.5, *range(2, 20)], np.ones(20), "time runs back from 1 s to 0.5 s"),
        (np.arange(20), np.arange(20), "1 points from the largest stress on"),
        (np.arange(20), -np.arange(20), "not above zero at both ends"),
    ],
)
def test_what_is_no_relaxation(times, stress, line):
    n = min(len(times), len(stress))
    with pytest.raises(SpecError, match=line):
        relaxation_of(np.array(times[:n], float), np.array(stress[:n], float), "t.csv")

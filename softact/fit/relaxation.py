"""Maxwell elements from a relaxation test: stress over time at a stretch that is held.

With r(t) = σ(t)/σ∞ = 1 + Σ bᵢ cᵢ exp(−t/τᵢ) after a loading of T at a constant rate, bᵢ = gᵢ/g∞
and cᵢ = (1 − exp(−T/τᵢ))/(T/τᵢ): what has relaxed before the stretch was reached. Numbers of
elements are compared by Schwarz's criterion (BIC).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from softact.errors import SpecError
from softact.loads.pressure_file import columns_of
from softact.units import TIME, show

# Median of the second differences of noise with a standard deviation of 1 (0.6745 √6), and how many
# standard deviations the largest of many points is above the truth.
BEND_OF_NOISE, NOISY = 1.652, 4.0
# Elements at most; points that a test needs; standard deviations of 95 %.
MOST, FEWEST, TWO_SIDED = 6, 12, 1.96
# A number of elements is better where its criterion is lower by this (Kass and Raftery 1995).
BETTER = 2.0
# Smallest part of an element that is one: b, and ratio of two neighbouring times.
LEAST_SHARE, APART = 1e-4, 1.5
# Headings of what is held.
_HELD = re.compile(r"\s*(stretch|strain|lambda|displacement|elongation|extension)", re.IGNORECASE)


@dataclass(frozen=True)
class Relaxation:
    """A test. times: (n,) s since the stretch was reached; stress: (n,), any unit; loading: s that
    the loading before it took."""

    times: np.ndarray
    stress: np.ndarray
    loading: float


@dataclass(frozen=True)
class Series:
    """A fit. g, tau (s): of its elements; g_error, tau_error: half of their 95 % intervals, the
    latter a factor (τ/f to τ f). rms: relative to the largest stress. bic: the lower, the better.
    """

    g: np.ndarray
    tau: np.ndarray
    g_error: np.ndarray
    tau_error: np.ndarray
    rms: float
    bic: float

    @property
    def text(self) -> str:
        """As a material of a spec takes it."""
        shares = ", ".join(f"{g:.4g}" for g in self.g)
        times = ", ".join(TIME.format(float(f"{tau:.4g}")) for tau in self.tau)
        return f"viscoelastic: {{g: [{shares}], tau: [{times}], constants: long_time}}"


def relaxation_of(times: np.ndarray, stress: np.ndarray, name: str = "test") -> Relaxation:
    """The test in a record that begins with the loading, or where the stretch is reached.

    times: (n,) s, rising. Raises SpecError where it cannot be a relaxation.
    """
    back = np.flatnonzero(np.diff(times) <= 0)
    if len(back):
        raise SpecError(
            f"{name}: time runs back from {times[back[0]]:g} s to {times[back[0] + 1]:g} s; each "
            "point is later than the one before"
        )
    top = _reached(stress)
    if len(times) - top < FEWEST:
        raise SpecError(
            f"{name}: {len(times) - top} points from the largest stress on; a relaxation needs "
            f"{FEWEST}: the stretch is held, and the stress falls"
        )
    if stress[top] <= 0 or stress[-1] <= 0:
        raise SpecError(f"{name}: the stress is not above zero at both ends of the relaxation")
    return Relaxation(times[top:] - times[top], stress[top:], float(times[top] - times[0]))


def _reached(stress: np.ndarray) -> int:
    """Where the stretch is reached: the first stress (n,) that is the largest but for noise. The
    largest itself would be a point that noise has raised, and those before it would be lost."""
    largest = int(np.argmax(stress))
    bends = np.abs(np.diff(stress[largest:], 2))
    noise = float(np.median(bends)) / BEND_OF_NOISE if len(bends) else 0.0
    return int(np.argmax(stress >= stress[largest] - NOISY * noise))


def fit_series(test: Relaxation) -> list[Series]:
    """Fits with 0, 1, 2, ... elements, as far as all of them are distinct, above zero and known (no
    95 % interval holds zero), and one beyond the best."""
    found = [_fit(test, 0)]
    for count in range(1, MOST + 1):
        one = _fit(test, count)
        rest = np.sort(one.tau)
        merged = count > 1 and (rest[1:] / rest[:-1]).min() < APART
        if one.g.min() < LEAST_SHARE or merged or (one.g_error >= one.g).any():
            break
        found.append(one)
        if one.bic > found[-2].bic:
            break  # more would only follow the noise
    return found


def best(fits: list[Series]) -> Series:
    """The fewest elements that none beats by more than ``BETTER``."""
    lowest = min(fit.bic for fit in fits)
    return next(fit for fit in fits if fit.bic <= lowest + BETTER)


def _model(test: Relaxation, parameters: np.ndarray) -> np.ndarray:
    """σ (n,) of log σ∞, log b (k,) and log τ (k,)."""
    rest, (shares, times) = np.exp(parameters[0]), np.exp(parameters[1:].reshape(2, -1))
    x = test.loading / times
    reached = np.where(x > 1e-12, -np.expm1(-x) / np.maximum(x, 1e-12), 1.0)
    fading = np.exp(-test.times[:, None] / times)
    return rest * (1 + fading @ (shares * reached))


def _fit(test: Relaxation, count: int) -> Series:
    """The best of a few starts, their times spread over those of the test."""
    size = float(test.stress.max())
    step, last = float(np.diff(test.times).min()), float(test.times[-1])
    low, high = np.log(step / 3), np.log(10 * last)
    drop = max(1 - test.stress[-1] / size, 1e-3)
    lower = [-np.inf, *[-20.0] * count, *[low] * count]
    upper = [np.inf, *[5.0] * count, *[high] * count]
    results = []
    for spread in (0.5, 0.8, 1.0) if count else (1.0,):
        middle, half = (low + high) / 2, spread * (high - low) / 2
        times = middle + half * np.linspace(-1, 1, count + 2)[1:-1]
        start = np.array([np.log(test.stress[-1]), *[np.log(drop / max(count, 1))] * count, *times])
        results.append(
            least_squares(
                lambda p: (_model(test, p) - test.stress) / size,
                start,
                bounds=(lower, upper),
                xtol=1e-12,
                ftol=1e-12,
                max_nfev=200,
            )
        )
    found = min(results, key=lambda r: r.cost)
    return _series(found.x, found.jac, found.fun, count)


def _series(
    parameters: np.ndarray, jacobian: np.ndarray, residuals: np.ndarray, count: int
) -> Series:
    points, squares = len(residuals), float(residuals @ residuals)
    variance = squares / max(points - len(parameters), 1)
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * variance
    shares, times = np.exp(parameters[1:].reshape(2, -1))
    whole = 1 + shares.sum()
    g = shares / whole
    # g = b/(1 + Σ b) with b = exp(parameter): ∂g/∂(log b) = g (δ − g).
    slope = np.diag(g) - np.outer(g, g)
    among = slope @ covariance[1 : 1 + count, 1 : 1 + count] @ slope.T
    spread = np.sqrt(np.maximum(np.diag(covariance)[1 + count :], 0.0))
    order = np.argsort(times)
    bic = points * np.log(max(squares / points, 1e-300)) + len(parameters) * np.log(points)
    return Series(
        g[order],
        times[order],
        (TWO_SIDED * np.sqrt(np.maximum(np.diag(among), 0.0)))[order],
        np.exp(np.minimum(TWO_SIDED * spread, 50.0))[order],
        float(np.sqrt(squares / points)),
        float(bic),
    )


def tell(test: Relaxation, fits: list[Series], name: str) -> Iterator[str]:
    """What a test says, line by line."""
    fallen = 1 - test.stress[-1] / test.stress[0]
    yield (
        f"{name}: {len(test.times)} points over {test.times[-1]:.4g} s, {fallen:.2%} of the stress "
        f"relaxes; the loading took {test.loading:.4g} s"
    )
    chosen = best(fits)
    for fit in fits:
        mark = "  <- taken" if fit is chosen else ""
        yield (
            f"  elements: {len(fit.g)}, {fit.rms:.3%} of the largest stress (rms), "
            f"BIC {fit.bic:.1f}{mark}"
        )
    rows = zip(chosen.g, chosen.g_error, chosen.tau, chosen.tau_error, strict=True)
    for g, error, tau, factor in rows:
        yield (
            f"  g {g:.4f} ± {error:.4f}, tau {tau:.4g} s (95 %: {tau / factor:.3g} to "
            f"{tau * factor:.3g} s)"
        )
    slowest = chosen.tau.max(initial=0.0)
    if slowest > test.times[-1]:
        yield (
            f"  attention: {slowest:.3g} s is longer than the test; what is left for ever is "
            "a guess"
        )
    yield chosen.text if len(chosen.g) else "nothing relaxes beyond the noise of the test"


def read_relaxation(path: Path) -> Relaxation:
    """Read a CSV file of time and stress, with units in its header; a column of the stretch that is
    held is left out. Raises SpecError."""
    columns = columns_of(path, "time (s),stress (kPa)", without=_HELD)
    if set(columns) - {"time"} == set() or len(columns) != 2 or "time" not in columns:
        raise SpecError(
            f"{path.name}: a column of time and one of stress or force are wanted, not "
            f"{show(', '.join(columns))}"
        )
    (stress,) = (values for name, values in columns.items() if name != "time")
    return relaxation_of(columns["time"], stress, path.name)

"""Stress of a material with memory along a record, in a homogeneous incompressible deformation.

The law's isochoric second Piola-Kirchhoff stress S is softened first (Ogden and Roxburgh 1999), and
then drives the Maxwell elements by the recurrence of the solver (``materials.viscoelastic``).
Between two rows of a record the stretch goes along a straight line in its logarithm.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.linalg import solve_banded

from softact.fit.candidates import Constants
from softact.fit.modes import MODES, sheet_energy
from softact.fit.record import Record
from softact.materials import Law
from softact.materials.mullins import Mullins
from softact.materials.viscoelastic import Prony

LONGEST = 0.02  # of the logarithmic stretch in which S is taken to change at a constant rate


class History:
    """A record, divided where its stretch goes far between two rows."""

    def __init__(self, record: Record):
        self.record = record
        log = np.log(record.stretch)
        parts = np.maximum(np.ceil(np.abs(np.diff(log)) / LONGEST).astype(int), 1)
        #: Places of the rows of the record among all.
        self.rows = np.concatenate([[0], np.cumsum(parts)])
        place = np.arange(self.rows[-1] + 1)
        self.log = np.interp(place, self.rows, log)
        self.times = None if record.times is None else np.interp(place, self.rows, record.times)

    @cached_property
    def _logarithms(self) -> tuple[np.ndarray, np.ndarray]:
        powers = MODES[self.record.mode].powers
        return powers[0] * self.log, powers[1] * self.log

    @cached_property
    def _squares(self) -> np.ndarray:
        """Squares of the stretches along the load and through the free direction (2, n)."""
        first, _, third = MODES[self.record.mode].powers
        return np.exp(2 * self.log * np.array([[first], [third]]))

    def deviators(self, law: type[Law] | Law, k: Constants) -> tuple[np.ndarray, np.ndarray]:
        """S (2, n) along the load and through the free direction, and W̄ (n,), MPa."""
        with np.errstate(all="ignore"):
            jet = sheet_energy(law, k, self._logarithms)
            along, across = (self._whole(slope) for slope in jet.gradient)
            cauchy = np.array([2 * along - across, -along - across]) / 3
            return cauchy / self._squares, self._whole(jet.value)

    def _whole(self, value: np.ndarray | float | None) -> np.ndarray:
        return np.broadcast_to(0.0 if value is None else value, self.log.shape)

    def stress(
        self, law: type[Law] | Law, k: Constants, mullins: Mullins | None, prony: Prony | None
    ) -> np.ndarray:
        """Nominal stress (n,) in MPa at the rows of the record; a part of it may not be finite."""
        driving, energy = self.deviators(law, k)
        if mullins is not None:
            peak = np.maximum.accumulate(energy)
            driving = driving * mullins.softening(energy, peak)[0]
        whole = driving if prony is None else self._relaxed(driving, prony)
        along, across = whole * self._squares
        return ((along - across) / np.exp(self.log))[self.rows]

    def _relaxed(self, driving: np.ndarray, prony: Prony) -> np.ndarray:
        """Elastic and overstress (2, n): h₁ = exp(−Δt/τ) h₀ + γ (S₁ − S₀), the first row sudden."""
        assert self.times is not None
        steps, changes = np.diff(self.times), np.diff(driving, axis=1).T
        if not np.isfinite(driving).all():
            return np.full_like(driving, np.nan)
        whole = prony.elastic * driving
        for share, tau in zip(prony.shares, prony.times, strict=True):
            decay, growth = _step(steps / tau)
            right = np.concatenate([driving[:, :1].T, growth[:, None] * changes])
            bands = np.array([np.ones(len(right)), np.append(-decay, 0.0)])
            whole = whole + share * solve_banded((1, 0), bands, right).T
        return whole

    def stiffness(
        self, law: type[Law] | Law, k: Constants, mullins: Mullins | None, prony: Prony | None
    ) -> np.ndarray:
        """Slope (n,) of the nominal stress by the stretch at each row, its past held, MPa."""
        ends = []
        for move in (1e-5, -1e-5):
            moved = History(self.record)
            moved.log = self.log + move
            ends.append(moved.stress(law, k, mullins, None))
        slope = (ends[0] - ends[1]) / (2e-5 * self.record.stretch)
        if prony is None or self.times is None:
            return slope
        growth = [_step(np.diff(self.times) / tau)[1] for tau in prony.times]
        total = prony.elastic + prony.shares @ np.array(growth)
        first = prony.elastic + prony.shares.sum()
        return slope * np.concatenate([[first], total])[self.rows]


def _step(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """exp(−x) and (1 − exp(−x))/x (n,)."""
    safe = np.maximum(x, 1e-300)
    return np.exp(-x), np.where(x < 1e-12, 1.0, -np.expm1(-safe) / safe)

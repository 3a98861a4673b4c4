"""The law of a rod: the energy of a table at given pressures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softact.modules.energy import Energy
from softact.modules.table import Table

Array = NDArray[np.float64]
STIFFEST = 1e-9  # of the largest compliance: no direction is stiffer


class Section:
    """Energy of a rod by its length, over all six strains, as ``softact.modules.rod.Law`` asks.

    The table's energy is one over forces: at strains (κ, ν) the forces F are where
    W* + F · (ν − ν₀) is largest; that is the energy W, and F is its derivative by ν.

    pressures: (n, m) of n pieces, MPa. more: (n, k) curvatures of their modules beyond the rod's,
    where the ends of the rod bend less than its modules.
    """

    def __init__(self, table: Table, pressures: Array, more: Array):
        self.table, self.pressures, self.more = table, pressures, more
        self._energy: Energy = table.energy
        self._turns = np.flatnonzero(table.turns)
        self._pulls = np.flatnonzero(~table.turns)
        self._rest = np.eye(6)[3 + table.axis][table.free[self._pulls]]
        self._last: tuple[Array, Array] | None = None

    def states(self, strains: Array) -> Array:
        """Curvatures and forces (n, k) of the modules at strains (n, 6) of the rod."""
        return self._places(strains)[:, : self.table.k]

    def _places(self, strains: Array) -> Array:
        """Curvatures, forces and pressures (n, k + m)."""
        if self._last is not None and np.array_equal(self._last[0], strains):
            return self._last[1]
        n, k = len(strains), self.table.k
        places = np.hstack([np.zeros((n, k)), self.pressures])
        places[:, self._turns] = (strains[:, self.table.free] + self.more)[:, self._turns]
        # The energy is quadratic in the forces, so one step finds them.
        first, second = self._energy.both(places)
        short = self._stretched(strains) + first[:, self._pulls]
        soft = _definite(-second[:, self._pulls[:, None], self._pulls])
        places[:, self._pulls] = np.linalg.solve(soft, short[..., None])[..., 0]
        self._last = strains.copy(), places
        return places

    def _stretched(self, strains: Array) -> Array:
        """ν − ν₀ (n, p) of the strains that have a force."""
        return np.asarray(strains[:, self.table.free[self._pulls]] - self._rest)

    def energy(self, strains: Array) -> Array:
        """Of each of n pieces, mJ/mm, from (n, 6)."""
        places = self._places(strains)
        pulled = (places[:, self._pulls] * self._stretched(strains)).sum(axis=1)
        return np.asarray(self._energy.value(places) + pulled)

    def conjugates(self, strains: Array) -> Array:
        """Moment and force (n, 6)."""
        places, free = self._places(strains), self.table.free
        wrench = np.zeros((len(strains), 6))
        wrench[:, free[self._turns]] = self._energy.first(places)[:, self._turns]
        wrench[:, free[self._pulls]] = places[:, self._pulls]
        return wrench

    def derivatives(self, strains: Array) -> tuple[Array, Array]:
        """Moment and force (n, 6), and their derivatives (n, 6, 6), zero where symmetry holds the
        strain."""
        places, free = self._places(strains), self.table.free
        turns, pulls = self._turns, self._pulls
        first, second = self._energy.both(places)
        wrench = np.zeros((len(strains), 6))
        wrench[:, free[turns]] = first[:, turns]
        wrench[:, free[pulls]] = places[:, pulls]
        stiff = np.linalg.inv(_definite(-second[:, pulls[:, None], pulls]))
        across = second[:, turns[:, None], pulls]
        out = np.zeros((len(strains), 6, 6))
        t, p = free[turns], free[pulls]
        mixed = across @ stiff
        out[:, t[:, None], t] = second[:, turns[:, None], turns] + mixed @ across.swapaxes(1, 2)
        out[:, t[:, None], p] = mixed
        out[:, p[:, None], t] = mixed.swapaxes(1, 2)
        out[:, p[:, None], p] = stiff
        return wrench, out

    def air(self, strains: Array) -> Array:
        """By length, mm², of each group (n, m)."""
        return np.asarray(-self._energy.first(self._places(strains))[:, self.table.k :])


def _definite(soft: Array) -> Array:
    """Compliances (n, p, p) with no direction below a small part of the largest one."""
    values, vectors = np.linalg.eigh((soft + soft.swapaxes(1, 2)) / 2)
    least = STIFFEST * np.abs(values).max(axis=1, initial=0.0, keepdims=True)
    if (values > least).all():
        return soft
    values = np.maximum(np.abs(values), least)
    return np.asarray((vectors * values[:, None]) @ vectors.swapaxes(1, 2))

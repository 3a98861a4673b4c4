"""The law of a rod: the energy of a table at given pressures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softact.modules.energy import Energy
from softact.modules.table import Table

Array = NDArray[np.float64]


class Section:
    """Energy of a rod by its length, over all six strains, as ``softact.modules.rod.Law`` asks.

    pressures: (m,) MPa. more: (k,) strains of a module beyond the rod's, where the ends of the rod
    bend less than its modules.
    """

    def __init__(self, table: Table, pressures: Array, more: Array):
        self.table, self.pressures, self.more = table, pressures, more
        self._energy: Energy = table.energy
        self._pick = np.ix_(table.free, table.free)

    def _places(self, strains: Array) -> Array:
        own = self.of_modules(strains)
        return np.hstack([own, np.broadcast_to(self.pressures, (len(own), len(self.pressures)))])

    def of_modules(self, strains: Array) -> Array:
        """Strains (n, k) of the modules, from those of the rod (n, 6)."""
        return np.asarray(strains[:, self.table.free] + self.more)

    def energy(self, strains: Array) -> Array:
        """Of each of n pieces, mJ/mm, from (n, 6)."""
        return self._energy.value(self._places(strains))

    def conjugates(self, strains: Array) -> Array:
        """Moment and force (n, 6)."""
        wrench = np.zeros((len(strains), 6))
        wrench[:, self.table.free] = self._energy.first(self._places(strains))[:, : self.table.k]
        return wrench

    def derivatives(self, strains: Array) -> tuple[Array, Array]:
        """Moment and force (n, 6), and their derivatives (n, 6, 6), zero where symmetry holds the
        strain."""
        first, second = self._energy.both(self._places(strains))
        k = self.table.k
        wrench = np.zeros((len(strains), 6))
        wrench[:, self.table.free] = first[:, :k]
        stiffness = np.zeros((len(strains), 6, 6))
        stiffness[:, self._pick[0], self._pick[1]] = second[:, :k, :k]
        return wrench, stiffness

    def air(self, strains: Array) -> Array:
        """By length, mm², of each group (n, m)."""
        return np.asarray(-self._energy.first(self._places(strains))[:, self.table.k :])

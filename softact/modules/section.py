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
        self._energy: Energy = table.energy.at(pressures)
        self._pick = np.ix_(table.free, table.free)

    def of_modules(self, strains: Array) -> Array:
        """Strains (n, k) of the modules, from those of the rod (n, 6)."""
        return np.asarray(strains[:, self.table.free] + self.more)

    def energy(self, strains: Array) -> Array:
        """Of each of n pieces, mJ/mm, from (n, 6)."""
        return self._energy.value(self.of_modules(strains))

    def derivatives(self, strains: Array) -> tuple[Array, Array]:
        """Moment and force (n, 6), and their derivatives (n, 6, 6), zero where symmetry holds the
        strain."""
        first, second = self._energy.both(self.of_modules(strains))
        wrench = np.zeros((len(strains), 6))
        wrench[:, self.table.free] = first
        stiffness = np.zeros((len(strains), 6, 6))
        stiffness[:, self._pick[0], self._pick[1]] = second
        return wrench, stiffness

    def air(self, strains: Array) -> Array:
        """By length, mm², of each group (n, m)."""
        own = self.of_modules(strains)
        places = np.hstack([own, np.tile(self.pressures, (len(own), 1))])
        return np.asarray(-self.table.energy.first(places)[:, self.table.k :])

"""Pressures as unknowns, each with something else that is prescribed: one bordered row for each.

With K the tangent, R the out-of-balance force, g the derivative of a cavity's volume V with respect
to the displacements and c that of what is prescribed, Newton's step solves K δx = −R + g δq and
c · δx = what is lacking. Cavities driven by volume have c = g. K is factorised as it is and the
row eliminated (block elimination), so pressure limit points, where K is singular, are passed, and
the inertia of K still tells whether the state is stable at constant pressure.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from softact.model import Model
from softact.solve.gas import GasControl
from softact.system.term import State


@dataclass(frozen=True)
class VolumeControl:
    """Prescribed volumes of the meshed part.

    directions: for each row, cavity -> weight w. Row k prescribes Σ w V (mm³ times the weights'
    unit); its unknown q_k adds w q_k to the pressure (MPa) of each of its cavities.
    targets: (k,) the prescribed values.
    """

    directions: Sequence[Mapping[str, float]]
    targets: np.ndarray

    def values(self, model: Model, state: State) -> np.ndarray:
        """Σ w V of each row (k,)."""
        names = {name for direction in self.directions for name in direction}
        volume = {name: model.cavity_volume(state, name) for name in sorted(names)}
        return np.array([sum(w * volume[name] for name, w in d.items()) for d in self.directions])

    def rows(self, pushes: np.ndarray) -> np.ndarray:
        """Derivatives of the values with respect to the unknowns (k, local), ``pushes`` being the
        volumes'."""
        return pushes

    def slopes(self, state: State) -> np.ndarray:
        """Derivatives of the values with respect to the unknown loads themselves (k,)."""
        return np.zeros(len(self.directions))


@dataclass(frozen=True)
class ArcControl:
    """Prescribed way along a direction in the space of displacements (Riks' plane), which also
    passes points where the volume turns back.

    directions: one, as of ``VolumeControl``. start: unknowns (local,) from where the way counts.
    tangent: unit vector (local,), zero at what is no displacement. targets: (1,) the way, mm times
    the square root of a number of nodes.
    """

    directions: Sequence[Mapping[str, float]]
    start: np.ndarray
    tangent: np.ndarray
    targets: np.ndarray

    def values(self, model: Model, state: State) -> np.ndarray:
        """The way so far (1,)."""
        owned = slice(model.unknowns.owned)
        gone = float(self.tangent[owned] @ (state.x - self.start)[owned])
        return np.array([model.sum(gone)])

    def rows(self, pushes: np.ndarray) -> np.ndarray:
        """The tangent, as a row (1, local)."""
        return self.tangent[np.newaxis]

    def slopes(self, state: State) -> np.ndarray:
        """See ``VolumeControl``."""
        return np.zeros(1)


Control = VolumeControl | ArcControl | GasControl


class Border:
    """The bordered rows of one Newton solve.

    fixed: local numbers of the supported unknowns, which do not take part. softening: number of
    directions in which the volume grows while the pressure falls, at the last correction.
    """

    def __init__(self, model: Model, control: Control, fixed: np.ndarray):
        self._model, self._control, self._fixed = model, control, fixed
        self.softening = 0

    def error(self, state: State) -> float:
        """Largest relative error of the prescribed values."""
        values = self._control.values(self._model, state)
        scale = np.maximum(np.abs(values), np.abs(self._control.targets))
        return float(np.max(np.abs(values - self._control.targets) / np.maximum(scale, 1e-300)))

    def gradients(self, state: State) -> np.ndarray:
        """Derivatives of the volumes with respect to the unknowns (k, local), zero at supported
        ones."""
        rows = np.zeros((len(self._control.directions), self._model.unknowns.local))
        for row, direction in zip(rows, self._control.directions, strict=True):
            for name, weight in direction.items():
                self._model.cavities[name].add_volume_gradient(state.x, weight, row)
        rows = np.array([self._model.unknowns.sum_shared(row) for row in rows])
        rows[:, self._fixed] = 0.0
        return rows

    def correct(
        self, state: State, step: np.ndarray, solve: Callable[[np.ndarray], np.ndarray]
    ) -> np.ndarray:
        """Correct Newton's step (x becomes x − step; owned part) and return δq (k,).

        solve: array (owned,) -> K⁻¹ of it (local,).
        """
        owned = self._model.unknowns.owned
        pushes = self.gradients(state)
        rows = np.array(self._control.rows(pushes))
        rows[:, self._fixed] = 0.0
        pushes, rows = pushes[:, :owned], rows[:, :owned]
        answers = np.array([solve(push)[:owned] for push in pushes])
        compliance = self._model.sum(rows @ answers.T) + np.diag(self._control.slopes(state))
        values = self._control.values(self._model, state)
        lacking = self._control.targets - values + self._model.sum(rows @ step)
        try:
            change = np.linalg.solve(compliance, lacking)
            grows = np.linalg.eigvalsh((compliance + compliance.T) / 2)
        except np.linalg.LinAlgError:  # no pressure changes these volumes: the solve fails
            change = grows = np.full(len(lacking), np.nan)
        step -= change @ answers
        self.softening = int(np.sum(grows < 0))
        return change

    def add(self, state: State, change: np.ndarray) -> None:
        """Add δq to the pressures of ``state``."""
        pressure = dict(state["pressure"])
        for direction, q in zip(self._control.directions, change, strict=True):
            for name, weight in direction.items():
                pressure[name] = pressure.get(name, 0.0) + weight * q
        state.put("pressure", pressure)

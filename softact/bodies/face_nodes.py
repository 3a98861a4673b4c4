"""The nodes of a face, a few of which all others follow; known to all processes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from softact.model import Model

FLAT = 1e-6  # of the face's size: what is nearer to a line or plane lies in it


def far_apart(points: np.ndarray) -> list[int]:
    """Which of some points (n, 3) span them: four far apart, three where they lie in a plane, two
    on a line, one where they are one."""
    size = float(np.ptp(points, axis=0).max(initial=0.0))
    chosen = [int(np.linalg.norm(points - points.mean(axis=0), axis=1).argmax())]
    across = points - points[chosen[0]]
    for _ in range(3):
        lengths = np.linalg.norm(across, axis=1)
        farthest = int(lengths.argmax())
        if lengths[farthest] <= FLAT * size:
            break
        chosen.append(farthest)
        way = across[farthest] / lengths[farthest]
        across = across - np.outer(across @ way, way)
    return chosen


class FaceNodes:
    """Nodes of a surface: masters, which span it, and followers, all others.

    spanning: undeformed places of one to four nodes, mm, see ``far_apart``. masters: (m, 3) those
    of them that are masters, ``most`` at most. followers: (k, 3) undeformed places of those that
    this process owns. count: of all nodes. size: of the face, mm.
    """

    def __init__(self, model: Model, name: str, most: int = 4):
        self._model = model
        nodes = model.surfaces.nodes(name)
        nodes = nodes[nodes < model.nodes.owned]
        numbers = model.unknowns.number[model.displacement_dofs[nodes]]
        parts = model.comm.allgather((model.nodes.places[nodes], numbers))
        places, every = (np.concatenate(part) for part in zip(*parts, strict=True))
        chosen = far_apart(places)
        self.spanning = places[chosen]
        chosen = chosen[:most]
        self.count, self.size = len(places), float(np.linalg.norm(np.ptp(places, axis=0)))
        self.masters, self._numbers = places[chosen], every[chosen]
        follows = ~np.isin(numbers[:, 0], self._numbers[:, 0])
        self.followers = model.nodes.places[nodes[follows]]
        self._dofs = model.displacement_dofs[nodes[follows]]
        # Masters that this process owns: which they are, and their unknowns.
        self._mine = np.flatnonzero(np.isin(self._numbers[:, 0], numbers[:, 0]))
        order = [int(np.flatnonzero(numbers[:, 0] == self._numbers[i, 0])[0]) for i in self._mine]
        self._own = model.displacement_dofs[nodes[order]].reshape(-1, 3)
        self._slots = model.assembler.couple(*self._pairs(numbers[follows]))

    def _pairs(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of the matrix, in the order of ``add_tangent``."""
        masters, each = self._numbers.ravel(), len(self._numbers) * 3
        own = np.repeat(numbers, 3, axis=1).ravel(), np.tile(numbers, 3).ravel()
        cross = np.repeat(numbers.ravel(), each), np.tile(masters, numbers.size)
        among = np.repeat(masters, each), np.tile(masters, each)
        rows = np.concatenate([own[0], cross[0], cross[1], among[0]])
        return rows, np.concatenate([own[1], cross[1], cross[0], among[1]])

    @property
    def counts(self) -> float:
        """1 on the process that counts what all know, 0 on others."""
        return float(self._model.comm.rank == 0)

    @property
    def none(self) -> np.ndarray:
        """No forces (k, 3) on the followers."""
        return np.zeros(self.followers.shape)

    def displacements(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Displacements of the followers (k, 3) and of the masters (m, 3). Collective."""
        masters = np.zeros(self.masters.shape)
        masters[self._mine] = x[self._own]
        return x[self._dofs], self._model.sum(masters)

    def add_force(self, followers: np.ndarray, masters: np.ndarray, out: np.ndarray) -> None:
        """Add forces on the followers (k, 3) and this process's share of those on the masters
        (m, 3), N. Collective."""
        out[self._dofs] += followers
        out[self._own] += self._model.sum(masters)[self._mine]

    def add_tangent(self, own: np.ndarray, cross: np.ndarray, among: np.ndarray) -> None:
        """Add blocks of each follower (k, 3, 3), between them and the masters (k, 3, m, 3), and
        this process's share of those among the masters (m, 3, m, 3). Collective."""
        fixed = self._model.assembler.fixed
        free, masters = fixed[self._dofs] == 0, np.zeros(self.masters.shape)
        masters[self._mine] = fixed[self._own] == 0
        masters = self._model.sum(masters)
        own = own * free[:, :, None] * free[:, None]
        cross = (cross * free[:, :, None, None] * masters).ravel()
        among = among * masters[:, :, None, None] * masters
        values = np.concatenate([own.ravel(), cross, cross, among.ravel()])
        self._model.assembler.extra_values[self._slots] += values

    def shares(self) -> np.ndarray:
        """Weights (k, m) with the sum 1 of the masters, with which they span the followers."""
        base = np.vstack([self.masters.T, np.full(len(self.masters), self.size)])
        places = np.column_stack([self.followers, np.full(len(self.followers), self.size)])
        return np.linalg.lstsq(base, places.T, rcond=None)[0].T

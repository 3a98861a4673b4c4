"""Whether facets may have passed each other between two searches for what they may touch."""

from __future__ import annotations

import ctypes
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from softact.contact.rows import rows
from softact.system import jit

if TYPE_CHECKING:
    from mpi4py import MPI

MEMBERS = 32  # facets of a group at most
LITTLE = 0.25  # ratios that nobody asks about are below it


def spheres(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres (k, 3) and radii (k,) of spheres around facets (k, n, 3)."""
    centre = nodes[:, :3].mean(axis=1)
    return centre, np.linalg.norm(nodes - centre[:, None], axis=2).max(axis=1)


class _Facets(ctypes.Structure):
    """``facets_t`` of ``_sight.c``."""

    _fields_ = (
        ("members", ctypes.c_int32),
        *(
            (name, ctypes.c_void_p)
            for name in ("groups", "centre", "motion", "radius", "still", "reach", "side")
        ),
    )


class Sight:
    """The compiled look at how far facets have moved since they looked about; see ``_sight.c``.

    reach: (k,) how far they look, mm; side: (k,) see ``Pairs``.
    """

    def __init__(self, comm: MPI.Comm, reach: np.ndarray, side: np.ndarray):
        library = jit.load_library(comm, Path(__file__).with_name("_sight.c"))
        self._strayed, self._met = library.strayed, library.met
        self._strayed.restype, self._met.restype = ctypes.c_double, ctypes.c_int64
        self._kind = reach, side

    def look(self, before: np.ndarray) -> None:
        """Take places (k, n, 3) of the nodes as those from which facets have looked about."""
        self._before = before
        self._spheres = spheres(before)
        self._groups = _groups(self._spheres[0])

    def strayed(self, now: np.ndarray, least: float = LITTLE) -> float:
        """How much nearer facets have come to others that were out of reach, relative to how far
        they were from them, ``least`` at least; above 1 a pair may have met that was out of reach
        then.

        now: (k, n, 3) places of the nodes, to which they went straight. A body that moves or turns
        as a whole goes as far as it likes.
        """
        if not len(now):
            return least
        moved = self._moved(now)  # its arrays are needed until the call has ended
        return self._strayed(*moved.arguments, ctypes.c_double(least))

    def met(self, now: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pairs i, j (m,) of facets that may have met and were out of reach, both ways and in the
        order of i; see ``strayed``."""
        if not len(now):
            return np.empty(0, np.int64), np.empty(0, np.int64)
        moved = self._moved(now)
        found = rows(partial(self._met, *moved.arguments), 2)
        pairs = np.unique(np.concatenate([found, found[:, ::-1]]), axis=0)
        return pairs[:, 0].astype(np.int64), pairs[:, 1].astype(np.int64)

    def _moved(self, now: np.ndarray) -> _Moved:
        return _Moved(self._spheres, self._groups, now - self._before, *self._kind)


class _Moved:
    """Facets at two times, as ``_sight.c`` takes them. They are compared in groups first, whose
    distance and motion bound those of their members."""

    def __init__(
        self,
        balls: tuple[np.ndarray, np.ndarray],
        groups: np.ndarray,
        moved: np.ndarray,
        reach: np.ndarray,
        side: np.ndarray,
    ):
        """balls: ``spheres`` at the first time. moved: (k, n, 3) by how much nodes have."""
        centre, still = balls
        mean = moved[:, :3].mean(axis=1)
        radius = still + np.linalg.norm(moved - mean[:, None], axis=2).max(axis=1)
        self._pairs = _pairs(*_bounds(groups, centre, mean, radius))
        of_facets: list[np.ndarray] = [groups, centre, mean, radius, still, reach, side]
        kinds = np.int64, float, float, float, float, float, np.int64
        self._arrays = [
            np.ascontiguousarray(values, kind)
            for values, kind in zip(of_facets, kinds, strict=True)
        ]
        self._facets = _Facets(groups.shape[1], *(a.ctypes.data for a in self._arrays))

    @property
    def arguments(self) -> tuple:
        """The first ones of both functions."""
        pairs, bound = self._pairs
        pointers = (ctypes.c_void_p(a.ctypes.data) for a in (pairs, bound))
        return ctypes.c_int64(len(pairs)), *pointers, ctypes.byref(self._facets)


def _pairs(
    centre: np.ndarray, mean: np.ndarray, radius: np.ndarray, spread: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (p, 2) of groups and the ratio (p,) that none of their members exceeds, in falling
    order, from LITTLE on."""
    i, j = np.triu_indices(len(centre))
    way, offset = mean[i] - mean[j], centre[i] - centre[j]
    gone, distance = np.linalg.norm(way, axis=1), np.linalg.norm(offset, axis=1)
    sizes, spreads = radius[i] + radius[j], spread[i] + spread[j]
    part = -np.einsum("pc,pc->p", way, offset) / np.maximum(gone**2, 1e-300)
    nearest = np.linalg.norm(offset + np.clip(part, 0.0, 1.0)[:, None] * way, axis=1)
    # By how much members come nearer: no more than they move, nor than the groups and their sizes.
    nearer = np.minimum(gone, distance - nearest + 2 * sizes) + spreads
    apart = distance - sizes
    bound = np.where(apart > 0, nearer / np.maximum(apart, 1e-300), np.inf)
    order = np.argsort(-bound)
    order = order[bound[order] > LITTLE]
    return np.column_stack([i[order], j[order]]).astype(np.int32), bound[order]


def _groups(centre: np.ndarray) -> np.ndarray:
    """Numbers (g, m) of points near each other, by halving at medians; a group that is not full
    has its first member several times."""
    groups = [np.arange(len(centre))]
    while len(groups[0]) > MEMBERS:
        halves: list[np.ndarray] = []
        for group in groups:
            axis = np.argmax(np.ptp(centre[group], axis=0))
            order = group[np.argsort(centre[group, axis], kind="stable")]
            middle = (len(order) + 1) // 2
            halves += [order[:middle], order[middle:]]
        groups = halves
    size = len(groups[0])
    return np.array([np.concatenate([g, np.repeat(g[:1], size - len(g))]) for g in groups])


def _bounds(
    groups: np.ndarray, centre: np.ndarray, mean: np.ndarray, radius: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Centres (g, 3) and mean motions (g, 3) of groups, radii (g,) around their members, and by how
    much (g,) the motion of one may differ from the mean."""
    g_centre, g_mean = centre[groups].mean(axis=1), mean[groups].mean(axis=1)
    away = np.linalg.norm(centre[groups] - g_centre[:, None], axis=2) + radius[groups]
    spread = np.linalg.norm(mean[groups] - g_mean[:, None], axis=2)
    return g_centre, g_mean, away.max(axis=1), spread.max(axis=1)

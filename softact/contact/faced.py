"""What the points of facets face: looked for among the pairs that may have come near."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from softact.contact.closest import Closest
from softact.contact.pairs import Looking, Pairs
from softact.contact.sight import LITTLE, Sight

if TYPE_CHECKING:
    from mpi4py import MPI

    from softact.contact.chain_facets import ChainFacets
    from softact.contact.whole_facets import WholeFacets

# How deep inside a partner is looked for, of the element size: what is deeper may be on the other
# side of a sheet or of a thin wall.
DEPTH = 0.25


@dataclass(frozen=True)
class Seen:
    """What was found for facets at the places ``nodes`` (k, n, 3) mm.

    partner: (k, 12) facet that each point faces, −1: none; place: (k, 12, 2) on it; gap: (k, 12),
    mm, less the distance below which they press; infinite without a partner. mark: (pairs,) which
    candidates were looked at.
    """

    nodes: np.ndarray
    partner: np.ndarray
    place: np.ndarray
    gap: np.ndarray
    mark: np.ndarray


class Faced:
    """The points of facets and what they face. All methods are collective: each process looks for
    the points of its share of the facets, and knows what was found for all.

    reach: (k,) how far they look, mm. distance: gap below which they press, mm.
    """

    def __init__(
        self,
        comm: MPI.Comm,
        facets: WholeFacets | ChainFacets,
        pairs: Pairs,
        reach: np.ndarray,
        distance: float,
    ):
        self._facets, self.pairs, self._reach = facets, pairs, reach
        self._closest, self._sight = Closest(comm), Sight(comm, reach, pairs.side)
        self._distance, self._depth = distance, DEPTH * facets.size - distance
        self._near = np.full(len(facets), max(distance, 0.0))
        shape = len(facets), len(facets.values)
        gap = np.full(shape, np.inf)
        self._nothing = np.full(shape, -1, np.int32), np.zeros((*shape, 2)), gap
        self._kept = self._nothing[0]  # facet (k, 12) that each point faced last
        self._last: Seen | None = None  # of ``touching``
        self._every: Seen | None = None  # of ``in_reach``

    @property
    def from_where(self) -> np.ndarray:
        """Places (k, n, 3) of the nodes when it looked about, mm."""
        return self.pairs.nodes

    @property
    def faced(self) -> np.ndarray:
        """Facet (k, 12) that each point faced last, −1: none."""
        return self._kept

    @property
    def nothing(self) -> bool:
        """Whether there is nothing that any point may face."""
        return not len(self.pairs.looking.candidate)

    def look_about(self, x: np.ndarray, kept: np.ndarray | None = None) -> None:
        """Find the pairs that may touch before it looks about again. x: (local,) unknowns; kept:
        (k, 12) facets that points face, which they keep where they still are, −1: none."""
        nodes = self._facets.node_places(x)
        self.pairs.search(nodes)
        self._sight.look(nodes)
        self._last = self._every = None
        self._kept = self._nothing[0] if kept is None else kept

    def look_only_at(self, facet: np.ndarray, point: np.ndarray, seen: Seen) -> None:
        """From here on, look only at what these points (m,) of facets (m,) face there."""
        self.pairs.take(facet, seen.partner[facet, point], seen.nodes)
        self._kept = seen.partner
        self._last = self._every = self._looked(seen.nodes, self._all())

    def touching(self, x: np.ndarray) -> Seen:
        """What points face, of those pairs that may touch: all gaps below zero are there, others
        may not be."""
        if self.nothing and self._last is not None:
            return self._last
        nodes = self._facets.node_places(x)
        if self._last is None or not _same(self._last.nodes, nodes):
            self._last = self._looked(nodes, self._close(nodes))
            partner = self._last.partner
            self._kept = np.where(partner < 0, self._kept, partner)
        return self._last

    def in_reach(self, x: np.ndarray) -> Seen:
        """What points face, of all pairs."""
        now = self.touching(x)
        if now.mark.all():
            return now
        if self._every is None or not _same(self._every.nodes, now.nodes):
            self._every = self._looked(now.nodes, self._all())
        return self._every

    def afresh(self, x: np.ndarray) -> Seen | None:
        """What points would face if nothing were known of what they faced before, which they keep
        a little beyond its edges; None: those that touch would face the same."""
        before = self.touching(x)
        if not (before.gap < 0.0).any():
            return None
        kept, self._kept = self._kept, self._nothing[0]
        now = self._looked(before.nodes, before.mark)
        self._kept = kept
        touch = (before.gap < 0.0) | (now.gap < 0.0)
        return now if (touch & (now.partner != before.partner)).any() else None

    def take(self, seen: Seen) -> None:
        """From here on points face what ``afresh`` found."""
        self._last, self._every, self._kept = seen, None, seen.partner

    def before_touching(self, x: np.ndarray, there: np.ndarray) -> Seen:
        """What points face at ``x``, of those pairs that may touch there or at ``there``, where the
        nodes are (k, n, 3)."""
        now = self.touching(x)
        mark = now.mark | self._close(there)
        return now if (mark == now.mark).all() else self._looked(now.nodes, mark)

    def ahead(self, now: np.ndarray) -> Looking:
        """The pairs that may have met on a straight way from where it looked about to ``now``."""
        return self._of_share(self.pairs.near(now, self._near))

    def strayed(self, now: np.ndarray, least: float = LITTLE) -> float:
        """See ``Sight``: since it looked about."""
        return self._sight.strayed(now, least)

    def unseen(self, now: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See ``Sight.met``: since it looked about."""
        return self._sight.met(now)

    def _close(self, nodes: np.ndarray) -> np.ndarray:
        """Which pairs (pairs,) may touch where the facets have these nodes (k, n, 3)."""
        directions = self._closest.directions(nodes)
        return self.pairs.near(nodes, self._near, directions, self._closest.facing)

    def _all(self) -> np.ndarray:
        return np.ones(len(self.pairs.looking.candidate), bool)

    def _of_share(self, mark: np.ndarray) -> Looking:
        """Those pairs of which this process looks after the first facet."""
        if not mark.any():
            return Looking(np.zeros(len(self._facets) + 1, np.int64), np.empty(0, np.int32))
        return self.pairs.looking.of(mark & self._facets.mine[self.pairs.looking.facet])

    def _looked(self, nodes: np.ndarray, mark: np.ndarray) -> Seen:
        """What points face among the pairs of ``mark``, at the places ``nodes``."""
        if not mark.any():
            return Seen(nodes, *self._nothing, mark)
        facets, points = self._facets, self._facets.values
        partner = np.full((len(facets.share), len(points)), -1, np.int32)
        found = np.full((*partner.shape, 3), np.inf)
        numbers, looking = self._of_share(mark).involved()
        on = np.flatnonzero(np.diff(looking.start))  # the others face nothing
        near, looks = nodes[numbers], numbers[on]
        row = np.searchsorted(facets.share, looks)
        faced, place, gap = self._closest(
            points @ near[on],
            near[on],
            near,
            np.append(looking.start[on], looking.start[-1]),
            looking.candidate,
            self._reach[looks],
            self._depth[looks],
            _among(numbers, self._kept[looks]),
            (facets.lies[looks], facets.lies[numbers]),
        )
        partner[row] = np.where(faced < 0, -1, numbers[faced])
        found[row, :, :2], found[row, :, 2] = place, gap - self._distance
        partner, found = facets.from_shares(partner), facets.from_shares(found)
        return Seen(nodes, partner, found[..., :2], found[..., 2], mark)


def _same(a: np.ndarray, b: np.ndarray) -> bool:
    return a is b or np.array_equal(a, b)


def _among(numbers: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Places in the rising ``numbers`` of facets (m, 12), −1 of those that are not there."""
    place = np.minimum(np.searchsorted(numbers, facets), len(numbers) - 1)
    return np.where(numbers[place] == facets, place, -1)

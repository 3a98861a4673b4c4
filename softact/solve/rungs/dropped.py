"""A rung that ends a step in which a free body has been dropped: no smaller increment holds it."""

from __future__ import annotations

from softact.contact.dropped import PLACE, slipping
from softact.solve.rungs.base import Stopped, Trouble, Went
from softact.solve.walk import SMALL, Walk

# Part of the increment below which a step is small, from which on a body that slips has been lost.
SLIPPED = 0.2


class Dropped:
    """Ends the step where the increment has become small and a free body is not held."""

    name = "dropped"

    def may(self, walk: Walk, trouble: Trouble) -> bool:
        """See ``Rung``."""
        if not walk.model.free_bodies or not walk.is_small:
            return False
        if trouble.failed.startswith(PLACE):
            return True
        small = walk.size < SLIPPED * SMALL * walk.largest
        return bool(trouble.failed) and small and bool(slipping(walk.model, walk.state))

    def climb(self, walk: Walk, trouble: Trouble) -> Went | Stopped:
        """See ``Rung``."""
        return Stopped(walk.no_equilibrium(trouble.failed))

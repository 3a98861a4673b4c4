"""The first rung: a smaller increment."""

from __future__ import annotations

from softact.solve.increments import INCREMENTS
from softact.solve.rungs.base import Stopped, Trouble, Went
from softact.solve.walk import Walk

# Newton iterations of a step, after a first inflation, that may bring no increment under load
# control.
MOST_IN_VAIN = 600
LEAST = 0.1  # part of an increment that is kept at least


class SmallerIncrement:
    """Cuts the increment; beyond it where that has become small or has brought nothing."""

    name = "smaller"

    def may(self, walk: Walk, trouble: Trouble) -> bool:
        """See ``Rung``."""
        return bool(trouble.failed)

    def climb(self, walk: Walk, trouble: Trouble) -> Went | Stopped:
        """See ``Rung``."""
        # Where bodies meet on the way, to where they do.
        walk.size *= min(INCREMENTS.cut, max(trouble.apart, LEAST))
        if walk.in_vain() - walk.vain_before > MOST_IN_VAIN:
            return Stopped(walk.no_equilibrium(trouble.failed))
        return Went.NOT if walk.is_small or walk.stuck() else Went.ON

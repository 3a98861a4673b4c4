"""The second rung: the next increment once more, with a line search."""

from __future__ import annotations

from softact.solve.rungs.base import Stopped, Trouble, Went
from softact.solve.walk import Walk


class LineSearch:
    """Tries a small increment with a line search, once at each place."""

    name = "search"

    def may(self, walk: Walk, trouble: Trouble) -> bool:
        """See ``Rung``."""
        if not trouble.failed:
            return False
        return walk.is_small and not walk.stuck() and walk.searched_at != walk.done

    def climb(self, walk: Walk, trouble: Trouble) -> Went | Stopped:
        """See ``Rung``."""
        walk.searched_at = walk.done
        s = walk.done + walk.size
        walk.control = self.name
        outcome = walk.attempt(walk.drive, walk.path, s, line_search=True)
        outcome = walk.onward(outcome, s)
        if not outcome.converged:
            walk.reject(walk.drive, walk.path, s, outcome)
            return Went.NOT
        walk.path = walk.accept(walk.drive, walk.path, s, outcome, control=self.name)
        walk.passed.add(s, walk.state.x)
        return Went.ON

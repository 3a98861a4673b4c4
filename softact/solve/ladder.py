"""One load step: adaptive increments under load control, and the ladder where they fail.

The rungs stand in ``softact.solve.rungs``, in their order: a smaller increment; a line search;
volume instead of pressure; quasi-static dynamics. Newton's step is always shortened before it turns
an element inside out. Each rung hands back to load control as soon as it has passed the trouble.
"""

from __future__ import annotations

from softact.solve.rungs import IN_TIME, RUNGS
from softact.solve.rungs.base import Stopped, Trouble, Went
from softact.solve.walk import Walk


def climb(walk: Walk) -> str | None:
    """Solve the step that the walk has begun; returns why it ends early, None where it does not."""
    if walk.done == 0.0 and walk.alpha is None:
        stopped = _help(walk, Trouble(begins=True))
        if stopped:
            return stopped.why
    while walk.done < 1.0:
        done = walk.done
        trouble = Trouble(ahead=True) if walk.at_limit() else _advance(walk)
        stopped = _help(walk, trouble) if trouble else None
        if stopped:
            return stopped.why
        if walk.done > done:
            walk.checkpoint()
    return None


def _advance(walk: Walk) -> Trouble | None:
    """Try the next increment under load control."""
    outcome = walk.advance()
    return None if outcome.converged else Trouble(failed=outcome.reason, apart=outcome.apart)


def _help(walk: Walk, trouble: Trouble) -> Stopped | None:
    """Go on after a trouble; where no rung has anything to try, the increment is tried again."""
    for rung in RUNGS if walk.alpha is None else IN_TIME:
        if not rung.may(walk, trouble):
            continue
        went = rung.climb(walk, trouble)
        if isinstance(went, Stopped):
            return went
        if went is Went.ON:
            return None
    if walk.alpha is not None and walk.size < walk.settings.min_increment * walk.largest:
        return Stopped(walk.no_equilibrium(trouble.failed))
    return None

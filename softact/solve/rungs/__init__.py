"""The ladder: what is done where the next equilibrium is not found, in this order."""

from softact.solve.rungs.base import Rung
from softact.solve.rungs.dropped import Dropped
from softact.solve.rungs.inflation import Inflation
from softact.solve.rungs.line_search import LineSearch
from softact.solve.rungs.motion import Motion
from softact.solve.rungs.smaller import SmallerIncrement
from softact.solve.rungs.volume import Volume

RUNGS: tuple[Rung, ...] = (
    Inflation(),
    SmallerIncrement(),
    Dropped(),
    LineSearch(),
    Volume(),
    Motion(),
)
#: Of a step with inertia: all others seek an equilibrium, or a motion that is damped.
IN_TIME: tuple[Rung, ...] = (SmallerIncrement(),)

"""What a reader is told of unstable equilibria on the way of a run."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from softact.solve.progress import Attempt

_SHOWN = 4  # changes between stable and unstable that are told one by one


def unstable_text(found: Sequence[Attempt], again: bool) -> str | None:
    """From where on a run is unstable, and where it is stable again; None where it never is.

    found: its accepted states. again: whether a state that is not known to be unstable is known to
    be stable, as its tangent's factors tell without friction.
    """
    equilibria = [state for state in found if state.control != "motion"]
    alike = groupby(equilibria, key=lambda state: state.unstable_modes > 0)
    runs = [next(states) for _, states in alike]
    first = next((i for i, state in enumerate(runs) if state.unstable_modes > 0), None)
    if first is None:
        return None
    changes = runs[first:] if again else runs[first : first + 1]
    said = [
        f"{'unstable' if state.unstable_modes > 0 else 'stable again'} from "
        f"{state.fraction:.2%} of step '{state.step}' on"
        for state in changes
    ]
    why = "the potential energy falls in some direction, so the actuator would snap or buckle"
    more = f", and {len(said) - _SHOWN} changes more" if len(said) > _SHOWN else ""
    return "; ".join([f"{said[0]}: {why}", *said[1:_SHOWN]]) + more

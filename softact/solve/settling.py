"""An equilibrium with contact, made one that is in balance whatever was known on the way there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from softact.solve.border import Control
from softact.solve.newton import Loaded, Newton, NewtonOutcome, SolveOptions
from softact.system.term import State

# Solves more at most for what points face when looked for afresh, which they were once already.
AFRESH = 1


def settled(
    newton: Newton,
    state: State,
    outcome: NewtonOutcome,
    held: np.ndarray,
    control: Control | None,
    options: SolveOptions | None = None,
) -> NewtonOutcome:
    """The outcome, with as many solves more as it takes until bodies do not overlap too far, and
    its state is in balance also where nothing is known of the way there; after ``AFRESH`` of these
    the state remembers what its points faced.

    held: prescribed displacements, see ``Newton.solve``, as control and options.
    """
    contacts, afresh = newton.model.contacts, 0
    while outcome.converged:
        if not contacts.stiffen(state):
            # Where surfaces have sharp folds there may be no end to it.
            if not contacts.look_afresh(state, keep=afresh == AFRESH):
                break
            if newton.imbalance(Loaded(state, held)) <= newton.tolerance:
                break
            afresh += 1
        more = newton.solve(state, held, control, options=options)
        outcome = replace(more, iterations=outcome.iterations + more.iterations)
    return outcome

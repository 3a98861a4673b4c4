"""The last state of all steps at once, from a guess of it: a solution of an actuator like this one.

Only where the last state does not depend on the way to it: nothing that touches, creeps, softens or
is filled with air, no supports that change or move, no time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from softact.loads.load_step import LoadStep
from softact.loads.support import Support
from softact.solve.newton import NewtonOutcome
from softact.solve.path import Point
from softact.solve.progress import Attempt
from softact.solve.walk import Walk
from softact.system.term import State

TOUCHES = "the actuator touches itself, so that its way counts"


def found_at_once(
    walk: Walk,
    steps: Sequence[LoadStep],
    supports: Sequence[Support],
    guesses: Sequence[np.ndarray],
    arrived: Callable[[int], None],
) -> bool:
    """Whether Newton's method finds the state after the last step from one of these unknowns
    (local,). Then it is accepted, after the one at rest; else the walk is as new. arrived: is
    called with the last step's number between the two. Collective.
    """
    for step in steps:
        walk.model.make_room(step.loads)
    walk.set_supports(supports)
    at_rest = replace(walk.state, x=walk.state.x.copy())
    _go_to_last(walk, steps)
    for guess in guesses:
        outcome = _tried(walk, guess)
        if outcome.converged:
            _accept(walk, steps, at_rest, outcome, arrived)
            return True
    walk.state = walk.model.initial_state()
    walk.rest = replace(walk.state, x=walk.state.x.copy())
    walk.path = [Point(0.0, walk.state.x.copy(), walk.drive.loads(walk.state))]
    walk.model.contacts.resume(walk.state)
    return False


def _go_to_last(walk: Walk, steps: Sequence[LoadStep]) -> None:
    """Begin the last step, with the loads that the others leave."""
    for number, step in enumerate(steps):
        walk.begin(number, step)
        if step is not steps[-1]:
            walk.ramp.apply(walk.state, step.at_end)
            walk.newton.arrive(walk.state, step.at_end)


def _tried(walk: Walk, guess: np.ndarray) -> NewtonOutcome:
    walk.path = [Point(0.0, guess.copy(), walk.drive.loads(walk.state))]
    walk.rest = replace(walk.state, x=guess.copy())
    contacts = walk.model.contacts
    contacts.resume(walk.rest)
    outcome = walk.attempt(walk.drive, walk.path, 1.0)
    if outcome.converged and contacts.touch(walk.state):
        return replace(outcome, converged=False, reason=TOUCHES)
    return outcome


def _accept(
    walk: Walk,
    steps: Sequence[LoadStep],
    at_rest: State,
    outcome: NewtonOutcome,
    arrived: Callable[[int], None],
) -> None:
    """Take the two states, the one at rest first."""
    there, walk.state = walk.state, at_rest
    walk.model.remember(walk.state)
    walk.record(Attempt(steps[0].name, 0.0, 0, True, [], "", 0))
    arrived(len(steps) - 1)
    walk.state = there
    walk.path = walk.accept(walk.drive, walk.path, 1.0, outcome)
    walk.newton.arrive(walk.state, steps[-1].at_end)
    walk.checkpoint()

"""Load steps one after the other."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from softact.loads.load_step import LoadStep
from softact.loads.support import Support
from softact.model import Model
from softact.solve import ladder
from softact.solve.checkpoint import Checkpoint
from softact.solve.progress import Attempt, Listeners, Progress, Trying
from softact.solve.settings import Settings
from softact.solve.walk import Walk
from softact.system.term import State


class Stepper:
    """Carries a model through its steps; see ``Listeners`` for who hears of it."""

    def __init__(
        self,
        model: Model,
        settings: Settings,
        on_accept: Callable[[State, Attempt, int], None],
        on_reject: Callable[[Attempt], None] = lambda attempt: None,
        on_checkpoint: Callable[[Checkpoint], None] = lambda checkpoint: None,
        on_iteration: Callable[[Trying], None] = lambda trying: None,
        on_remark: Callable[[str], None] = lambda text: None,
    ):
        listeners = Listeners(on_accept, on_reject, on_checkpoint, on_iteration, on_remark)
        self.walk = Walk(model, settings, listeners)

    @property
    def model(self) -> Model:
        """What is solved."""
        return self.walk.model

    @property
    def state(self) -> State:
        """Where the run stands."""
        return self.walk.state

    @property
    def progress(self) -> Progress:
        """What the run has done."""
        return self.walk.progress

    def run(
        self,
        steps: Sequence[LoadStep],
        supports: Sequence[Support],
        start: Checkpoint | None = None,
        begin: int | None = 0,
    ) -> Progress:
        """Solve the steps in order; stops where no further equilibrium is found.

        start: where an earlier run stood. begin: number of the step to begin with; None: go on
        inside the step of ``start``.
        """
        walk = self.walk
        for step in steps:
            walk.model.make_room(step.loads)
        inside = start if begin is None else None
        first = inside.step if inside else begin or 0
        if start:
            walk.restore(start, start.begun if inside else start.state)
        sets = [(0, supports)]
        sets += [
            (n, s.supports) for n, s in enumerate(steps[: first + 1]) if s.supports is not None
        ]
        for _, earlier in sets:  # angles are counted on from one to the next
            walk.set_supports(earlier)
        if first > sets[-1][0]:
            walk.newton.arrive(walk.state, steps[sets[-1][0]].at_end)
        if not start:
            walk.model.contacts.check_clear(walk.state)
            walk.model.remember(walk.state)
            walk.record(Attempt(steps[0].name, 0.0, 0, True, [], "", 0))
        for number, step in enumerate(steps[first:], first):
            if number > first and step.supports is not None:
                walk.set_supports(step.supports)
            walk.begin(number, step)
            if inside:
                walk.resume(inside)
            walk.progress.stopped = ladder.climb(walk)
            if walk.progress.stopped:
                break
            walk.newton.arrive(walk.state, step.at_end)
            inside = None
        return walk.progress

"""What a run has tried and reached, and who hears of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from softact.solve.checkpoint import Checkpoint
from softact.system.term import State


@dataclass(frozen=True)
class Attempt:
    """One try at an increment, for the convergence history; see ``NewtonOutcome``.

    control: "load", "search" (load, with a line search), "volume", "arc" (the way through the
    displacements), "inertia" (a state of a step in real time), "dynamics" (an equilibrium that a
    damped motion has led to) or "motion" (a state of the first inflation, no equilibrium).
    kinetic_ratio: largest ratio of kinetic to internal
    energy on the way, where there was a motion. speed: norm of the displacements' change (mm) per
    change of the fraction at the equilibrium; 0 where not known.
    """

    step: str
    fraction: float
    iterations: int
    converged: bool
    residuals: list[float]
    reason: str
    unstable_modes: int
    control: str = "load"
    kinetic_ratio: float = 0.0
    speed: float = 0.0


@dataclass(frozen=True)
class Trying:
    """What is being tried: an iteration of Newton's method on the way from an accepted state.

    fraction: of the step, of that state. control: see ``Attempt``. iteration: in this solve;
    residual: relative. iterations: of the run so far.
    """

    step: str
    fraction: float
    control: str
    iteration: int
    residual: float
    iterations: int


@dataclass
class Progress:
    """What the run has done: attempts so far, remarks that a reader has to know before he trusts
    it, notes that he may read and, where it stopped early, why."""

    attempts: list[Attempt] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    stopped: str | None = None

    @property
    def cutbacks(self) -> int:
        """Number of attempts that failed."""
        return sum(not a.converged for a in self.attempts)


@dataclass(frozen=True)
class Listeners:
    """Who hears of a run.

    accept: (state, attempt, increment number) at each new equilibrium, and once with the unloaded
    state before the first; reject: each attempt that failed; checkpoint: after each increment from
    which the run could go on; iteration: at each iteration, so that it has to be quick; remark:
    each one, at once.
    """

    accept: Callable[[State, Attempt, int], None]
    reject: Callable[[Attempt], None] = lambda attempt: None
    checkpoint: Callable[[Checkpoint], None] = lambda checkpoint: None
    iteration: Callable[[Trying], None] = lambda trying: None
    remark: Callable[[str], None] = lambda text: None

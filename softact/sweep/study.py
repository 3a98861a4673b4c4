"""A sweep from its file to its rows: what is kept already is read, the rest is computed."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path

from softact.errors import SpecError
from softact.files import document
from softact.results.folder import COMPLETE
from softact.sweep.cache import Cache
from softact.sweep.compute import INVALID, Answer, of_record
from softact.sweep.confirm import Candidate, Confirmed, choose, compared, confirm, front
from softact.sweep.local import Jobs, run_all
from softact.sweep.parts import Part
from softact.sweep.points import DesignPoint, Plan
from softact.sweep.spec import Sweep
from softact.tolerances.causes import Cause

#: Computes jobs and yields their answers: ``local.run_all`` with its count, or a cluster; the last
#: argument is ``StudyFile.kinds``.
Runner = Callable[[Jobs, Cache, Sequence[str] | None], Iterator[Answer]]


@dataclass
class Study:
    """A sweep and what became of its points.

    points: of the design; two may have one key. plan: what made their keys. answers: key -> how
    its run ended. computed, waited: number of runs computed here, and seconds of wall time spent
    on that. nominal: of a design of tolerances, see ``softact.sweep.tolerance_check``. confirmed:
    the best points of a study on modules as whole actuators.
    """

    sweep: Sweep
    base: document.Document
    points: list[DesignPoint]
    cache: Cache
    plan: Plan
    answers: dict[str, Answer] = field(default_factory=dict)
    computed: int = 0
    waited: float = 0.0
    nominal: tuple[Answer, list[Cause]] | None = None
    confirmed: list[Confirmed] = field(default_factory=list)

    @cached_property
    def resolved(self) -> dict:
        """The base with its defaults, as plain data; empty where the base alone is no spec."""
        try:
            return self.sweep.spec_at(self.base).model_dump(mode="json", exclude_none=True)
        except SpecError:
            return {}

    def answer(self, point: DesignPoint) -> Answer | None:
        """How a point ended, None where it has not been computed yet."""
        if point.key is None:
            return Answer("", None, INVALID, "; ".join(point.faults))
        return self.answers.get(point.key)

    def read_kept(self) -> None:
        """Take over what the cache holds."""
        for key in self.missing():
            found = self.cache.find(key)
            if found is not None:
                self.answers[key] = of_record(found, cached=True)

    def missing(self) -> list[str]:
        """Keys that have no answer yet, in the order of the points."""
        keys = dict.fromkeys(point.key for point in self.points if point.key)
        return [key for key in keys if key not in self.answers]

    def compute(self, runner: Runner, tell: Callable[[DesignPoint, Answer], None]) -> None:
        """Compute what is missing; ``tell`` is called for each point as its run ends."""
        places: dict[str, list[DesignPoint]] = {}
        for point in self.points:
            if point.key is not None:
                places.setdefault(point.key, []).append(point)
        make = partial(self.sweep.spec_at, self.base)
        jobs = {k: partial(make, places[k][0].changes) for k in self.missing()}
        started = time.perf_counter()
        try:
            for answer in runner(jobs, self.cache, self.sweep.kinds):
                self.answers[answer.key] = answer
                self.computed += answer.record is not None and not answer.cached
                for point in places[answer.key]:
                    tell(point, answer)
        finally:
            self.waited += time.perf_counter() - started

    def confirm(self, runner: Runner, tell: Callable[[DesignPoint, Answer], None]) -> None:
        """Compute the best points as whole actuators, as many as the sweep says."""
        chosen = choose(self._complete, self.sweep.objectives, self.sweep.confirm)
        self.confirmed = confirm(chosen, self.base, self.cache, runner, tell)

    def front(self) -> set[int]:
        """Numbers of the points that none beats in the sweep's objectives."""
        return {each.number for each in front(self._complete, self.sweep.objectives)}

    @property
    def _complete(self) -> list[Candidate]:
        there = []
        for number, point in enumerate(self.points):
            answer = self.answer(point)
            if answer is not None and answer.record is not None and answer.status == COMPLETE:
                there.append(Candidate(number, point, answer.record))
        return there

    @property
    def compared(self) -> list[Part]:
        """The measures of modules and whole actuators that are set beside each other."""
        return compared(self.confirmed, self.sweep.objectives)


def locally(count: int) -> Runner:
    """A runner on this machine, ``count`` runs at a time."""
    return lambda jobs, cache, blocked: run_all(jobs, cache, count, blocked=blocked)


def open_study(
    sweep: Sweep,
    base: document.Document,
    cache: Cache,
    plan_file: Path | None = None,
    design: Sequence[dict] | None = None,
) -> Study:
    """A study of a sweep, with what is kept of it already; ``design`` replaces the sweep's."""
    plan = Plan(base, plan_file, sweep.spec_at, sweep.kinds)
    points = plan.points(sweep.axes, design or sweep.design.points(sweep.axes))
    study = Study(sweep, base, points, cache, plan)
    study.read_kept()
    return study

"""Trials of an optimisation: Optuna asks, runs answer, all of it is kept in a file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from softact.errors import SpecError
from softact.optimise.spec import Optimisation
from softact.results import COMPLETE
from softact.spec import document
from softact.sweep.axes import Axis, quantity, written
from softact.sweep.cache import Cache
from softact.sweep.compute import FAILED, INVALID, Answer, of_record
from softact.sweep.local import run_all
from softact.sweep.points import changes_of, spec_at
from softact.sweep.record import Record
from softact.sweep.version import run_key

_DIGITS = 4  # of a suggested number: no workshop makes more, and runs are met again in the cache


class Trials:
    """An optimisation in a folder.

    directory: where trials.db is, which a second call goes on with. Raises SpecError where it is
    of other parameters or objectives.
    """

    def __init__(
        self, wanted: Optimisation, base: document.Document, cache: Cache, directory: Path
    ):
        import optuna

        optuna.logging.set_verbosity(optuna.logging.ERROR)
        self.wanted, self.base, self.cache = wanted, base, cache
        self.axes = {axis.title: axis for axis in wanted.parameters}
        several = len(wanted.objectives) > 1
        samplers = optuna.samplers
        kind = samplers.NSGAIISampler if several else samplers.TPESampler
        storage = f"sqlite:///{directory.absolute() / 'trials.db'}"
        self.study = optuna.create_study(
            study_name="softact",
            storage=storage,
            sampler=kind(seed=wanted.seed),
            load_if_exists=True,
            directions=[o.direction for o in wanted.objectives],
        )
        self._same(directory)
        self._take_up()

    def _same(self, directory: Path) -> None:
        """Refuse to mix the trials of two optimisations."""
        print_ = self.wanted.model_dump_json(exclude={"trials", "description", "source", "name"})
        known = self.study.user_attrs.get("file")
        if known is None:
            self.study.set_user_attr("file", print_)
            if self.wanted.reference:
                self.study.enqueue_trial(
                    {t: _plain(self.axes[t], v) for t, v in self.wanted.reference.items()}
                )
        elif known != print_:
            raise SpecError(
                f"{directory}: holds the trials of another optimisation; name another folder with "
                "-o DIR, or remove trials.db there"
            )

    def _take_up(self) -> None:
        """Trials that were under way when the last call was killed are asked for once more."""
        from optuna.trial import TrialState

        for trial in self.study.get_trials(deepcopy=False, states=(TrialState.RUNNING,)):
            self.study.tell(trial.number, state=TrialState.FAIL)
            self.study.enqueue_trial(trial.params)

    @property
    def done(self) -> list[Any]:
        """Optuna's trials that have ended, those cut off by a kill left out."""
        trials = self.study.get_trials(deepcopy=False)
        return [t for t in trials if t.state.is_finished() and "status" in t.user_attrs]

    def run(self, jobs: int, told: Callable[[Any, Answer], None]) -> None:
        """Run trials, ``jobs`` at a time, until there are as many as wanted."""
        while (left := self.wanted.trials - len(self.done)) > 0:
            asked = [self.study.ask() for _ in range(min(jobs, left))]
            points = {trial.number: (trial, self._suggest(trial)) for trial in asked}
            for number, answer in self._answers(points, jobs):
                self._tell(points[number][0], answer)
                told(self.study.trials[number], answer)

    def _suggest(self, trial: Any) -> dict[str, Any]:
        """A value of the spec for each parameter, as Optuna suggests it."""
        return {title: _suggested(trial, axis) for title, axis in self.axes.items()}

    def _answers(self, points: dict, jobs: int):
        """(trial's number, answer) of each; trials of one and the same point share a run."""
        keys: dict[str, list[int]] = {}
        specs: dict[str, Callable] = {}
        for number, (_, coordinates) in points.items():
            changes = changes_of(self.wanted.parameters, coordinates)
            try:
                spec = spec_at(self.base, changes)
            except SpecError as error:
                yield number, Answer(None, None, INVALID, "; ".join(error.lines))
                continue
            key = run_key(spec)
            keys.setdefault(key, []).append(number)
            if (found := self.cache.find(key)) is None:
                specs[key] = partial(_same_object, spec)
            else:
                yield from ((n, of_record(found, cached=True)) for n in keys.pop(key))
        for answer in run_all(specs, self.cache, jobs):
            yield from ((number, answer) for number in keys[answer.key])

    def _tell(self, trial: Any, answer: Answer) -> None:
        """A run that is not complete is a failed trial with its cause, not a large number."""
        from optuna.trial import TrialState

        values = None
        status, cause = answer.status, answer.cause
        parts = (*self.wanted.objectives, *self.wanted.constraints)
        if answer.record is not None and answer.status == COMPLETE:
            missing = [part.measure for part in parts if part.value(answer.record) is None]
            if missing:
                status, cause = FAILED, f"the run has no column {missing[0]}"
            else:
                values = [objective.value(answer.record) for objective in self.wanted.objectives]
                self._note(trial, answer.record)
        for name, value in (("status", status), ("cause", cause), ("run", answer.key or "")):
            trial.set_user_attr(name, value)
        self.study.tell(trial, values, state=None if values else TrialState.FAIL)

    def _note(self, trial: Any, record: Record) -> None:
        broken = [c.violation(record) for c in self.wanted.constraints]
        for number, violation in enumerate(broken):
            trial.set_constraint(str(number), violation)
        trial.set_user_attr("violations", broken)
        for part in (*self.wanted.objectives, *self.wanted.constraints):
            trial.set_user_attr(part.title, part.value(record))

    def best(self) -> list[Any]:
        """The trials that none beats and that break no constraint; of one objective the best."""
        return _unbeaten([t for t in self.done if feasible(t)], self.wanted.objectives)

    def coordinates(self, trial: Any) -> dict[str, Any]:
        """Values of the spec of a trial."""
        return {t: _value(axis, trial.params[t]) for t, axis in self.axes.items()}


def feasible(trial: Any) -> bool:
    """Whether a trial has values and breaks no constraint."""
    return trial.values is not None and all(v <= 0 for v in trial.user_attrs.get("violations", []))


def _unbeaten(trials: Sequence[Any], objectives) -> list[Any]:
    signs = [1 if objective.goal == "maximise" else -1 for objective in objectives]

    def beats(a, b) -> bool:
        pairs = [(s * x, s * y) for s, x, y in zip(signs, a.values, b.values, strict=True)]
        return all(x >= y for x, y in pairs) and any(x > y for x, y in pairs)

    front = [t for t in trials if not any(beats(other, t) for other in trials)]
    unique = {tuple(t.values): t for t in reversed(front)}
    return sorted(unique.values(), key=lambda t: t.values)


def _same_object(spec):
    return spec


def _suggested(trial: Any, axis: Axis) -> Any:
    if axis.values is not None:
        return trial.suggest_categorical(axis.title, list(axis.values))
    low, high = sorted((quantity(axis.from_)[0], quantity(axis.to)[0]))
    if not axis.continuous:
        return trial.suggest_int(axis.title, int(low), int(high))
    number = trial.suggest_float(axis.title, low, high, log=axis.scale == "log")
    return _value(axis, number)


def _value(axis: Axis, parameter: Any) -> Any:
    """The spec's value of Optuna's parameter."""
    if axis.values is not None or not axis.continuous:
        return parameter
    return written(float(f"{parameter:.{_DIGITS}g}"), axis.unit, False)


def _plain(axis: Axis, value: Any) -> Any:
    """Optuna's parameter of a spec's value."""
    return value if axis.values is not None else axis.number(value)

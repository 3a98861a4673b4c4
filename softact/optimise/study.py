"""Trials of an optimisation: Optuna asks, runs answer, all of it is kept in a file."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from softact.errors import SpecError
from softact.files import document
from softact.optimise import store
from softact.optimise.spec import GRADIENT, Optimisation, place_of
from softact.results.folder import COMPLETE
from softact.run.last_state import why_not
from softact.sensitivities.parameters import chosen
from softact.sweep.axes import Axis, written
from softact.sweep.cache import Cache
from softact.sweep.compute import FAILED, INVALID, Answer, of_record
from softact.sweep.confirm import Candidate, Confirmed, choose, compared, confirm
from softact.sweep.crew import Crew
from softact.sweep.front import unbeaten
from softact.sweep.local import run_all
from softact.sweep.parts import Objective, Part
from softact.sweep.points import DesignPoint, changes_of, first_right
from softact.sweep.record import Record
from softact.sweep.study import locally
from softact.sweep.version import run_key

if TYPE_CHECKING:
    from optuna.trial import FrozenTrial, Trial

    from softact.spec import Spec
    from softact.sweep.design import Coordinates

#: What of a measure the run from the beginning may differ from that of the last state alone.
SAME = 1e-4
#: Words in the columns of measures that count what happened on the way.
ON_THE_WAY = ("pressure_work", "failure", "safe_", "loss")
_DIGITS = 4  # of a suggested number: no workshop makes more, and runs are met again in the cache


class Trials:
    """An optimisation in a folder.

    directory: where trials.db is, which a second call goes on with. Raises SpecError where it is
    damaged, of other parameters or objectives, or of a base that gives other runs.
    """

    def __init__(
        self, wanted: Optimisation, base: document.Document, cache: Cache, directory: Path
    ) -> None:
        import optuna

        optuna.logging.set_verbosity(optuna.logging.ERROR)
        self.wanted, self.base, self.cache = wanted, base, cache
        self.axes = {axis.title: axis for axis in wanted.parameters}
        self.file = directory / store.DATABASE
        #: Of each parameter the paths of a run's derivatives; none without the method gradient.
        self.paths = _differentiated(wanted, base) if wanted.method == GRADIENT else []
        self.slopes = [path for some in self.paths for path in some]
        #: Whether runs may start from those of designs like theirs, and have their last state only.
        self.end_only = bool(self.slopes) and _end_only(wanted, base)
        self._call = uuid.uuid4().hex
        #: The best designs of a study on modules as whole actuators.
        self.confirmed: list[Confirmed] = []
        self._first = {t: _parameter(self.axes[t], v) for t, v in wanted.reference.items()}
        self.study = store.opened(wanted, directory, self._first)
        with store.reading(self.file):
            self._check_runs()
        with store.writing(self.file):
            self._take_up()

    @property
    def parts(self) -> tuple[Part, ...]:
        """Objectives and constraints."""
        return (*self.wanted.objectives, *self.wanted.constraints)

    def _check_runs(self) -> None:
        """Refuse trials whose run is another one now: the base has changed, a file that it names,
        or what its script reads. Values are compared with the cache's, where the run is there."""
        for trial in self.done:
            key = self._key(self.coordinates(trial))
            if trial.user_attrs["run"] != (key or ""):
                why = f"holds trials of another base spec (trial {trial.number} is another run now)"
                raise store.other(self.file, why)
            found = self.cache.find(key) if key and trial.values is not None else None
            if found and not self._says(trial, found):
                why = f"the values of trial {trial.number} are not those of its run"
                raise store.damaged(self.file, why)

    def _says(self, trial: FrozenTrial, found: Record) -> bool:
        """Whether a trial has the values of its run."""
        values = [objective.value(found) for objective in self.wanted.objectives]
        noted = self._noted(found).items()
        return trial.values == values and all(trial.user_attrs.get(k) == v for k, v in noted)

    def _key(self, coordinates: Mapping[str, Any]) -> str | None:
        try:
            return self._run_key(self._spec(coordinates))
        except SpecError:
            return None

    def _spec(self, coordinates: Mapping[str, Any]) -> Spec:
        """The spec of a design's run. Raises SpecError."""
        return self.wanted.spec_at(self.base, changes_of(self.wanted.parameters, coordinates))

    def _run_key(self, spec: Spec) -> str:
        how: dict[str, Any] = {"slopes": self.slopes, "end_only": self.end_only}
        return run_key(spec, **how, blocked=self.wanted.kinds)

    def _take_up(self) -> None:
        """Trials that were under way when the last call was killed are asked for once more, and
        those whose solver was killed."""
        from optuna.trial import TrialState

        for trial in self.study.get_trials(deepcopy=False, states=(TrialState.RUNNING,)):
            self.study.tell(trial.number, state=TrialState.FAIL)
        known = self.study.get_trials(deepcopy=False)
        settled = [_fixed(t) for t in known if self._settled(t)]
        for trial in known:
            again = self.wanted.method != GRADIENT and not self._settled(trial)
            if again and _fixed(trial) and _fixed(trial) not in settled:
                self.study.enqueue_trial(_fixed(trial))
                settled.append(_fixed(trial))

    def _settled(self, trial: FrozenTrial) -> bool:
        """Whether a trial waits for its turn, or has ended in a way that would come again."""
        if not trial.state.is_finished():
            return trial.state.name == "WAITING"
        return _ended(trial) and trial.user_attrs.get("again_after") in (None, self._call)

    @property
    def done(self) -> list[FrozenTrial]:
        """Optuna's trials that have ended, those cut off by a kill left out."""
        trials = self.study.get_trials(deepcopy=False)
        return [t for t in trials if t.state.is_finished() and self._settled(t)]

    @property
    def reference(self) -> FrozenTrial | None:
        """The trial of the design to be beaten, None where there is none or it is not done."""
        found = (t for t in self.done if self._first and t.params == self._first)
        return next(found, None)

    def run(self, jobs: int, tell: Callable[[FrozenTrial, Answer], None]) -> None:
        """Run trials, ``jobs`` at a time, until there are as many as wanted.

        tell: is called with each trial and the answer of its run.

        Raises CannotWriteError where the disk is full.
        """
        with store.writing(self.file), Crew(jobs, self.wanted.kinds is not None) as crew:
            while (left := self.wanted.trials - len(self.done)) > 0:
                asked = self._ask(min(jobs, left))
                points = {trial.number: (trial, self._suggest(trial)) for trial in asked}
                for number, answer in self._answers(points, jobs, crew):
                    self._tell(points[number][0], answer)
                    tell(self.study.trials[number], answer)

    def at(self, numbers: Mapping[str, float]) -> FrozenTrial | None:
        """The trial of a design that is done, None where there is none. numbers: parameter -> value
        in the unit of its axis, rounded as it is for a run."""
        wanted = {title: _value(axis, numbers[title]) for title, axis in self.axes.items()}
        return next((t for t in self.done if self.coordinates(t) == wanted), None)

    def tried(
        self, numbers: Mapping[str, float], tell: Callable[[FrozenTrial, Answer], None]
    ) -> FrozenTrial:
        """A new trial of a design, once it is done. See ``at`` and ``run``."""
        wanted = {title: _value(axis, numbers[title]) for title, axis in self.axes.items()}
        with store.writing(self.file):
            self.study.enqueue_trial(dict(numbers))
            asked = self._asked(wanted)
            ((number, answer),) = self._answers({asked.number: (asked, wanted)}, 1)
            self._tell(asked, answer)
            trial = self.study.trials[number]
            tell(trial, answer)
        return trial

    def _asked(self, wanted: Coordinates) -> Trial:
        """The trial of a design that stands in the queue; those before it are given up: a killed
        call, or the reference, has left them there."""
        from optuna.trial import TrialState

        while True:
            (asked,) = self._ask(1)
            if self._suggest(asked) == wanted:
                return asked
            self.study.tell(asked, state=TrialState.FAIL)

    def record(self, trial: FrozenTrial) -> Record:
        """The run of a trial that has values. Raises SoftactError where it cannot be had."""
        self.folder(trial)
        found = self.cache.find(trial.user_attrs["run"])
        assert found is not None  # it has just been computed
        return found

    def _ask(self, count: int) -> list[Trial]:
        """New trials. Each draws from a stream of its own, so that a call that goes on proposes
        what one that was never stopped would have, and nothing twice."""
        import optuna

        several = len(self.wanted.objectives) > 1
        kind = optuna.samplers.NSGAIISampler if several else optuna.samplers.TPESampler
        first, asked = len(self.done), []
        for number in range(first, first + count):
            seed = np.random.SeedSequence([self.wanted.seed, number]).generate_state(1)[0]
            self.study.sampler = kind(seed=int(seed))
            asked.append(self.study.ask())
        return asked

    def _suggest(self, trial: Trial) -> Coordinates:
        """A value of the spec for each parameter, as Optuna suggests it."""
        return {title: _suggested(trial, axis) for title, axis in self.axes.items()}

    def _answers(
        self,
        points: Mapping[int, tuple[Trial, Coordinates]],
        jobs: int,
        crew: Crew | None = None,
    ) -> Iterator[tuple[int, Answer]]:
        """(trial's number, answer) of each; trials of one and the same point share a run."""
        keys: dict[str, list[int]] = {}
        specs: dict[str, Callable[[], Spec]] = {}
        for number, (_, coordinates) in points.items():
            try:
                spec = self._spec(coordinates)
            except SpecError as error:
                yield number, Answer("", None, INVALID, "; ".join(error.lines))
                continue
            key = self._run_key(spec)
            keys.setdefault(key, []).append(number)
            if (found := self.cache.find(key)) is None:
                specs[key] = partial(_same_object, spec)
            else:
                yield from ((n, of_record(found, cached=True)) for n in keys.pop(key))
        near = self._near(points) if specs else None
        how = self.slopes, self.end_only, near, self.wanted.kinds, crew
        for answer in run_all(specs, self.cache, jobs, *how):
            yield from ((number, answer) for number in keys[answer.key])

    def _near(self, points: Mapping[int, tuple[Trial, Coordinates]]) -> Path | None:
        """Folder of the run of the design nearest to that of a trial, from which it may start."""
        known = [t for t in self.done if t.values is not None] if self.end_only else []
        known = [t for t in known if self.cache.find(t.user_attrs["run"])]
        if not known:
            return None
        ((_, wanted), *_) = points.values()
        here = self._position(wanted)

        def distance(trial: FrozenTrial) -> float:
            return float(np.linalg.norm(self._position(self.coordinates(trial)) - here))

        return self.cache.folder(min(known, key=distance).user_attrs["run"])

    def _position(self, coordinates: Mapping[str, Any]) -> np.ndarray:
        """A design (parameters,), by the widths of the ranges."""
        parts = []
        for title, axis in self.axes.items():
            low, high = axis.ends
            parts.append(float(axis.number(coordinates[title])) / (high - low))
        return np.array(parts)

    def _tell(self, trial: Trial, answer: Answer) -> None:
        """A run that is not complete is a failed trial with its cause, not a large number."""
        from optuna.trial import TrialState

        values = None
        status, cause = answer.status, answer.cause
        if answer.record is not None and answer.status == COMPLETE:
            missing = [part.title for part in self.parts if part.value(answer.record) is None]
            if missing:
                status, cause = FAILED, f"the run has no value of {missing[0]}"
            else:
                found = (part.value(answer.record) for part in self.wanted.objectives)
                values = [value for value in found if value is not None]  # none is missing
                self._note(trial, answer.record)
        if answer.transient:
            trial.set_user_attr("again_after", self._call)
        # The status last: it says that the rest is there.
        for name, value in (("cause", cause), ("run", answer.key), ("status", status)):
            trial.set_user_attr(name, value)
        self.study.tell(trial, values, state=None if values else TrialState.FAIL)

    def _note(self, trial: Trial, record: Record) -> None:
        noted = self._noted(record)
        for number, violation in enumerate(noted["violations"]):
            trial.set_constraint(str(number), violation)
        for name, value in noted.items():
            trial.set_user_attr(name, value)

    def _noted(self, record: Record) -> dict[str, Any]:
        """What is kept of a run beside the objectives' values."""
        broken = [constraint.violation(record) for constraint in self.wanted.constraints]
        return {"violations": broken} | {part.title: part.value(record) for part in self.parts}

    def best(self) -> list[FrozenTrial]:
        """The trials that none beats and that break no constraint; of one objective the best."""
        return _unbeaten([t for t in self.done if feasible(t)], self.wanted.objectives)

    def confirm(self, jobs: int, tell: Callable[[DesignPoint, Answer], None]) -> None:
        """Compute the best designs as whole actuators, ``jobs`` at a time, as many as the file
        says. tell: see ``softact.sweep.confirm.confirm``."""
        there = []
        for trial in (t for t in self.done if feasible(t)):
            coordinates, key = self.coordinates(trial), trial.user_attrs["run"]
            if (found := self.cache.find(key)) is not None:
                changes = changes_of(self.wanted.parameters, coordinates)
                there.append(Candidate(trial.number, DesignPoint(coordinates, changes, key), found))
        chosen = choose(there, self.wanted.objectives, self.wanted.confirm)
        self.confirmed = confirm(chosen, self.base, self.cache, locally(jobs), tell)

    @property
    def compared(self) -> list[Part]:
        """The measures of modules and whole actuators that are set beside each other."""
        return compared(self.confirmed, self.parts)

    def coordinates(self, trial: FrozenTrial) -> Coordinates:
        """Values of the spec of a trial."""
        return {t: _value(axis, trial.params[t]) for t, axis in self.axes.items()}

    def folder(self, trial: FrozenTrial) -> Path:
        """The result folder of a trial that has values; its run is computed again where the cache
        has it no longer. Raises SoftactError where that fails."""
        key = trial.user_attrs["run"]
        if self.cache.find(key) is None:
            jobs = {key: partial(_same_object, self._spec(self.coordinates(trial)))}
            how = self.slopes, self.end_only, None, self.wanted.kinds
            (answer,) = run_all(jobs, self.cache, 1, *how)
            if answer.record is None:
                raise answer.error()
        return self.cache.folder(key)

    def sheet_key(self, trial: FrozenTrial) -> str:
        """The key of a trial's run with all of its states, as far as that is there."""
        whole = self._whole_key(trial)
        there = self.end_only and self.cache.find(whole) is not None
        return whole if there else trial.user_attrs["run"]

    def whole(self, trial: FrozenTrial) -> str:
        """Run a trial's design from the beginning, where its own run has its last state only.
        Returns what is to be said of a difference between the two; empty: there is none.

        Raises SoftactError where the run cannot be had.
        """
        if not self.end_only:
            return ""
        spec = self._spec(self.coordinates(trial))
        (answer,) = run_all({self._whole_key(trial): partial(_same_object, spec)}, self.cache, 1)
        if answer.record is None:
            raise answer.error()
        for part in self.parts:
            one, other = trial.user_attrs[part.title], part.value(answer.record)
            if other is None or abs(one - other) > SAME * max(abs(one), abs(other)):
                return (
                    f"trial {trial.number}: from the beginning the run has {part.title} {other}, "
                    f"not {one:.6g}: its state is not the one that the actuator comes to"
                )
        return ""

    def _whole_key(self, trial: FrozenTrial) -> str:
        return run_key(self._spec(self.coordinates(trial)))


def _end_only(wanted: Optimisation, base: document.Document) -> bool:
    """Whether all that is asked of a run is in its last state, and hangs on no other."""
    parts = (*wanted.objectives, *wanted.constraints)
    spec = first_right(wanted.spec_at, base, wanted.parameters, wanted.tried())
    of_the_way = any(word in part.measure for part in parts for word in ON_THE_WAY)
    return not of_the_way and all(p.take == "last" for p in parts) and not why_not(spec)


def _differentiated(wanted: Optimisation, base: document.Document) -> list[list[str]]:
    """Full paths of each parameter's numbers. Raises SpecError where one has no derivative."""
    spec = first_right(wanted.spec_at, base, wanted.parameters, wanted.tried())
    found, faults = [], []
    for axis in wanted.parameters:
        try:
            found.append([parameter.path for parameter in chosen(spec, axis.path)])
        except SpecError as error:
            faults += [line.removeprefix("-p ") for line in error.lines]
    if faults:
        raise SpecError(*(f"method gradient: {line}" for line in faults))
    return found


def feasible(trial: FrozenTrial) -> bool:
    """Whether a trial has values and breaks no constraint."""
    return trial.values is not None and all(v <= 0 for v in trial.user_attrs.get("violations", []))


def _ended(trial: FrozenTrial) -> bool:
    """Whether a trial's run has ended and was told whole: a kill in between leaves it without
    values though its status is complete."""
    status = trial.user_attrs.get("status")
    return status is not None and (trial.values is not None) == (status == COMPLETE)


def _fixed(trial: FrozenTrial) -> dict[str, Any]:
    """Parameters of a trial, also where a kill came before they were suggested."""
    return trial.system_attrs.get("fixed_params") or trial.params


def _unbeaten(trials: Sequence[FrozenTrial], objectives: Sequence[Objective]) -> list[FrozenTrial]:
    if not trials:
        return []
    values = np.array([t.values for t in trials]) * [o.sign for o in objectives]
    front = [trials[number] for number in unbeaten(values)]
    unique = {tuple(t.values): t for t in reversed(front)}
    return sorted(unique.values(), key=lambda t: t.values)


def _same_object(spec: Spec) -> Spec:
    return spec


def _suggested(trial: Trial, axis: Axis) -> Any:
    if axis.values is not None:
        # By their places: Optuna takes no lists or mappings, and 1 for True.
        return axis.values[trial.suggest_categorical(axis.title, range(len(axis.values)))]
    low, high = sorted(axis.ends)
    if not axis.continuous:
        return trial.suggest_int(axis.title, int(low), int(high))
    number = trial.suggest_float(axis.title, low, high, log=axis.scale == "log")
    return _value(axis, number)


def _value(axis: Axis, parameter: Any) -> Any:
    """The spec's value of Optuna's parameter."""
    if axis.values is not None:
        return axis.values[parameter]
    if not axis.continuous:
        return parameter
    return written(float(f"{parameter:.{_DIGITS}g}"), axis.unit, False)


def _parameter(axis: Axis, value: Any) -> Any:
    """Optuna's parameter of a spec's value, which the axis has."""
    if axis.values is not None:
        return place_of(axis, value)
    number = float(axis.number(value))
    return number if axis.continuous else round(number)

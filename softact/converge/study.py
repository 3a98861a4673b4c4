"""Meshes of a spec made finer step by step until the measures stay."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from softact.converge.richardson import NOTHING, Estimate, change, counting, estimate
from softact.errors import NoEquilibriumError, SoftactError, SpecError
from softact.geometry.base import STEPS, Geometry
from softact.measured.columns import column_fault
from softact.results.folder import COMPLETE, read
from softact.spec import Spec
from softact.sweep.cache import Cache
from softact.sweep.compute import Answer
from softact.sweep.local import run_all
from softact.sweep.record import Record
from softact.sweep.version import run_key
from softact.verdict.judge import NOT_CONVERGED, NOT_KNOWN, WITHIN


@dataclass(frozen=True)
class Level:
    """One mesh. edge: length in mm of the edge of a cube (of sheets: of a square) that holds, on
    average, one element: what the order is measured over."""

    spec: Spec
    record: Record
    edge: float

    @property
    def sizes(self) -> dict[str, float]:
        """The geometry's mesh sizes, mm."""
        return mesh_sizes(self.spec.geometry)

    @property
    def steps(self) -> dict[str, int]:
        """The least number of elements between planes or lines, by the parameter's name."""
        return mesh_steps(self.spec.geometry)

    def __str__(self) -> str:
        return mesh_words(self.spec.geometry)


@dataclass
class Convergence:
    """A study. tolerance: relative error up to which a measure is right. stopped: why it ended
    before its last mesh, "" where it did not."""

    measures: tuple[str, ...]
    tolerance: float
    levels: list[Level] = field(default_factory=list)
    stopped: str = ""

    def values(self, measure: str) -> list[float]:
        """The measure on each mesh, coarse to fine."""
        return [level.record.measures[measure] for level in self.levels]

    def estimate(self, measure: str) -> Estimate:
        """What is known of a measure."""
        return estimate([level.edge for level in self.levels], self.values(measure))

    @property
    def counting(self) -> list[int]:
        """Numbers of the meshes that count: no other one is as fine."""
        return counting([level.edge for level in self.levels])

    def verdict_of(self, measure: str, number: int = -1) -> str:
        """WITHIN, NOT_CONVERGED or NOT_KNOWN: what is known of a measure on one of the meshes, by
        default the finest one."""
        found = self.estimate(measure)
        error = found.errors[number]
        if error is not None and found.limit is not None:
            near = error <= max(self.tolerance * abs(found.limit), NOTHING)
            return WITHIN if near else NOT_CONVERGED
        values = self.values(measure)
        off = change(values[number], values[self.counting[-1]])
        moves = max(off, found.last_change or 0.0) >= self.tolerance
        return NOT_CONVERGED if moves else NOT_KNOWN

    def verdict(self, number: int = -1) -> str:
        """The same of all measures: of the worst one."""
        found = {self.verdict_of(measure, number) for measure in self.measures}
        return next(v for v in (NOT_CONVERGED, NOT_KNOWN, WITHIN) if v in found)

    @property
    def converged(self) -> bool:
        """Whether all measures on the finest mesh are within the tolerance of their limits."""
        return self.verdict() == WITHIN

    @property
    def recommended(self) -> Level | None:
        """The coarsest mesh on which, and on all finer ones, all measures are within the
        tolerance."""
        found = None
        for number in reversed(range(len(self.levels))):
            if self.verdict(number) != WITHIN:
                break
            found = self.levels[number]
        return found


def mesh_sizes(geometry: Geometry) -> dict[str, float]:
    """The mesh size parameters that are set, mm."""
    sizes = {
        name: value
        for name in type(geometry).model_fields
        if name.endswith("mesh_size") and (value := getattr(geometry, name)) is not None
    }
    if not sizes:
        raise SpecError(f"geometry {geometry.type}: it has no mesh size to refine")
    return sizes


def mesh_steps(geometry: Geometry) -> dict[str, int]:
    """The parameter out of STEPS, if there is one, with its value."""
    fields = type(geometry).model_fields
    return {name: getattr(geometry, name) or 1 for name in STEPS if name in fields}


def mesh_words(geometry: Geometry) -> str:
    """The mesh parameters: ``mesh_size 2 mm, through_wall 2``."""
    sizes = [f"{name} {size:g} mm" for name, size in mesh_sizes(geometry).items()]
    steps = [f"{name} {number}" for name, number in mesh_steps(geometry).items() if number > 1]
    return ", ".join([*sizes, *steps])


def finer(geometry: Geometry, factor: float, times: int = 1) -> dict[str, str | int]:
    """The geometry's mesh parameters, as in a spec, refined by ``factor`` so many times.

    Sizes are divided. What counts elements grows by the factor as well, but by one each time at
    least: where there is one element through a wall, that wall is refined in no other way.
    """
    ratio = factor**times
    sizes = {name: f"{size / ratio:.6g} mm" for name, size in mesh_sizes(geometry).items()}
    return sizes | {
        name: max(least + times, math.ceil(least * ratio - NOTHING))
        for name, least in mesh_steps(geometry).items()
    }


def refined(spec: Spec, factor: float, times: int = 1) -> Spec:
    """The spec with a mesh that is refined by ``factor`` so many times, see ``finer``. Raises
    SpecError as a spec would."""
    if not times:
        return spec
    mesh = finer(spec.geometry, factor, times)
    return spec.with_({f"geometry.{name}": value for name, value in mesh.items()})


def converge(
    spec: Spec,
    measures: Sequence[str],
    cache: Cache,
    tolerance: float = 0.05,
    factor: float = 1.5,
    most: int = 5,
    jobs: int = 1,
    tell: Callable[[Level, Answer], None] = lambda level, answer: None,
) -> Convergence:
    """Refine by ``factor`` until no measure is known to be further than ``tolerance`` from its
    limit, or still changes by so much, at most ``most`` meshes, and at least three that count, so
    that an order can be found. tell: is called with each mesh and the answer of its run.

    Raises SpecError for a measure that the run does not have, SoftactError where one of the first
    three runs fails; where a later one does, the study ends with those before it.
    """
    _check(spec, measures)
    study = Convergence(tuple(measures), tolerance)
    while len(study.levels) < most:
        first = len(study.levels)
        if first >= 3 and len(study.counting) >= 3 and study.verdict() != NOT_CONVERGED:
            break
        count = 3 if first == 0 else 1  # three are needed in any case
        try:
            specs = [refined(spec, factor, n) for n in range(first, min(first + count, most))]
            for level in _levels(specs, cache, jobs, tell):
                _check_reached(level, measures)
                study.levels.append(level)
        except SoftactError as error:
            if not first:
                raise
            study.stopped = "; ".join(error.lines)
            break
    return study


def _levels(
    specs: Sequence[Spec], cache: Cache, jobs: int, tell: Callable[[Level, Answer], None]
) -> list[Level]:
    keys = {run_key(spec): spec for spec in specs}
    found: dict[str, Level] = {}
    for answer in run_all({key: partial(_same, spec) for key, spec in keys.items()}, cache, jobs):
        if answer.record is None:
            raise answer.error()
        spec = keys[answer.key]
        if answer.status != COMPLETE:
            raise NoEquilibriumError(f"{mesh_words(spec.geometry)}: {answer.cause}")
        folder = cache.folder(answer.key)
        found[answer.key] = Level(spec, answer.record, _edge(spec, answer.record, folder))
        tell(found[answer.key], answer)
    return [found[key] for key in keys]


def _same(spec: Spec) -> Spec:
    return spec


def _edge(spec: Spec, record: Record, folder: Path) -> float:
    """See ``Level``. folder: the run's, where the mesh is looked up if nothing else says how large
    the solid is."""
    layout, known = spec.geometry.layout(), spec.geometry.volumes()
    names, dimension = (layout.regions, 3) if layout.regions else (layout.sheets, 2)
    if set(names) <= set(known):
        whole = sum(known[name] for name in names)
    else:
        results = read(folder)
        edges = np.diff(results.points[results.cells[:, :4]], axis=1)
        whole = float(np.abs(np.linalg.det(edges)).sum()) / 6
    return (whole / record.cells) ** (1 / dimension)


def _check(spec: Spec, measures: Sequence[str]) -> None:
    """Raise SpecError for what no run of the spec can have, before anything is computed."""
    faults = [(measure, column_fault(measure, spec)) for measure in measures]
    if any(fault for _, fault in faults):
        raise SpecError(*(f"--measure {name}: {fault}" for name, fault in faults if fault))


def _check_reached(level: Level, measures: Sequence[str]) -> None:
    """Raise SpecError for a measure that stays empty, such as a failure pressure."""
    faults = [
        f"--measure {measure}: has no value at the end of the run; it would take a higher load"
        for measure in measures
        if not math.isfinite(level.record.measures.get(measure, math.nan))
    ]
    if faults:
        raise SpecError(*faults)

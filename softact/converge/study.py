"""Meshes of a spec made finer step by step until the measures stay."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from softact.columns import column_fault
from softact.converge.richardson import NOTHING, Estimate, estimate
from softact.errors import NoEquilibriumError, SpecError
from softact.results import COMPLETE
from softact.spec import Spec
from softact.spec.path import changed
from softact.sweep.cache import Cache
from softact.sweep.compute import Answer
from softact.sweep.local import run_all
from softact.sweep.record import Record
from softact.sweep.version import run_key


@dataclass(frozen=True)
class Level:
    """One mesh. sizes: the geometry's mesh sizes in mm. edge: length in mm of a cube's edge that
    holds, on average, one tetrahedron: what the order is measured over."""

    sizes: Mapping[str, float]
    spec: Spec
    record: Record
    edge: float


@dataclass
class Convergence:
    """A study. tolerance: relative change from mesh to mesh below which a measure stays."""

    measures: tuple[str, ...]
    tolerance: float
    levels: list[Level] = field(default_factory=list)

    def values(self, measure: str) -> list[float]:
        """The measure on each mesh, coarse to fine."""
        return [level.record.measures[measure] for level in self.levels]

    def estimate(self, measure: str) -> Estimate:
        """What is known of a measure."""
        return estimate([level.edge for level in self.levels], self.values(measure))

    @property
    def converged(self) -> bool:
        """Whether the last refinement changed every measure by less than the tolerance."""
        if len(self.levels) < 2:
            return False
        return all(self.estimate(m).changes[-1] < self.tolerance for m in self.measures)

    @property
    def recommended(self) -> Level | None:
        """The coarsest mesh whose error bar is within the tolerance for all measures."""
        found = [self.estimate(measure) for measure in self.measures]
        for number, level in enumerate(self.levels):
            if all(e.errors[number] <= max(self.tolerance * abs(e.limit), NOTHING) for e in found):
                return level
        return None


def mesh_sizes(spec: Spec) -> dict[str, float]:
    """The geometry's mesh size parameters that are set, mm."""
    sizes = {
        name: value
        for name in type(spec.geometry).model_fields
        if name.endswith("mesh_size") and (value := getattr(spec.geometry, name)) is not None
    }
    if not sizes:
        raise SpecError(f"geometry {spec.geometry.type}: it has no mesh size to refine")
    return sizes


def refined(spec: Spec, factor: float) -> Spec:
    """The spec with all mesh sizes divided by ``factor``. Raises SpecError as a spec would."""
    sizes = {name: f"{size / factor:.6g} mm" for name, size in mesh_sizes(spec).items()}
    return changed(spec, {f"geometry.{name}": size for name, size in sizes.items()})


def converge(
    spec: Spec,
    measures: Sequence[str],
    cache: Cache,
    tolerance: float = 0.05,
    factor: float = 1.5,
    most: int = 5,
    jobs: int = 1,
    told: Callable[[Level | None, Answer], None] = lambda level, answer: None,
) -> Convergence:
    """Refine by ``factor`` until all measures change by less than ``tolerance``, at most ``most``
    meshes, at least three, so that an order can be told.

    Raises SpecError for a measure that the run does not have, SoftactError where a run fails.
    """
    _check(spec, measures)
    study = Convergence(tuple(measures), tolerance)
    while len(study.levels) < most and not (len(study.levels) >= 3 and study.converged):
        first = len(study.levels)
        count = 3 if first == 0 else 1  # three are needed in any case
        specs = [refined(spec, factor**n) for n in range(first, min(first + count, most))]
        for level in _levels(specs, cache, jobs, told):
            _check_reached(level, measures)
            study.levels.append(level)
    return study


def _levels(specs: Sequence[Spec], cache: Cache, jobs: int, told) -> list[Level]:
    keys = {run_key(spec): spec for spec in specs}
    found: dict[str, Level] = {}
    for answer in run_all({key: lambda s=spec: s for key, spec in keys.items()}, cache, jobs):
        if answer.record is None:
            raise answer.error()
        spec = keys[answer.key]
        if answer.status != COMPLETE:
            sizes = ", ".join(f"{n} {v:g} mm" for n, v in mesh_sizes(spec).items())
            raise NoEquilibriumError(f"{sizes}: {answer.cause}")
        found[answer.key] = Level(mesh_sizes(spec), spec, answer.record, _edge(spec, answer.record))
        told(found[answer.key], answer)
    return [found[key] for key in keys]


def _edge(spec: Spec, record: Record) -> float:
    volumes = spec.geometry.volumes()
    if not volumes:  # of a part out of a file nobody knows it: gmsh makes the edges as it is told
        return min(mesh_sizes(spec).values())
    volume = sum(volumes[region] for region in spec.geometry.layout().regions)
    return (volume / record.cells) ** (1 / 3)


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

"""The sweep file: a base spec, axes over its paths, a design, and trends to look for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    WithJsonSchema,
    model_validator,
)

from softact.errors import SpecError
from softact.fields import Name, fault_at
from softact.files import document
from softact.nearest import nearest
from softact.spec import Spec, loading, spec_at
from softact.spec.building import name_of
from softact.spec.faults import validated
from softact.spec.kinds import read_as
from softact.spec.path import assign, check, dotted
from softact.sweep.axes import Axis
from softact.sweep.design import MOST_POINTS, TOLERANCES, Coordinates, Design
from softact.sweep.module_point import point_of
from softact.sweep.parts import Objective
from softact.sweep.points import first_right
from softact.sweep.tolerance_axes import tolerance_axes
from softact.units import show

LEAST_SAMPLES = 8  # of the design tolerances
MOST_CONFIRMED = 1000
FULL: Literal["full"] = "full"
KINDS = {"moment": "straight", "force": "clamped"}  # runs in which a module exerts them


class Trend(BaseModel):
    """What a measure is expected to do along an axis, all else equal; told and not enforced."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    measure: str = Field(description="column of summary.csv, such as bending_angle_deg")
    axis: str = Field(description="name of the axis")
    does: Literal["rise", "fall", "peak", "dip"] = Field(
        description="with the axis, or a largest or smallest value inside its range"
    )
    source: str = Field("", description="who says so")


def _design(value: Any) -> Any:
    return {"kind": value} if isinstance(value, str) else value


_DESIGN = Design.model_json_schema()
_DESIGN_SCHEMA = {"anyOf": [_DESIGN["properties"]["kind"], _DESIGN]}


class StudyFile(BaseModel):
    """Base of a sweep and of an optimisation: a base spec and changes to it.

    kind: of the file. of_axes: the field that holds what is varied.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    kind: ClassVar[str]
    of_axes: ClassVar[str]

    name: Name = Field("study", description="default: the name of the file")
    description: str = Field("", description="free text")
    source: str = Field("", description="paper, DOI")
    base: str | dict[str, Any] = Field(
        description="file of the base spec, seen from this file, or the spec itself"
    )
    set: dict[str, Any] = Field({}, description="path: value, replaced in the base")
    model: Literal["full", "module"] = Field(
        FULL,
        description="module: each run is of one module of the chain that the actuator is, and its "
        "figures are those of so many, docs/modules.md",
    )
    blocked: tuple[Literal["moment", "force"], ...] = Field(
        (),
        strict=False,
        description="with model: module: what a blocked module exerts, by a further run for each",
    )
    confirm: int = Field(
        0,
        ge=0,
        le=MOST_CONFIRMED,
        description="with model: module: so many of the best points are computed as whole "
        "actuators in the end",
    )

    @model_validator(mode="after")
    def _of_modules(self) -> Self:
        if self.model == FULL:
            for key in ("blocked", "confirm"):
                if getattr(self, key):
                    raise fault_at((key,), "is for 'model: module'; all runs here are of wholes")
        if len(set(self.blocked)) < len(self.blocked):
            raise fault_at(("blocked",), "names one of them twice")
        return self

    @property
    def kinds(self) -> tuple[str, ...] | None:
        """Further runs of each module; None where the runs are of whole actuators."""
        return None if self.model == FULL else tuple(KINDS[name] for name in self.blocked)

    def spec_at(self, base: document.Document, changes: Iterable[tuple[str, Any]] = ()) -> Spec:
        """The spec of a point's run: of the whole actuator or of its module. Raises SpecError."""
        spec = spec_at(base, changes)
        return spec if self.model == FULL else point_of(spec)

    @property
    def varied(self) -> tuple[Axis, ...]:
        """The axes."""
        return getattr(self, self.of_axes)

    def tried(self) -> list[Coordinates]:
        """Designs of which one at least has to be right before anything is computed; of none where
        all points are looked at anyway."""
        return []

    def at_base(self, base: document.Document) -> tuple[Self, document.Document]:
        """The study with what it takes from its base spec, and that."""
        return self, base


Kind = TypeVar("Kind", bound=StudyFile)


class Sweep(StudyFile):
    """A sweep over the values of a spec."""

    kind: ClassVar[str] = "sweep"
    of_axes: ClassVar[str] = "axes"

    axes: tuple[Axis, ...] = Field(
        (), strict=False, description="paths and their values; none with the design tolerances"
    )
    design: Annotated[Design, BeforeValidator(_design), WithJsonSchema(_DESIGN_SCHEMA)] = Field(
        Design(),
        description="grid, one_at_a_time, latin_hypercube, sobol, tolerances, or {kind:, samples:}",
    )
    trends: tuple[Trend, ...] = Field((), strict=False, description="what to look for in the end")
    objectives: tuple[Objective, ...] = Field(
        (), strict=False, description="what makes a point one of the best, for confirm"
    )

    @model_validator(mode="after")
    def _axes_and_trends_agree(self) -> Self:
        if self.design.kind != TOLERANCES:
            check_axes(self.axes)
        elif self.axes:
            raise fault_at(
                ("axes",), "the design tolerances takes them from the base: leave them out"
            )
        elif self.design.samples < LEAST_SAMPLES:
            why = f"a standard deviation needs at least {LEAST_SAMPLES} samples"
            raise fault_at(("design", "samples"), why)
        elif self.model != FULL:
            why = "the design tolerances compares with derivatives, and a module has none"
            raise fault_at(("model",), why)
        check_count(self.design.count(self.axes), ("axes",))
        if self.confirm and not self.objectives:
            why = "which points are the best? write objectives: [{measure: ..., goal: maximise}]"
            raise fault_at(("confirm",), why)
        titles = [axis.title for axis in self.axes]
        if self.trends and self.design.kind == TOLERANCES:
            raise fault_at(("trends",), "the design tolerances has no axes along which to look")
        for number, trend in enumerate(self.trends):
            if trend.axis not in titles:
                where = ("trends", number, "axis")
                raise fault_at(where, f"no axis {show(trend.axis)}; {nearest(trend.axis, titles)}")
        return self

    def at_base(self, base: document.Document) -> tuple[Self, document.Document]:
        """See ``StudyFile.at_base``: the design tolerances has an axis for each of the base."""
        if self.design.kind != TOLERANCES:
            return self, base
        resolved, axes = tolerance_axes(base)
        if not axes:
            raise SpecError(
                f"{base.name}: the design tolerances takes what varies from the base, and that has "
                "no tolerances; write for example tolerances: {geometry.wall: 0.1 mm}"
            )
        return self.model_copy(update={"axes": axes}), resolved


def check_count(count: int, place: tuple[str, ...]) -> None:
    """Raise a fault where a study has more points than could ever be kept in mind and computed."""
    if count > MOST_POINTS:
        raise fault_at(place, f"{count} points; a study has at most {MOST_POINTS}, so take fewer")


def check_axes(axes: Sequence[Axis]) -> None:
    """Raise a fault where there is no axis, or two have one name or path."""
    if not axes:
        raise fault_at(("axes",), "empty; write for example - {path: geometry.roof, values: [...]}")
    titles, paths = [], []
    for number, axis in enumerate(axes):
        if axis.title in titles:
            raise fault_at(("axes", number), f"two axes have the name {show(axis.title)}")
        titles.append(axis.title)
        for path in axis.path:
            if path in paths:
                raise fault_at(("axes", number, "path"), f"{show(path)} is in another axis too")
            paths.append(path)


def read(file: Path, model: type[Kind]) -> tuple[Kind, document.Document]:
    """Return a study file as ``model``, and its base spec as plain data with the ``set`` applied.

    Raises SpecError with one line per fault of either, also where a path of an axis is none of a
    spec, and where no design of an optimisation can be right.
    """
    source = read_as(Path(file), model.kind)
    source.data.setdefault("name", name_of(source.name))
    study = validated(source, model)
    base = loading.part(source, "base", study.name)
    faults = []
    for path, value in study.set.items():
        where = source.where(("set", path))
        try:
            check(base, assign(base, path, value, where, Spec), Spec)
        except SpecError as error:
            faults += [f"{where}: set.{path}: {line}" for line in error.lines]
    faults += _lost(study, source, base)
    if faults:
        raise SpecError(*faults)
    if designs := study.tried():
        first_right(study.spec_at, base, study.varied, designs)
    return study.at_base(base)


def _lost(study: StudyFile, source: document.Document, base: document.Document) -> Iterator[str]:
    """A line for each path of an axis that leads nowhere in the base, all others being set."""
    here = base.copy()
    for number, axis in enumerate(study.varied):
        for one in axis.path:
            try:
                check(here, assign(here, one, axis.steps()[0], "", Spec), Spec)
            except SpecError as error:
                place = (study.of_axes, number, "path")
                start = f"{source.where(place)}: {dotted(place)}: {show(one)}"
                yield from (f"{start}: {line}" for line in error.lines)

"""The sweep file: a base spec, axes over its paths, a design, and trends to look for."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator

from softact.errors import SpecError
from softact.spec import document, overrides
from softact.spec.choice import fault_at, nearest
from softact.spec.faults import fault_lines
from softact.spec.fields import Name
from softact.sweep.axes import Axis
from softact.sweep.design import MOST_POINTS, Design
from softact.units import show


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


class Model(BaseModel):
    """Base of a sweep and of an optimisation: a base spec and changes to it."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    name: Name = Field("study", description="default: the name of the file")
    description: str = Field("", description="free text")
    source: str = Field("", description="paper, DOI")
    base: str | dict[str, Any] = Field(
        description="file of the base spec, seen from this file, or the spec itself"
    )
    set: dict[str, Any] = Field({}, description="path: value, replaced in the base")


class Sweep(Model):
    """A sweep over the values of a spec."""

    axes: tuple[Axis, ...] = Field(strict=False, description="paths and their values")
    design: Annotated[Design, BeforeValidator(_design)] = Field(
        Design(), description="grid, one_at_a_time, latin_hypercube, sobol, or {kind:, samples:}"
    )
    trends: tuple[Trend, ...] = Field((), strict=False, description="what to look for in the end")

    @model_validator(mode="after")
    def _axes_and_trends_agree(self) -> Self:
        check_axes(self.axes)
        check_count(self.design.count(self.axes), ("axes",))
        titles = [axis.title for axis in self.axes]
        for number, trend in enumerate(self.trends):
            if trend.axis not in titles:
                where = ("trends", number, "axis")
                raise fault_at(where, f"no axis {show(trend.axis)}; {nearest(trend.axis, titles)}")
        return self


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


def read(path: Path, model: type[Model]) -> tuple[Any, document.Document]:
    """Return a study file as ``model``, and its base spec as plain data with the ``set`` applied.

    Raises SpecError with one line per fault of either.
    """
    source = document.read(Path(path))
    source.data.setdefault("name", _name(path))
    try:
        study = model.model_validate(source.data)
    except ValidationError as error:
        raise SpecError(*fault_lines(error, source, model)) from None
    base = _base(study, source, Path(path).parent)
    faults = []
    for place, value in study.set.items():
        try:
            overrides.assign(base, place, value, f"{place}={value}")
        except SpecError as error:
            faults += [f"{source.where(('set', place))}: set.{place}: {e}" for e in error.lines]
    if faults:
        raise SpecError(*faults)
    return study, base


def _name(path: Path) -> str:
    from softact.spec import _name as name

    return name(str(path))


def _base(study: Model, source: document.Document, folder: Path) -> document.Document:
    if isinstance(study.base, str):
        base = document.read(folder / study.base)
    else:
        lines = {place[1:]: n for place, n in source.lines.items() if place[:1] == ("base",)}
        base = document.Document(source.name, study.base, lines)
    base.data.setdefault("name", study.name)
    return base

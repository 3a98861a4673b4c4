"""A reference case: a spec and what it must give, each value with its tolerance and source."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from softact.errors import SpecError
from softact.fields import fault, fault_at
from softact.files import document
from softact.files.text import digest
from softact.nearest import nearest
from softact.spec import Spec, part, spec_at
from softact.spec.faults import validated
from softact.spec.kinds import read_as
from softact.units import Dimensionless

FOLDER = Path("configs") / "reference"


class CurvePoint(BaseModel):
    """A point of the curve: where a column passes a value."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    column: str = Field(description="column of curve.csv, such as pressure_kPa")
    value: Dimensionless = Field(description="in the column's unit")


class Value(BaseModel):
    """What one column must be."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    measure: str = Field(description="column of curve.csv, such as bending_angle_deg")
    value: Dimensionless = Field(description="in the column's unit")
    tolerance: Dimensionless = Field(gt=0, description="largest difference, in the same unit")
    kind: Literal["exact", "published", "computed"] = Field(
        description="exact: by hand or closed form; published: measured or computed by others; "
        "computed: what softact gave; only these can be updated"
    )
    source: str = Field(min_length=1, description="where the value is from")
    at: CurvePoint | None = Field(None, description="interpolated there; default: the last state")

    @property
    def title(self) -> str:
        """The measure and where it is read."""
        return f"{self.measure} at {self.at.column} {self.at.value:g}" if self.at else self.measure


class Update(BaseModel):
    """When and why computed values were replaced."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    date: str = Field(description="day")
    reason: str = Field(description="why")
    changes: tuple[str, ...] = Field((), strict=False, description="old and new values")


class CaseFile(BaseModel):
    """The content of a case's file."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    description: str = Field(description="what the case shows, in one line")
    spec: dict[str, Any] | str = Field(description="the spec, or its file seen from this one")
    values: tuple[Value, ...] = Field(strict=False, description="what must come out")
    history: tuple[Update, ...] = Field((), strict=False, description="written by --update")

    @model_validator(mode="after")
    def _has_values(self) -> Self:
        if not self.values:
            raise fault_at(("values",), "empty; write for example - {measure: elongation_mm, ...}")
        titles = [value.title for value in self.values]
        for title in titles:
            if titles.count(title) > 1:
                raise fault(f"'values' holds {title} twice; keep one")
        return self


@dataclass(frozen=True)
class Case:
    """A case as read. name: of its file. digest: of the file's content."""

    name: str
    path: Path
    content: CaseFile
    spec: Spec
    source: document.Document
    digest: str


def find(names: tuple[str, ...]) -> list[Path]:
    """Files of the named cases (a name in ``FOLDER``, or a path); all where none is named."""
    known = sorted(FOLDER.glob("*.yaml"))
    if not names:
        if not known:
            raise SpecError(f"{FOLDER}: there is no case here; name the files of your cases")
        return known
    found = []
    for name in names:
        path = next((p for p in known if p.stem == name), Path(name))
        if not path.is_file():
            hint = nearest(name, [p.stem for p in known])
            raise SpecError(f"{name}: there is no such case or file; {hint}")
        found.append(path)
    return found


def read(path: Path) -> Case:
    """Read a case. Raises SpecError with one line per fault."""
    source = read_as(path, "case")
    known = digest(path)
    content = validated(source, CaseFile)
    spec = spec_at(part(source, "spec", path.stem))
    return Case(path.stem, path, content, spec, source, known)


def in_tolerance(value: Value, found: float) -> bool:
    """Whether a figure is as stored."""
    return math.isfinite(found) and abs(found - value.value) <= value.tolerance

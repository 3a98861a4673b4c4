"""The tolerances of a spec as the axes of a sweep."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pydantic import Field

from softact.files.document import Document
from softact.spec import spec_at
from softact.sweep.axes import Axis, known_quantity, written
from softact.tolerances.causes import Cause, causes

#: Ends of an axis, as parts of all actuators: what a page draws, not where samples end.
ENDS = (0.001, 0.999)


class ToleranceAxis(Axis):
    """One tolerance: values are those of its first parameter, with which the others go."""

    cause: Any = Field(exclude=True)

    def at(self, fractions: Sequence[float]) -> list[Any]:
        """Values that these parts of all actuators are below."""
        return [_told(self.cause, fraction) for fraction in fractions]

    def changes(self, value: Any) -> list[tuple[str, Any]]:
        """See ``Axis.changes``; each parameter has its own value."""
        cause: Cause = self.cause
        first = known_quantity(value)[0] * cause.parameters[0].factor
        return [
            (p.path, written(v / p.factor, p.unit, False))
            for p, v in zip(cause.parameters, cause.along(first), strict=True)
        ]


def _told(cause: Cause, fraction: float) -> str | int | float:
    first = cause.parameters[0]
    return written(cause.values(fraction)[0] / first.factor, first.unit, False)


def tolerance_axes(base: Document) -> tuple[Document, tuple[ToleranceAxis, ...]]:
    """A base spec with all that it leaves to defaults, so that every path is there, and an axis for
    each of its tolerances. Raises SpecError where one is none."""
    spec = spec_at(base)
    found: list[ToleranceAxis] = []
    for cause in causes(spec):
        low, high = (_told(cause, end) for end in ENDS)
        paths = tuple(p.path for p in cause.parameters)
        ends: dict[str, Any] = {"from": low, "to": high}
        found.append(ToleranceAxis(path=paths, name=cause.name, cause=cause, **ends))
    data = spec.model_dump(mode="json", exclude_none=True)
    return Document(base.name, data, folder=base.folder), tuple(found)

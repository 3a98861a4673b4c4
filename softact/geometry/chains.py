"""What geometries share that are chains of equal modules, and can mesh one of them alone."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field

from softact.errors import SpecError
from softact.geometry.base import Geometry
from softact.mesh.layout import Repeats

OneModule = Annotated[
    Literal[True] | None,
    Field(
        description="mesh one module of the chain alone, between two faces that repeat; "
        "softact module writes it"
    ),
]


class Chain(Geometry):
    """A geometry with a field ``module_alone: OneModule``; one without it has no module."""

    #: The field that says how many modules there are, and what one is called; None: another does.
    counted: ClassVar[tuple[str, str] | None] = None

    def no_chain(self) -> Iterator[tuple[str, str]]:
        """Field and reason why there is no module, such as a single chamber."""
        if self.counted and getattr(self, self.counted[0]) == 1:
            yield self.counted[0], f"one {self.counted[1]} is no chain; write 2 or more"

    @property
    def pitches(self) -> float:
        """See ``Geometry.pitches``."""
        return getattr(self, self.counted[0]) if self.counted else super().pitches

    def short(self) -> dict[str, Any]:
        """Fields of the same chain of few modules, whose two ends are as far apart as they need to
        be; empty where that is not known."""
        return {}

    def module(self) -> Self:
        """See ``Geometry.module``."""
        if "module_alone" not in type(self).model_fields:
            return super().module()
        if why := [f"geometry.{name}: {reason}" for name, reason in self.no_chain()]:
            raise SpecError(*why)
        return self.model_copy(update={"module_alone": True})

    def faults(self) -> Iterator[tuple[str, str]]:
        """See ``Geometry.faults``."""
        if self.alone:
            yield from self.no_chain()

    @property
    def alone(self) -> bool:
        """Whether one module is meshed alone."""
        return bool(getattr(self, "module_alone", None))

    @property
    def ends(self) -> tuple[str, str]:
        """Names of the two flat ends of what is meshed."""
        return ("left", "right") if self.alone else ("clamp", "tip")

    @property
    def repeats(self) -> Repeats | None:
        """The ends, where the next modules go on there."""
        return Repeats(*self.ends) if self.alone else None

"""What a body is: its stored energy, its mass, and what the solver has to know of it."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from softact.fields import Fault, Place
from softact.mesh.layout import Layout

if TYPE_CHECKING:
    from softact.bodies.inertia import Inertia
    from softact.bodies.weight import Weight
    from softact.model import Model
    from softact.system.term import Term


class Body(Protocol):
    """A region of tetrahedra, a layer, a sheet: what a model is made of.

    elastic: terms of its stored energy; external: further ones, whose energy is not the actuator's.
    slowness: square of the inverse speed of its slowest wave,
    s²/mm², 0 where others decide. slackens: whether it goes slack, so that a line search is wanted
    on each step; smooth: whether its forces have no kinks. stiffness: force, N, of a strain of 1.
    """

    @property
    def elastic(self) -> Sequence[Term]:
        """See the class."""

    @property
    def external(self) -> Sequence[Term]:
        """See the class."""

    @property
    def slowness(self) -> float:
        """See the class."""

    @property
    def slackens(self) -> bool:
        """See the class."""

    @property
    def smooth(self) -> bool:
        """See the class."""

    @property
    def stiffness(self) -> float:
        """See the class. Collective."""

    def weight(self) -> Weight | None:
        """Its weight, None where it has none."""

    def inertia(self) -> Inertia | None:
        """Its inertia, for motions; None where it has none."""


class BodyKind:
    """One kind of body; ``BODIES`` in ``softact.bodies`` holds them.

    key: of what a model is made of. annotation, description: of that key in a spec, for pydantic;
    nothing is its default. annotation is None where the spec writes its key itself.
    """

    key: str
    annotation: ClassVar[Any] = None
    description: ClassVar[str] = ""

    def build(self, model: Model, parts: Any) -> Sequence[Body]:
        """The bodies on a model whose nodes, unknowns and assembler are there. Collective.

        parts: what ``Model`` was given under the key.
        """
        raise NotImplementedError

    def faults(self, written: Any, place: Place, layout: Layout) -> Iterator[Fault]:
        """Yield what is wrong with the plain data of the key beside a geometry; of which any part
        may be malformed."""
        return iter(())

    def parts(self, value: Any) -> Any:
        """What ``build`` takes, of the value of a valid spec."""
        return value


class InModule(BodyKind):
    """A kind whose key the spec writes itself. Its module, which has ``build``, is imported when a
    model is made: a spec is read without dolfinx."""

    def __init__(self, key: str, module: str):
        self.key, self._module = key, module

    def build(self, model: Model, parts: Any) -> Sequence[Body]:
        """See ``BodyKind``."""
        return importlib.import_module(self._module).build(model, parts)

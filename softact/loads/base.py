"""What a load is: from the key of a spec's step to a term of the potential energy, in one class.

``LOADS`` in ``softact.loads`` holds all of them. What a spec may write, how a load ramps, what a
checkpoint keeps, what enters the matrix and what the reference says follow from it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from softact.fields import Fault, Place, is_zero
from softact.mesh.layout import Layout
from softact.nearest import nearest
from softact.system.term import Value
from softact.units import show

if TYPE_CHECKING:
    from softact.model import Model
    from softact.system.term import Term


class Load:
    """One kind of load.

    key: of a spec's step, and by default the name under which a state holds its values.
    annotation, description: of that key, for pydantic. fields: names under which a state holds
    values, each a mapping of what is loaded to its value. easy: whether a step that changes nothing
    else may go to its end in one increment. holds_volume: whether the pressures of the cavities
    that it names are unknown then, as where volume is added to them; nothing of it is part of a
    state.
    """

    key: ClassVar[str]
    annotation: ClassVar[Any]
    description: ClassVar[str]
    fields: ClassVar[tuple[str, ...]] = ()
    easy: ClassVar[bool] = False
    holds_volume: ClassVar[bool] = False

    def __init_subclass__(cls) -> None:
        if hasattr(cls, "key"):  # what several loads have in common has none
            cls.fields = cls.fields or (cls.key,)

    # --- in a spec --------------------------------------------------------------------------------

    def faults(
        self, written: Any, place: Place, layout: Layout, step: Mapping[str, Any]
    ) -> Iterator[Fault]:
        """Yield what is wrong with the plain data of a step's key beside a geometry; of which any
        part may be malformed. step: all of the step's data."""
        return iter(())

    def for_layout(self, value: Any, layout: Layout) -> Any:
        """The value of a valid spec with all that the geometry fills in."""
        return value

    def ends(self, value: Any, model: Model) -> dict[str, Mapping[str, Value]]:
        """Values at the end of a step, by field, in internal units. Collective."""
        return {self.key: value}

    # --- in a state -------------------------------------------------------------------------------

    def initial(self, model: Model) -> dict[str, dict[str, Value]]:
        """Values of the unloaded state, by field."""
        return {name: {} for name in self.fields}

    def start(self, field: str, before: Value | None, end: Value) -> Value:
        """Value at the start of a step of what had ``before`` (None: nothing) and will have
        ``end``."""
        return np.zeros_like(end) if before is None else before

    def said(self, name: str, value: Value, model: Model) -> str:
        """A value of the whole actuator in words; "" where nothing is to be said. Collective."""
        return ""

    # --- in the system ----------------------------------------------------------------------------

    def term(self, model: Model, name: str) -> Term | None:
        """The term that the load on ``name`` adds; None where it is there anyway. Collective."""
        return None


def vector_faults(
    written: Any,
    key: str,
    place: Place,
    layout: Layout,
    turns_round: Callable[[int, int], bool],
    fault: str,
    marks: Iterable[str] = (),
) -> Iterator[Fault]:
    """Yield what is wrong with a vector on a surface, by default the tip.

    turns_round: of a component and of the normal of a symmetry plane, whether the component would
    pull or turn the mirror image the other way; fault: what to say then, of the ``{plane}``.
    marks: points and lines on which it may be too.
    """
    if not isinstance(written, dict):
        return
    surface = written.get("surface") or layout.tip
    yield from surface_fault(surface, (*place, "surface"), layout, marks)
    vector = written.get(key)
    if not isinstance(vector, list | tuple) or len(vector) != 3:
        return
    for plane, normal in layout.symmetry.items():
        for axis, component in enumerate(vector):
            if turns_round(axis, normal) and not is_zero(component):
                yield (*place, key, axis), fault.format(plane=plane)


def surface_fault(
    name: Any, place: Place, layout: Layout, marks: Iterable[str] = ()
) -> Iterator[Fault]:
    """Yield what is wrong with the name of a surface, sheet or curve, or of one of ``marks``."""
    known = (*layout.surfaces, *layout.sheets, *layout.curves, *marks)
    if isinstance(name, str) and name not in known and name in layout.marks:
        kind = "point" if name in layout.points else "line"
        yield place, f"{show(name)} is a {kind}; write one of: {', '.join(known)}"
    elif isinstance(name, str) and name not in known:
        yield place, f"the geometry has no surface {show(name)}; {nearest(name, known)}"

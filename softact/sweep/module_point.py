"""A point of a study on modules: the spec of its module."""

from __future__ import annotations

from softact.errors import SpecError
from softact.measures import MEASURES
from softact.spec import Spec
from softact.spec.modules import beside
from softact.spec.one_module import free_module
from softact.spec.path import dotted

#: Increments of a module where the spec says nothing of them: it is small, and fewer and larger
#: ones are the quickest (docs/sweeps.md).
COARSE = 0.5
#: Measures that take a fifth of such a run each, and that a study asks for by their names.
SLOW = ("module_stiffness", "module_waves")
NEEDED = "module"  # the measure that a chain is told from


def point_of(spec: Spec) -> Spec:
    """The spec of an actuator's free module, for one of many runs.

    Raises SpecError with one line for each fault, where there is no module, or where the spec has
    what cannot stand beside one.
    """
    if spec.layout().repeats is not None:
        raise SpecError("model: the base is one module already; leave 'model: module' out")
    if len(spec.geometry.in_segments()) > 1:
        raise SpecError(
            "geometry.segments: a study on modules is of one segment; write segments: 1"
        )
    changes: dict[str, object] = {}
    if not spec.solver.model_fields_set & {"initial_increment", "max_increment"}:
        changes |= {"solver.initial_increment": COARSE, "solver.max_increment": COARSE}
    if spec.measures == "all":
        changes["measures"] = [name for name in MEASURES if name not in SLOW]
    elif NEEDED not in spec.measures:
        changes["measures"] = [*spec.measures, NEEDED]
    try:
        return free_module(spec, {}, more=changes)
    except SpecError as error:
        lines = _refused(spec) or [line.removeprefix("spec: ") for line in error.lines]
        raise SpecError(*(f"model: module: {line}" for line in lines)) from None


def _refused(spec: Spec) -> list[str]:
    """What of an actuator's spec cannot stand beside a module, without what follows from it."""
    data = spec.model_dump(mode="json", exclude_none=True, exclude={"supports"})
    return [f"{dotted(place)}: {why}" for place, why in beside(data)]

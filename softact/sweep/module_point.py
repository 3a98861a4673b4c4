"""A point of a study on modules: the spec of its module."""

from __future__ import annotations

from softact.errors import SpecError
from softact.measures import MEASURES
from softact.spec import Spec
from softact.spec.one_module import free_module

#: Increments of a module where the spec says nothing of them: it is small, and fewer and larger
#: ones are the quickest (docs/sweeps.md).
COARSE = 0.5
#: A measure that takes a fifth of such a run, and that a study asks for by its name.
SLOW = "module_stiffness"
NEEDED = "module"  # the measure that a chain is told from


def point_of(spec: Spec) -> Spec:
    """The spec of an actuator's free module, for one of many runs.

    Raises SpecError with one line for each fault, where there is no module, or where the spec has
    what cannot stand beside one.
    """
    if spec.layout().repeats is not None:
        raise SpecError("model: the base is one module already; leave 'model: module' out")
    try:
        free = free_module(spec, {})
    except SpecError as error:
        lines = [line.removeprefix("spec: ") for line in error.lines]
        raise SpecError(*(f"model: module: {line}" for line in lines)) from None
    changes: dict[str, object] = {}
    given = spec.solver.model_fields_set
    if not given & {"initial_increment", "max_increment"}:
        changes |= {"solver.initial_increment": COARSE, "solver.max_increment": COARSE}
    if spec.measures == "all":
        changes["measures"] = [name for name in MEASURES if name != SLOW]
    elif NEEDED not in spec.measures:
        changes["measures"] = [*spec.measures, NEEDED]
    return free.with_(changes) if changes else free

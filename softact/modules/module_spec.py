"""From the spec of an actuator to those of its module."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from softact.errors import SpecError
from softact.loads import LOADS
from softact.mesh.layout import COMPONENTS, free_components
from softact.nearest import nearest
from softact.spec import Spec

HINT = "hold components with --hold, such as --hold turn_y='10 deg'"


@dataclass(frozen=True)
class ModuleSpecs:
    """runs: ``free``: what nothing holds but ``--hold``; ``straight``: all turns are held, where
    symmetry leaves any; ``clamped``: the length is held, too.

    pitches: modules of the whole actuator, None where the spec is that of a module itself.
    """

    runs: dict[str, Spec]
    pitches: float | None


def module_specs(
    spec: Spec, hold: Mapping[str, str], weight: bool = True, contact: bool = True
) -> ModuleSpecs:
    """The specs of an actuator's module; a clamp is the end of a chain, and no module has one.

    hold: component such as ``turn_y`` -> quantity as text. weight, contact: False leaves what the
    spec has of it out. Raises SpecError with one line for each fault.
    """
    alone = spec.layout().repeats is not None
    geometry = spec.geometry if alone else spec.geometry.module()
    repeats = geometry.layout().repeats or spec.layout().repeats
    assert repeats is not None  # a module has them
    changes: dict[str, object] = {
        "supports": [],
        "module.left": repeats.left,
        "module.right": repeats.right,
    }
    if not alone:
        changes["geometry.module_alone"] = True
    if spec.sheets:
        changes["sheets"] = _of_module(spec, geometry.layout().sheets)
    if not weight:
        changes["steps"] = _weightless(spec)
    if not contact:
        changes["contact"] = "none"
    for name, value in hold.items():
        if name not in COMPONENTS:
            raise SpecError(f"--hold {name}: {nearest(name, COMPONENTS)}")
        kind, component = name.split("_")
        changes[f"module.{kind}.{component}"] = value
    free = spec.with_(changes)
    held = _blocked(free)
    turns = {path: value for path, value in held.items() if path.startswith("module.turn")}
    runs = {"free": free} | ({"straight": free.with_(turns)} if turns else {})
    runs["clamped"] = free.with_(held)
    return ModuleSpecs(runs, None if alone else spec.geometry.pitches)


def _of_module(spec: Spec, sheets: Sequence[str]) -> dict[str, Any]:
    """The sheets of a module as plain data: those of the whole without its ends."""
    made_of = spec.model_dump(mode="json", exclude_none=True)["sheets"]
    return {name: made_of[name] for name in sheets}


def _weightless(spec: Spec) -> list[dict[str, Any]]:
    """The steps as plain data without weight, and without those that change nothing else."""
    steps = spec.model_dump(mode="json", exclude_none=True)["steps"]
    kept = [{k: v for k, v in step.items() if k != "gravity"} for step in steps]
    return [step for step in kept if {*LOADS, "supports", "duration"} & step.keys()]


def _blocked(spec: Spec) -> dict[str, str]:
    """Values of all components that symmetry leaves, of a module as it is undeformed."""
    layout = spec.layout()
    pitch = dict(zip("xyz", (spec.geometry.layout().length * a for a in layout.axis), strict=True))
    free = free_components(layout.symmetry).ravel()
    names = [name for name, is_free in zip(COMPONENTS, free, strict=True) if is_free]
    return {
        f"module.{name.replace('_', '.')}": f"{pitch[name[-1]]} mm" if "shift" in name else "0 deg"
        for name in names
    }

"""From the spec of an actuator to that of one module of the chain that it is, free or blocked."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from softact.errors import SpecError
from softact.loads import LOADS
from softact.mesh.layout import COMPONENTS, Layout, free_components
from softact.nearest import nearest
from softact.spec.models import Spec


def free_module(
    spec: Spec,
    hold: Mapping[str, str],
    weight: bool = True,
    contact: bool = True,
    more: Mapping[str, object] = MappingProxyType({}),
) -> Spec:
    """The spec of an actuator's module that nothing holds but ``hold``; a clamp is the end of a
    chain, and no module has one. Of several segments it is that of the first.

    hold: component such as ``turn_y`` -> quantity as text. weight, contact: False leaves what the
    spec has of it out. more: what else differs, dotted path -> value. Raises SpecError with one
    line for each fault.
    """
    spec = first_segment(spec)
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
    if not contact:
        changes["contact"] = "none"
    elif spec.contact and not alone:
        changes["contact"] = _of_inner(spec, geometry.layout())
    if not weight:
        changes["steps"] = _weightless(spec)
    for name, value in hold.items():
        if name not in COMPONENTS:
            raise SpecError(f"--hold {name}: {nearest(name, COMPONENTS)}")
        kind, component = name.split("_")
        changes[f"module.{kind}.{component}"] = value
    return spec.with_({**changes, **more})


def first_segment(spec: Spec) -> Spec:
    """The segment at the clamp as an actuator of its own, under the loads of its cavities; a spec
    of one segment as it is.

    Raises SpecError with one line for each fault, and where no step loads that segment.
    """
    first, *others = spec.geometry.in_segments()
    if not others:
        return spec
    data = spec.model_dump(mode="json", exclude_none=True, exclude={"geometry"})
    names = {whole: alone for alone, whole in first.items()}
    found = _renamed(data, names, {name for other in others for name in other.values()})
    steps = [step for step in found["steps"] if _changes_something(step)]
    if not steps:
        raise SpecError("steps: none loads the segment at the clamp, of which the module is taken")
    changed = {key: value for key, value in found.items() if value != data[key]}
    return spec.with_({**changed, "steps": steps, "geometry.segments": 1})


def _renamed(data: Any, names: Mapping[str, str], dropped: Collection[str]) -> Any:
    """Plain data with other names for cavities; what is said of dropped ones is left out, and what
    says nothing without them."""
    if isinstance(data, list):
        return [_renamed(item, names, dropped) for item in data]
    if not isinstance(data, dict):
        return names.get(data, data) if isinstance(data, str) else data
    kept = {
        names.get(key, key): _renamed(value, names, dropped)
        for key, value in data.items()
        if key not in dropped
    }
    return {key: value for key, value in kept.items() if value != {} or data.get(key) == {}}


def blocked_modules(free: Spec) -> dict[str, Spec]:
    """The specs of a free module when it is blocked. ``straight``: all turns are held, where
    symmetry leaves any; ``clamped``: the length is held, too."""
    held = _blocked(free)
    turns = {path: value for path, value in held.items() if path.startswith("module.turn")}
    found = {"straight": free.with_(turns)} if turns else {}
    return found | {"clamped": free.with_(held)}


def _of_module(spec: Spec, sheets: Sequence[str]) -> dict[str, Any]:
    """The sheets of a module as plain data: those of the whole without its ends."""
    made_of = spec.model_dump(mode="json", exclude_none=True)["sheets"]
    return {name: made_of[name] for name in sheets}


def _of_inner(spec: Spec, layout: Layout) -> list[dict[str, Any]] | str:
    """The contacts as plain data between what a module of this layout has, too; what the ends of
    the actuator touch is none of its."""
    there = {*layout.surfaces, *layout.sheets} - {layout.clamp, layout.tip}
    found = []
    contacts = spec.model_dump(mode="json", exclude_none=True)["contact"]
    if isinstance(contacts, str):
        return contacts
    for contact in contacts:
        groups = contact.get("between") or [contact["self"]]
        kept = [[name for name in group if name in there] for group in groups]
        if all(kept):
            found.append(contact | ({"between": kept} if len(kept) == 2 else {"self": kept[0]}))
    return found or "none"


def _weightless(spec: Spec) -> list[dict[str, Any]]:
    """The steps as plain data without weight, and without those that change nothing else."""
    steps = spec.model_dump(mode="json", exclude_none=True)["steps"]
    kept = [{k: v for k, v in step.items() if k != "gravity"} for step in steps]
    return [step for step in kept if _changes_something(step)]


def _changes_something(step: Mapping[str, Any]) -> bool:
    """Whether a plain step has a load, supports or a time of its own."""
    return bool({*LOADS, "supports", "duration"} & step.keys())


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

"""The key ``module`` of a spec: two faces of one module of a long chain."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from pydantic import Field

from softact.fields import Fault, Part
from softact.loads.base import surface_fault
from softact.mesh.layout import COMPONENTS, Layout, Repeats, free_components
from softact.nearest import nearest
from softact.units import Angle, Length

# What is refused beside a module: key -> why.
BESIDE = {
    "supports": "a module is held by the means of its left face",
    "obstacles": "an obstacle touches some modules and not others",
    "masses": "a carried mass hangs on one place of a chain",
    "constraints": "a face of a chain keeps no shape of its own",
}
IN_STEPS = {
    "supports": BESIDE["supports"],
    "gravity": "weight makes the modules of a chain unequal (softact module has --no-weight)",
    "payload": "a payload hangs on one place of a chain",
    "torque": "a torque acts on one place of a chain: wrench acts on its cross-sections",
    "obstacles": BESIDE["obstacles"],
}


class ModuleSpec(Part, title="Module"):
    """One module of a long chain: what is meshed goes on at both faces with its like."""

    left: str = Field(description="surface at which the module before ends")
    right: str = Field(description="surface at which the module after begins: the same, moved")
    turn: dict[str, Angle] = Field(
        {}, description="components x, y, z of the right face's turn that are given; others free"
    )
    shift: dict[str, Length] = Field(
        {}, description="the same of its place beside the left face's middle, undeformed the pitch"
    )

    @property
    def repeats(self) -> Repeats:
        """The same for a layout."""
        held = {f"turn_{c}": math.radians(value) for c, value in self.turn.items()}
        return Repeats(
            self.left, self.right, held | {f"shift_{c}": v for c, v in self.shift.items()}
        )


def with_module(layout: Layout, data: Any) -> Layout:
    """The layout with the faces of a spec's plain ``module``, where they are named."""
    faces = data if isinstance(data, dict) else {}
    left, right = faces.get("left"), faces.get("right")
    if not (isinstance(left, str) and isinstance(right, str)):
        return layout
    return replace(layout, clamp=left, tip=right, repeats=Repeats(left, right))


def module_faults(data: dict[str, Any], layout: Layout, chain: bool) -> Iterator[Fault]:
    """Yield what is wrong with the plain ``module`` of a spec, and what cannot stand beside it.
    chain: whether the geometry itself is a module of one."""
    if layout.repeats is None and data.get("module") is None:
        return
    if layout.covers or (layout.sheets and not chain):
        yield (
            ("module",),
            "two curves of sheets are no faces of a module, unless a geometry with module_alone "
            "makes them",
        )
        return
    yield from beside(data)
    module = data.get("module")
    if not isinstance(module, dict):
        return
    for side in ("left", "right"):
        yield from surface_fault(module.get(side), ("module", side), layout)
    if module.get("left") == module.get("right"):
        yield ("module", "right"), "is the left face too; name the opposite one"
    free = dict(zip(COMPONENTS, free_components(layout.symmetry).ravel(), strict=True))
    for kind in ("turn", "shift"):
        for c in module[kind] if isinstance(module.get(kind), dict) else ():
            if f"{kind}_{c}" not in free:
                yield ("module", kind, c), f"there is no component {c!r}; {nearest(str(c), 'xyz')}"
            elif not free[f"{kind}_{c}"]:
                yield ("module", kind, c), "the symmetry planes leave no room for it"


def beside(data: dict[str, Any]) -> Iterator[Fault]:
    """Yield what of a plain spec cannot stand beside a module."""
    for key, why in BESIDE.items():
        if data.get(key) and data[key] != "none":
            yield (key,), f"{why}; leave {key} out beside module"
    yield from _rubbing(data.get("contact"))
    steps = data.get("steps")
    for index, step in enumerate(steps if isinstance(steps, list) else ()):
        for key, why in IN_STEPS.items() if isinstance(step, dict) else ():
            if step.get(key) is not None:
                yield ("steps", index, key), f"{why}; leave {key} out beside module"


def _rubbing(contacts: Any) -> Iterator[Fault]:
    """Yield friction of a spec's plain contacts."""
    for index, contact in enumerate(contacts if isinstance(contacts, list) else ()):
        friction = contact.get("friction") if isinstance(contact, dict) else None
        if friction:
            yield (
                ("contact", index, "friction"),
                "modules touch each other without friction; write 0, or leave it out (softact "
                "module has --no-contact)",
            )

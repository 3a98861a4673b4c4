"""What a spec does with the named surfaces of its geometry, in words and colours."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from softact.materials import Law
from softact.mesh.layout import Layout
from softact.spec import Spec, Step, SupportSpec

HELD, TIP, LOADED, LAYER, TOUCHES = "#2f6db5", "#2a9d5c", "#c2185b", "#7b5ea7", "#5b8a8a"
CAVITIES = ("#e8862e", "#d1495b", "#c9a227", "#b5651d", "#e07a5f", "#8e5ea2")


@dataclass(frozen=True)
class Role:
    """colour: of the first thing that happens with a surface, "" for what has none of its own;
    said: all of them."""

    colour: str
    said: str


def roles(spec: Spec) -> dict[str, Role]:
    """Region, surface, sheet or curve -> what the spec does with it, where it does anything."""
    layout = spec.geometry.layout()
    found: dict[str, list[tuple[str, str]]] = {}
    for name, colour, said in _all(spec, layout):
        found.setdefault(name, []).append((colour, said))
    return {
        name: Role(next((colour for colour, _ in entries if colour), ""), _joined(entries))
        for name, entries in found.items()
    }


def _joined(entries: list[tuple[str, str]]) -> str:
    """What happens with a surface, without what is part of something longer."""
    said = list(dict.fromkeys(text for _, text in entries))
    return "; ".join(a for a in said if not any(b != a and b.startswith(a) for b in said))


def _all(spec: Spec, layout: Layout) -> Iterator[tuple[str, str, str]]:
    for region, law in spec.materials.items():
        yield region, "", f"made of {_material(law)}"
    for sheet, layers in spec.sheets.items():
        plies = " and ".join(f"{p.thickness:g} mm of {_material(p.material)}" for p in layers.plies)
        yield sheet, "", plies
    yield from _held(spec)
    numbers = {name: number for number, name in enumerate(layout.cavities)}
    for step in spec.steps:
        for words, name, said in loads_of(step, layout):
            of = f"{words} {said} in step '{step.name}'"
            if name in numbers:
                for wall in layout.cavities[name]:
                    yield wall, _of_cavity(numbers[name]), f"wall of cavity '{name}': {of}"
            elif name:
                yield name, LOADED, of
    for name, walls in layout.cavities.items():
        for wall in walls:
            yield wall, _of_cavity(numbers[name]), f"wall of cavity '{name}'"
    for layer in spec.layers:
        of = _material(layer.material)
        yield layer.surface, LAYER, f"layer of {of}, {layer.thickness:g} mm"
    for touching in spec.contact or ():
        for group in touching.groups:
            for name in group:
                yield name, TOUCHES, f"may touch (contact '{touching.name}')"
    if layout.tip:
        yield layout.tip, TIP, "the tip, whose motion is measured"


def _material(law: Law) -> str:
    return law.name or f"law {law.law}"


def _of_cavity(number: int) -> str:
    return CAVITIES[number % len(CAVITIES)]


def _held(spec: Spec) -> Iterator[tuple[str, str, str]]:
    for support in spec.supports or ():
        yield support.surface, HELD, _support(support)
    for step in spec.steps:
        for support in step.supports or ():
            yield support.surface, HELD, f"{_support(support)} from step '{step.name}' on"


def _support(support: SupportSpec) -> str:
    said = []
    if support.fix:
        said.append(f"held in {', '.join(support.fix)}")
    said += [f"moved by {value:g} mm along {axis}" for axis, value in support.move.items()]
    if support.turn:
        said.append(f"turned by {support.turn.angle:g}°")
    if support.spring:
        said.append(f"on springs in {', '.join(support.spring)}")
    return ", ".join(said)


def loads_of(step: Step, layout: Layout) -> Iterator[tuple[str, str, str]]:
    """For each load of a step its key in words, what it acts on ("" for the whole), and how much,
    as a spec writes it."""
    known = {*layout.cavities, *layout.surfaces, *layout.sheets, *layout.curves}
    written = step.model_dump(mode="json", exclude_none=True)
    for key in step.loads:
        value, words = written[key], key.replace("_", " ")
        if key == "obstacles":
            for name, change in value.items():
                yield name, "", _changed(change)
        elif not isinstance(value, dict):
            yield words, "", _plain(value)
        elif "surface" in value or not known & set(value):
            yield words, value.pop("surface", None) or layout.tip, _plain(value)
        else:
            for name, amount in value.items():
                yield words, name, _plain(amount)


def _changed(change: dict[str, Any]) -> str:
    """What a step does with an obstacle."""
    said = []
    if "turn" in change:
        said.append(f"turned by {change['turn']['angle']}")
    if "move" in change:
        said.append(f"moved by {_plain(change['move'])}")
    for key, yes, no in (("active", "put there", "removed"), ("held", "held", "let go")):
        if key in change:
            said.append(yes if change[key] else no)
    return ", ".join(said)


def _plain(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(_plain(part) for part in value.values())
    if isinstance(value, list):
        return f"({', '.join(map(_plain, value))})"
    return f"{value:.4g}" if isinstance(value, float) else str(value)

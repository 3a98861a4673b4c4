"""Faults between the parts of a spec, seen on the plain data so that all are told at once."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from softact.bodies import BODIES
from softact.errors import SpecError
from softact.fields import Fault, Place
from softact.geometry.base import Geometry
from softact.loads import LOADS
from softact.loads.base import surface_fault
from softact.loads.pressure_file import read
from softact.materials import Law
from softact.materials.base import FibreLaw
from softact.measures import MEASURES
from softact.measures.titles import title_of, titles
from softact.mesh.layout import Layout
from softact.nearest import likely, nearest
from softact.spec.modules import module_faults, with_module
from softact.units import show

NOWHERE: Any = ()
RUBBER, CLOTH = "ecoflex-00-30", "{plies: [{material: woven-tpu-nylon, thickness: 0.2 mm}]}"


def made_of_regions(regions: Sequence[str]) -> str:
    """An example of the section ``materials`` for the regions of a geometry, to be pasted."""
    return f"materials: {{{', '.join(f'{name}: {RUBBER}' for name in regions)}}}"


def made_of_sheets(sheets: Sequence[str]) -> str:
    """An example of the section ``sheets`` for the sheets of a geometry, to be pasted."""
    first, *others = sheets
    cloth = f"{first}: &cloth {CLOTH}" if others else f"{first}: {CLOTH}"
    return f"sheets: {{{', '.join([cloth, *(f'{name}: *cloth' for name in others)])}}}"


def cross_faults(data: Any, geometry: Geometry | None) -> Iterator[Fault]:
    """Yield (place, what is wrong) for what no part of the spec can see by itself.

    data: the plain data of a spec, of which any part may be malformed. geometry: None where it
    is wrong itself; then the names of surfaces, regions and cavities are not checked.
    """
    if not isinstance(data, dict):
        return
    steps = _mappings(data.get("steps"))
    if data.get("steps") == []:
        yield ("steps",), "no step is given; write for example - {name: inflate, pressure: 50 kPa}"
    yield from _same_names("steps", steps)
    yield from _same_names("contact", _mappings(data.get("contact")))
    yield from _measures(data.get("measures"))
    yield from _tiles(data.get("tiles"), data.get("measures", "all"))
    if geometry is None:
        if "materials" not in data and not data.get("sheets"):
            yield ("materials",), "missing; region -> card, {card:, ...} or {law:, ...}"
        return
    layout = with_module(_with_marks(geometry.layout(), data), data.get("module"))
    yield from module_faults(data, layout, geometry.layout().repeats is not None)
    yield from _marks(data, layout)
    yield from _made_of(data, "materials", "region", layout.regions, made_of_regions)
    yield from _made_of(data, "sheets", "sheet", tuple(layout.sheets), made_of_sheets)
    for index, layer in _mappings(data.get("layers")):
        yield from surface_fault(layer.get("surface"), ("layers", index, "surface"), layout)
    if layout.repeats is not None:
        pass  # the means of a module's left face hold it
    elif data.get("supports") is not None:
        yield from _supports(data["supports"], ("supports",), layout)
    elif not layout.clamp and layout.regions:
        yield from _supports([], ("supports",), layout)
    for key, kind in BODIES.items():
        if kind.annotation is not None and data.get(key) is not None:
            yield from kind.faults(data[key], (key,), layout)
    yield from _obstacles(data.get("obstacles"), layout)
    contacts = [*_mappings(data.get("contact"))]
    for index, contact in contacts:
        yield from _contact(contact, ("contact", index), layout)
    if layout.repeats is None:  # no sheet lies on a module
        yield from _unheld(contacts, layout)
    for index, step in steps:
        yield from _step(step, ("steps", index), layout)
        yield from _known_obstacles(step, ("steps", index), data.get("obstacles"))


def _with_marks(layout: Layout, data: dict[str, Any]) -> Layout:
    """The layout with the names of the points and lines of a spec; their places do not matter."""
    names = {
        key: {name: NOWHERE for name in data[key] if isinstance(name, str)}
        for key in ("points", "lines")
        if isinstance(data.get(key), dict)
    }
    return replace(layout, points=names.get("points", {}), lines=names.get("lines", {}))


def _marks(data: dict[str, Any], layout: Layout) -> Iterator[Fault]:
    """Names that are taken, and surfaces between which no line can be."""
    for key in ("points", "lines"):
        for name in getattr(layout, key):
            taken = name in (*layout.surfaces, *layout.sheets, *layout.curves)
            if taken or (key == "lines" and name in layout.points):
                other = "surface of the geometry" if taken else "point"
                yield (key, name), f"{show(name)} is the name of a {other} too; rename it"
    for name in layout.lines:
        line = data["lines"][name]
        between = line.get("between") if isinstance(line, dict) else None
        for index, surface in enumerate(between if isinstance(between, list) else ()):
            yield from surface_fault(surface, ("lines", name, "between", index), layout)


def _mappings(value: Any) -> list[tuple[int, dict]]:
    if not isinstance(value, list | tuple):
        return []
    return [(i, entry) for i, entry in enumerate(value) if isinstance(entry, dict)]


def _same_names(part: str, steps: list[tuple[int, dict]]) -> Iterator[Fault]:
    first: dict[str, int] = {}
    for index, step in steps:
        name = step.get("name")
        if not isinstance(name, str):
            continue
        if name in first:
            other = f"{part}.{first[name]}"
            yield (part, index, "name"), f"{show(name)} is the name of {other} too; rename one"
        first.setdefault(name, index)


def _measures(value: Any) -> Iterator[Fault]:
    if not isinstance(value, list | tuple):
        return
    for index, name in enumerate(value):
        if isinstance(name, str) and name not in MEASURES:
            titles = [(m, title) for m, entry in MEASURES.items() for title in entry.columns]
            found = next((pair for pair in titles if pair[1].startswith(f"{name}_")), None)
            hint = f"measure {found[0]} has {found[1]}" if found else nearest(name, MEASURES)
            yield ("measures", index), f"there is no measure {show(name)}; {hint}"


def _tiles(value: Any, measures: Any) -> Iterator[Fault]:
    """Tiles that no measure gives, or none of those that are asked for."""
    for index, name in enumerate(value if isinstance(value, list | tuple) else ()):
        if not isinstance(name, str):
            continue
        found = title_of(name)
        if found is None:
            hint = likely(name, (each.title for each in titles()))
            hint = hint or "softact list measures names all"
            yield ("tiles", index), f"no measure has a column {show(name)}; {hint}"
        elif isinstance(measures, list | tuple) and found.measure not in measures:
            text = f"{show(name)} is of measure {found.measure}, which 'measures' leaves out"
            yield ("tiles", index), text


def _made_of(
    data: dict[str, Any],
    part: str,
    kind: str,
    known: Sequence[str],
    example: Callable[[Sequence[str]], str],
) -> Iterator[Fault]:
    """Whether a section names each region or sheet of the geometry, and no other."""
    if known and part not in data:
        named = f"{kind} {known[0]}" if len(known) == 1 else f"{kind}s {', '.join(known)}"
        yield (part,), f"missing; this geometry has the {named}; write: {example(known)}"
    value = data.get(part)
    if not isinstance(value, dict):
        return
    for name in value:
        if name not in known:
            yield (part, name), f"the geometry has no {kind} {show(name)}; {nearest(name, known)}"
    for name in known:
        if name not in value:
            entry = example([name]).partition("{")[2].removesuffix("}")
            yield (part, name), f"missing; write what this {kind} is made of: {entry}"


def fibre_faults(materials: Mapping[str, Law], layout: Layout) -> Iterator[Fault]:
    """Yield what is wrong with the directions of fibres in materials that are valid themselves."""
    for region, law in materials.items():
        if not isinstance(law, FibreLaw):
            continue
        place = ("materials", region)
        if isinstance(law.normal, tuple):
            if not np.any(np.cross(np.array(law.normal), layout.axis)):
                yield (
                    (*place, "normal"),
                    "the actuator's axis, from which the fibre angle counts, is normal to this "
                    "plane; name the normal of a plane that holds the axis",
                )
            for surface, index in layout.symmetry.items():
                if law.normal[index] and sum(map(bool, law.normal)) > 1:
                    yield (
                        (*place, "normal"),
                        f"the plane is oblique to the symmetry plane '{surface}', so fibres in it "
                        "are not symmetric; model the whole actuator or turn the plane",
                    )
        if layout.symmetry and law.families == 1 and law.angle % 90 != 0:
            yield (
                (*place, "families"),
                f"one family at {law.angle:g} deg is not symmetric to {', '.join(layout.symmetry)};"
                " take families: 2, or an angle of 0 or 90 deg, or model the whole actuator",
            )


def _obstacles(value: Any, layout: Layout) -> Iterator[Fault]:
    if not isinstance(value, dict):
        return
    for name, obstacle in value.items():
        surfaces = obstacle.get("surfaces") if isinstance(obstacle, dict) else None
        for index, surface in enumerate(surfaces if isinstance(surfaces, list) else ()):
            yield from _touchable(surface, ("obstacles", name, "surfaces", index), layout)


def _contact(contact: dict, place: Place, layout: Layout) -> Iterator[Fault]:
    """Surfaces in ``self`` and ``between``, each a name or a list of names, at any depth."""

    def names(value: Any, at: Place) -> Iterator[Fault]:
        if isinstance(value, str):
            yield from _touchable(value, at, layout)
        elif isinstance(value, list):
            for index, entry in enumerate(value):
                yield from names(entry, (*at, index))

    for key in ("self", "between"):
        yield from names(contact.get(key), (*place, key))


def _unheld(contacts: list[tuple[int, dict]], layout: Layout) -> Iterator[Fault]:
    """Sheets on a solid that nothing presses on it when the first load begins."""

    def named(value: Any) -> set[str]:
        if isinstance(value, list | tuple):
            return set().union(*map(named, value))
        return {value} if isinstance(value, str) else set()

    for sheet in (name for name in layout.covers if name not in layout.bonded):
        of_sheet = [
            (index, contact)
            for index, contact in contacts
            if sheet in named(contact.get("between")) | named(contact.get("self"))
        ]
        why = f"{show(sheet)} lies on the solid, and nothing else holds it across"
        if not of_sheet:
            example = f"- {{between: [outer, {sheet}], friction: 0.2, distance: 0.005 mm}}"
            yield ("contact",), f"missing; {why}; write {example}"
        elif not any(contact.get("distance") for _, contact in of_sheet):
            place = ("contact", of_sheet[0][0], "distance")
            yield place, f"missing; {why}; write a small interference, for example 0.005 mm"


def _touchable(name: str, place: Place, layout: Layout) -> Iterator[Fault]:
    if layout.repeats and name in (layout.repeats.left, layout.repeats.right):
        yield (
            place,
            f"{show(name)} is a face of the module, inside of the chain; it touches nothing",
        )
    elif name in layout.curves:
        known = ", ".join((*layout.surfaces, *layout.sheets))
        yield place, f"{show(name)} is a curve, which touches nothing; write one of: {known}"
    else:
        yield from surface_fault(name, place, layout)


def _known_obstacles(step: dict, place: Place, known: Any) -> Iterator[Fault]:
    known = known if isinstance(known, dict) else {}
    for name in step["obstacles"] if isinstance(step.get("obstacles"), dict) else ():
        if name not in known:
            hint = nearest(name, known) if known else "the spec has none; write obstacles:"
            yield (*place, "obstacles", name), f"there is no obstacle {show(name)}; {hint}"
        else:
            change = step["obstacles"][name]
            yield from _free_or_not(change, (*place, "obstacles", name), known[name])


def _free_or_not(change: Any, place: Place, obstacle: Any) -> Iterator[Fault]:
    """What a step does with a free body, and cannot; or only with one."""
    if not isinstance(change, dict) or not isinstance(obstacle, dict):
        return
    if "mass" in obstacle:
        for key in ("move", "turn", "active"):
            if key in change:
                fault = "a free body goes where it is pushed; a step may hold it or let it go: held"
                yield (*place, key), fault
    elif "held" in change:
        yield (*place, "held"), "it is no free body, and stays where it is put; give it a mass"


def _step(step: dict, place: Place, layout: Layout) -> Iterator[Fault]:
    for key, load in LOADS.items():
        if step.get(key) is not None:
            yield from load.faults(step[key], (*place, key), layout, step)
    if step.get("supports") is not None:
        yield from _supports(step["supports"], (*place, "supports"), layout)
    yield from _pressures_in_time(step.get("amplitude"), (*place, "amplitude", "file"), layout)


def _pressures_in_time(amplitude: Any, place: Place, layout: Layout) -> Iterator[Fault]:
    name = amplitude.get("file") if isinstance(amplitude, dict) else None
    if isinstance(name, str):
        try:
            table = read(Path(name))
        except SpecError:
            return  # told by the field itself
        yield from ((place, fault) for fault in table.faults(tuple(layout.cavities)))


def _supports(value: Any, place: Place, layout: Layout) -> Iterator[Fault]:
    supports = _mappings(value)
    if not isinstance(value, list | tuple) or len(supports) != len(value):
        return
    held = {"xyz"[index] for index in layout.symmetry.values()}
    seen: set[tuple[str, str]] = set()
    for index, support in supports:
        yield from surface_fault(
            support.get("surface"), (*place, index, "surface"), layout, layout.marks
        )
        components = _components(support)
        yield from _turned(support.get("turn"), (*place, index, "turn", "axis"), layout)
        if place[0] == "steps" and support.get("spring"):
            yield (
                (*place, index, "spring"),
                "springs act from the start; write them under the spec's supports",
            )
        held |= components
        for component in sorted(components):
            entry = (str(support.get("surface")), component)
            if entry in seen:
                fault = f"'{component}' of {show(entry[0])} is held by another support already"
                yield (*place, index), fault
            seen.add(entry)
    for component in sorted(set("xyz") - held):
        clamp = "" if layout.clamp else ", which has no clamp,"
        yield place, f"nothing holds the actuator{clamp} along {component}; fix it on some surface"


def _turned(turn: Any, place: Place, layout: Layout) -> Iterator[Fault]:
    axis = turn.get("axis") if isinstance(turn, dict) else None
    if not isinstance(axis, list | tuple) or len(axis) != 3:
        return
    for plane, normal in layout.symmetry.items():
        for component in range(3):
            if component != normal and axis[component] not in (0, 0.0):
                yield (
                    place,
                    f"a rotation about an axis that is not normal to the symmetry plane '{plane}' "
                    "would turn its mirror image the other way; model the whole actuator",
                )
                return


def _components(support: dict) -> set[str]:
    names: set[str] = set()
    if isinstance(support.get("turn"), dict):
        return set("xyz")
    for key in ("fix", "move", "spring"):
        if isinstance(support.get(key), list | tuple | dict):
            names |= {entry for entry in support[key] if isinstance(entry, str)}
    return names & set("xyz")

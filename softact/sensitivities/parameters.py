"""The numbers of a spec by which its measures are differentiated, and a spec with one changed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from softact.errors import SpecError
from softact.fields import Place
from softact.geometry.base import is_of_mesh
from softact.nearest import nearest
from softact.spec import Spec
from softact.spec.path import joined, single
from softact.units import ACCELERATION, Dimension, conversion, dimension_of, show

#: Parts of a spec that say nothing of the actuator, or only what is asked of it.
NO_PARAMETERS = frozenset({
    "name", "description", "source", "assumptions", "measures", "probes", "points", "lines",
    "safety_factor", "solver", "tolerances", "tiles", "target_line",
})  # fmt: skip
#: Keys anywhere that are no number to be differentiated by, and why.
NO_KEYS = {
    "friction": "with friction a state depends on the way to it, and has no derivative",
    "max_increment": "it says how the solver goes on, and nothing of the actuator",
    "stretch_range": "it is what a test covered, and nothing of the actuator",
    "strength": "the failure pressure follows from the stress: read it off curve.csv",
    "elongation": "the failure pressure follows from the stretch: read it off curve.csv",
}
#: What of a number is a small step, and of what where the number is zero, by internal unit.
SMALL = 1e-5
#: And of what lacks to a Poisson's ratio of ½, towards which the bulk modulus grows without bound.
#: Its inverse, on which the actuator depends almost linearly, changes by as much.
OF_COMPRESSIBILITY = 1e-2
OF_ZERO = {"MPa": 1e-3, "degree": 10.0, "mm/s^2": 1e3, "mm^3": 100.0}


@dataclass(frozen=True)
class Parameter:
    """One number of a spec.

    place: where it stands; value: in internal units, as is ``step``, a small change. unit: in which
    it is told (empty: none), and factor: how many internal units that is. usual: whether it is
    among all that are taken where nobody chooses.
    """

    place: Place
    value: float
    step: float
    unit: str
    factor: float
    usual: bool

    @property
    def path(self) -> str:
        """Its dotted path."""
        return joined(self.place)

    @property
    def told(self) -> float:
        """Its value in the unit in which it is told."""
        return self.value / self.factor

    @property
    def part(self) -> float:
        """The step by the value."""
        return abs(self.step / self.value) if self.value else SMALL

    @property
    def of_geometry(self) -> bool:
        """Whether the places of the mesh depend on it."""
        return self.place[0] == "geometry"


def parameters(spec: Spec) -> list[Parameter]:
    """All numbers of a spec that the equilibria of its actuator depend on smoothly."""
    return [p for place, value, entry in _numbers(spec) if (p := _parameter(place, value, entry))]


def chosen(spec: Spec, paths: Sequence[str]) -> list[Parameter]:
    """The parameters at dotted paths; the usual ones where none are named.

    Raises SpecError with one line for each path that is none.
    """
    known = {p.place: p for p in parameters(spec)}
    if not paths:
        return [p for p in known.values() if p.usual]
    data, found, faults = spec.model_dump(mode="json", exclude_none=True), {}, []
    for path in paths:
        try:
            parameter = at(spec, path, known, data)
            found[parameter.place] = parameter
        except SpecError as error:
            faults += [f"-p {path}: {line}" for line in error.lines]
    if faults:
        raise SpecError(*faults)
    return list(found.values())


def at(spec: Spec, path: str, known: Mapping[Place, Parameter], data: Any) -> Parameter:
    """The parameter at a dotted path. known: all of the spec; data: the spec as plain data.

    Raises SpecError where it is none.
    """
    place, _ = single(data, path)
    if place not in known:
        raise SpecError(_why_not(spec, place, [p.path for p in known.values()]))
    return known[place]


def changed(spec: Any, place: Place, value: float) -> Any:
    """A part of a spec with another number at a place, without any check: it is a small change."""
    if not place:
        return value
    key, rest = place[0], place[1:]
    if isinstance(spec, BaseModel):
        return spec.model_copy(update={str(key): changed(getattr(spec, str(key)), rest, value)})
    if isinstance(spec, dict):
        return {**spec, key: changed(spec[key], rest, value)}
    return tuple(changed(v, rest, value) if i == key else v for i, v in enumerate(spec))


def _numbers(spec: Spec) -> Iterator[tuple[Place, Any, FieldInfo | None]]:
    """Place and value of each number, with the field of the model in which it is."""
    todo: list[tuple[Place, Any, FieldInfo | None]] = [((), spec, None)]
    while todo:
        place, value, entry = todo.pop()
        if isinstance(value, BaseModel):
            fields = type(value).model_fields
            inner: list[tuple[Any, Any, FieldInfo | None]] = [
                (name, getattr(value, name), field) for name, field in fields.items()
            ]
        elif isinstance(value, dict):
            inner = [(key, part, entry) for key, part in value.items()]
        elif isinstance(value, list | tuple):
            inner = [(key, part, entry) for key, part in enumerate(value)]
        else:
            if isinstance(value, float) and not isinstance(value, bool):
                yield place, value, entry
            continue
        todo += [((*place, key), part, field) for key, part, field in reversed(inner)]


def _parameter(place: Place, value: float, entry: FieldInfo | None) -> Parameter | None:
    if place[0] in NO_PARAMETERS or any(key in NO_KEYS for key in place):
        return None
    if is_of_mesh(joined(place)):
        return None
    dimension = ACCELERATION if "gravity" in place else dimension_of(entry)
    unit, factor = _unit(dimension, value)
    internal = dimension.internal if dimension else ""
    there = value != 0.0 or internal == "degree"  # a constant of nought was left out
    usual = there and not {"axis", "normal", "about"} & set(place)
    return Parameter(place, value, _step(place, value, internal), unit, factor, usual)


def _step(place: Place, value: float, internal: str) -> float:
    small = SMALL * (abs(value) or OF_ZERO.get(internal, 1.0))
    if place[-1] != "poissons_ratio":
        return small
    room = OF_COMPRESSIBILITY * (0.5 - value)
    return min(small, room) if room else -small


def _unit(dimension: Dimension | None, value: float) -> tuple[str, float]:
    if dimension is None:
        return "", 1.0
    unit = dimension.format(value).split(maxsplit=1)[1] if value else dimension.shown[0]
    return unit, conversion(unit, dimension.internal)


def _why_not(spec: Spec, place: Place, known: list[str]) -> str:
    """Why what stands at a place of a spec is no parameter."""
    value: Any = spec
    for key in place:
        value = getattr(value, str(key)) if isinstance(value, BaseModel) else value[key]
    for key in place:
        if key in NO_KEYS:
            return NO_KEYS[str(key)]
    if is_of_mesh(joined(place)):
        return "it says how fine the mesh is: softact converge shows what hangs on it"
    if place[0] in NO_PARAMETERS:
        return "it says nothing of the actuator: there is no derivative by it"
    if isinstance(value, bool) or not isinstance(value, int | float):
        return f"{show(value)} is no number; {nearest(joined(place), known)}"
    return f"{show(value)} is a whole number, and has no derivative: softact sweep varies it"

"""Values of a spec that a calibration varies: where they stand, their unit, their bounds."""

from collections.abc import Sequence
from dataclasses import dataclass

from softact.errors import SpecError
from softact.geometry.base import is_of_mesh
from softact.spec import Spec
from softact.spec.path import joined, single
from softact.units import conversion, show, split

WIDEST = 10.0  # default bounds: a tenth and ten times the value of the spec


@dataclass(frozen=True)
class Knob:
    """A value of a spec: its dotted path, and value and bounds in ``unit`` (may be empty)."""

    path: str
    value: float
    unit: str
    low: float
    high: float

    @property
    def size(self) -> float:
        """What a change of the value is compared with."""
        return abs(self.value) or (self.high - self.low) / 2

    def text(self, value: float) -> str:
        """The value as a spec has it."""
        return f"{value:.10g} {self.unit}".strip()


def read_knobs(options: Sequence[str], spec: Spec) -> list[Knob]:
    """Return what ``--vary PATH`` or ``--vary 'PATH=LOW..HIGH'`` names in a spec.

    Raises SpecError with one line per fault; the spec must be valid at all bounds.
    """
    dumped = spec.model_dump(mode="json", exclude_none=True)
    knobs, faults = [], []
    for option in options:
        try:
            knobs.append(_knob(option, dumped))
            _check(knobs[-1], spec)
        except SpecError as error:
            faults += [f"--vary {show(option)[1:-1]}: {line}" for line in error.lines]
    paths = [knob.path for knob in knobs]
    faults += [
        f"--vary {path}: given twice" for path in sorted(set(paths)) if paths.count(path) > 1
    ]
    if faults:
        raise SpecError(*faults)
    return knobs


def _knob(option: str, dumped: dict[str, object]) -> Knob:
    path, equals, bounds = option.partition("=")
    if is_of_mesh(path):
        raise SpecError(
            "says how fine the mesh is: fitted, it would make up for errors of the model; "
            "'softact converge' finds a mesh"
        )
    place, written = single(dumped, path)
    value, unit = _split(written)
    if not equals:
        if value == 0.0:
            raise SpecError("is 0 in the spec; give bounds, such as PATH='-0.01 MPa..0.05 MPa'")
        low, high = sorted((value / WIDEST, value * WIDEST))
        return Knob(joined(place), value, unit, low, high)
    ends = bounds.split("..")
    if len(ends) != 2:
        raise SpecError(f"{show(bounds)} are no bounds; write LOW..HIGH, each with its unit")
    low, high = (_in_unit(end, unit) for end in ends)
    if not low < high:
        raise SpecError(f"the lower bound {low:g} is not below the upper one {high:g}")
    if not low <= value <= high:
        raise SpecError(f"the spec's own value {value:g} {unit} is not between the bounds")
    return Knob(joined(place), value, unit, low, high)


def _split(value: object) -> tuple[float, str]:
    """'0.11 MPa' -> (0.11, 'MPa'). Raises SpecError for what cannot be varied steadily."""
    if isinstance(value, float):
        return value, ""
    parts = split(value) if isinstance(value, str) else None
    if parts is None:
        raise SpecError(f"{show(value)} is no value that can be varied; only sizes with a unit are")
    return float(parts[0]), parts[1]


def _in_unit(text: str, unit: str) -> float:
    parts = split(text)
    if parts is None:
        raise SpecError(f"{show(text)} is no bound; write a number with its unit")
    number, written = float(parts[0]), parts[1]
    if not unit or written == unit:
        if written != unit:
            raise SpecError(f"{show(text)}: a number without unit is wanted")
        return number
    try:
        return number * conversion(written, unit)
    except ValueError as error:
        raise SpecError(f"{show(text)}: {error}") from None


def _check(knob: Knob, spec: Spec) -> None:
    for value in (knob.low, knob.high):
        try:
            turned(spec, [knob], [value])
        except SpecError as error:
            raise SpecError(*(f"at the bound {line}" for line in error.lines)) from None


def turned(spec: Spec, knobs: Sequence[Knob], values: Sequence[float]) -> Spec:
    """Return the spec with the knobs turned to ``values``."""
    return spec.with_(
        {knob.path: knob.text(value) for knob, value in zip(knobs, values, strict=True)}
    )

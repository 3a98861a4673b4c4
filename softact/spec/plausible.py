"""Values that are right in form and look wrong in size: most are a unit wrong, none is refused.

``RANGES`` says what soft actuators and their materials span, each with what spans it. A range is
wide: it is there to find a value that is a thousand times too large, not to judge a design.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from softact.files.document import Document, Place, dotted
from softact.geometry.base import Geometry
from softact.loads.several import placed
from softact.materials import Law, compressible
from softact.materials.base import FibreLaw
from softact.materials.laws.linear import Linear
from softact.units import (
    ACCELERATION,
    DENSITY,
    FORCE,
    LENGTH,
    MOMENT,
    PRESSURE,
    STIFFNESS,
    VOLUME,
    Dimension,
    conversion,
    dimension_of,
)

if TYPE_CHECKING:
    from softact.contact.obstacles import SpecObstacle
    from softact.spec.films import LayerSpec, PlySpec
    from softact.spec.models import Spec, Step
    from softact.spec.supports import SupportSpec

Oddity = tuple[Place, str]


@dataclass(frozen=True)
class Range:
    """What values of one kind span. low, high: in internal units; evidence: what lies there.

    dimension: None of a bare number.
    """

    what: str
    low: float
    high: float
    dimension: Dimension | None
    evidence: str

    def text(self, value: float) -> str:
        """A value as people write it, to four digits."""
        if self.dimension is None:
            return f"{value:.4g}"
        units = (*self.dimension.shown, *_SMALLER.get(self.dimension.internal, ()))
        texts = {unit: value / conversion(unit, self.dimension.internal) for unit in units}
        unit = min(units, key=lambda unit: _unhandy(texts[unit]))
        return f"{texts[unit]:.4g} {unit}"

    def holds(self, value: float) -> bool:
        """Whether a value lies in the range."""
        return self.low <= value <= self.high

    def oddity(self, value: float, name: str = "") -> str | None:
        """What to say of a value outside, with the power of ten that would bring it in.

        name: what the value is, where the spec has another one at that place.
        """
        if self.holds(value):
            return None
        given = f"{name} {self.text(value)}" if name else self.text(value)
        where = "above" if value > self.high else "below"
        span = f"{self.text(self.low)} to {self.text(self.high)}"
        return f"{given} is {where} what is usual for {self.what}, {span}{self._unit_wrong(value)}"

    def _unit_wrong(self, value: float) -> str:
        if self.dimension is None:
            return ""
        for factor, words in ((1e3, "1000"), (1e6, "a million"), (1e9, "a billion")):
            if self.holds(value / factor if value > self.high else value * factor):
                times = "smaller" if value > self.high else "larger"
                return f"; {words} times {times} it would be: is the unit right?"
        return ""


_SMALLER = {"mm": ("um",)}  # what a spec is not written back in


def _unhandy(number: float) -> float:
    """How far a number is from those that people read at a glance, 0.1 to 1000."""
    if number == 0 or 0.1 <= abs(number) < 1000:
        return 0.0
    return abs(math.log10(abs(number)) - 1)


RANGES = {
    "length": Range(
        "the length of an actuator", 1.0, 5e3, LENGTH,
        "micro bellows of some mm to arms of fabric of some m",
    ),
    "wall": Range(
        "the walls of actuators", 0.02, 100.0, LENGTH,
        "spin-coated PDMS of 20 µm to solid ends of large arms",
    ),
    "size": Range(
        "the sizes of an actuator's parts", 0.01, 5e3, LENGTH,
        "channels of micro actuators to arms of fabric",
    ),
    "film": Range(
        "the thickness of layers and plies", 1e-3, 5.0, LENGTH,
        "parylene of 1 µm to felt; paper 0.1 mm, knit 0.5 mm",
    ),
    "rubber": Range(
        "rubber-like materials", 5e-4, 100.0, PRESSURE,
        "gels of 0.5 kPa, Ecoflex 6 to 30 kPa, NinjaFlex 5 MPa, stiff thermoplastic elastomers",
    ),
    "solid": Range(
        "solids", 1e-3, 3e5, PRESSURE,
        "gels of 1 kPa to steel of 210 GPa",
    ),
    "softest": Range(
        "the softest solid of an actuator", 0.0, 1e4, PRESSURE,
        "bellows are of rubber or plastic, with shear moduli to 1 GPa; a metal hardly moves",
    ),
    "sheet": Range(
        "films and fabrics", 0.01, 4e5, PRESSURE,
        "films of silicone; knit 6 MPa, coated nylon 500 MPa, paper 6.5 GPa, carbon fibre 230 GPa",
    ),
    "fibres": Range(
        "families of fibres", 1e-4, 2e5, PRESSURE,
        "knit 0.1 MPa, a winding of Kevlar 176 MPa, solid carbon fibre",
    ),
    "strength": Range(
        "the strength of materials", 0.01, 7e3, PRESSURE,
        "gels of 10 kPa, silicones of 1 to 10 MPa, carbon fibre of 7 GPa",
    ),
    "density": Range(
        "the density of materials", 5e-11, 9e-9, DENSITY,
        "foams of 50 kg/m³, silicones 1000 to 1300, glass 2500, brass 8700",
    ),
    "rubber_poisson": Range(
        "rubber-like materials", 0.3, 0.5, None,
        "foamed silicone 0.3; elastomers 0.48 to 0.4999",
    ),
    "poisson": Range(
        "films, fabrics and plastics", 0.0, 0.5, None,
        "cork 0, paper 0.2, plastics 0.35, rubber 0.5; below zero only lattices made for it",
    ),
    "pressure": Range(
        "the pressure of actuators", 3e-4, 5.0, PRESSURE,
        "balloons of Ecoflex 0.5 kPa, PneuNets 20 to 70 kPa, fabrics 200 kPa, muscles 800 kPa, "
        "hydraulics 2 MPa",
    ),
    "vacuum": Range(
        "a vacuum", 3e-4, 0.101325, PRESSURE,
        "nothing is more than 101.325 kPa below the ambient",
    ),
    "traction": Range(
        "forces per area on soft bodies", 1e-6, 50.0, PRESSURE, "a touch to the strength of rubber"
    ),
    "force": Range("forces on soft actuators", 1e-6, 1e4, FORCE, "a grain of sand to a tonne"),
    "moment": Range("moments on soft actuators", 1e-6, 1e6, MOMENT, "a grain of sand to a wrench"),
    "spring": Range("springs", 1e-6, 1e6, STIFFNESS, "a hair to a machine"),
    "volume": Range(
        "volumes that are injected", 1e-3, 1e8, VOLUME, "micro actuators of nl to cushions of 100 l"
    ),
    "gravity": Range(
        "accelerations", 98.1, 9e4, ACCELERATION, "a hundredth of g to what fast arms reach"
    ),
    "motion": Range(
        "prescribed motions", 1e-6, 5e3, LENGTH, "nm to an arm's length"
    ),
    "friction": Range(
        "coefficients of friction", 0.0, 3.0, None, "oil 0.05, film on silicone 0.2, skin 2"
    ),
    "distance": Range(
        "distances of contact", 1e-5, 5.0, LENGTH, "interferences of some µm to thick fabrics"
    ),
    "place": Range(
        "where obstacles are", 0.0, 1e4, LENGTH, "at the actuator to the other end of a room"
    ),
    "obstacle": Range(
        "sizes of obstacles", 0.01, 1e4, LENGTH, "a hair to the floor of a room"
    ),
}  # fmt: skip

_WALL = re.compile(r"wall|roof|floor|sleeve|thickness")


def lines(spec: Spec, source: Document | None = None) -> list[str]:
    """A line for each odd value of a spec; with ``source`` each begins with its file and line."""
    found = []
    for place, text in oddities(spec):
        where = f"{source.where(place)}: " if source is not None else ""
        found.append(f"{where}{dotted(place)}: {text}")
    return found


def oddities(spec: Spec) -> Iterator[Oddity]:
    """Place and words of each value of a spec that looks odd."""
    yield from _geometry(spec.geometry)
    yield from _materials(spec)
    for i, layer in enumerate(spec.layers):
        yield from _film(layer, ("layers", i))
    for name, sheet in spec.sheets.items():
        for i, ply in enumerate(sheet.plies):
            yield from _film(ply, ("sheets", name, "plies", i))
    yield from _supports(spec.supports, ("supports",))
    for name, obstacle in spec.obstacles.items():
        yield from _obstacle(obstacle, ("obstacles", name))
    for i, contact in enumerate(spec.contact or ()):
        yield from _say("friction", contact.friction, ("contact", i, "friction"))
        yield from _size("distance", contact.distance, ("contact", i, "distance"))
    for i, step in enumerate(spec.steps):
        yield from _step(step, ("steps", i))


def _say(kind: str, value: float, place: Place, name: str = "") -> Iterator[Oddity]:
    if text := RANGES[kind].oddity(value, name):
        yield place, text


def _size(kind: str, value: float | None, place: Place) -> Iterator[Oddity]:
    """Of a value that may be zero, and may have either sign."""
    if value:
        yield from _say(kind, abs(value), place)


def _geometry(geometry: Geometry) -> Iterator[Oddity]:
    for name, field in type(geometry).model_fields.items():
        value = getattr(geometry, name)
        if value and dimension_of(field) is LENGTH:  # a fillet may be 0 mm: there is none
            kind = "wall" if _WALL.search(name) else "size"
            for index, length in enumerate(value if isinstance(value, tuple) else (value,)):
                place = (name, index) if isinstance(value, tuple) else (name,)
                yield from _say(kind, length, ("geometry", *place))
    if length := geometry.layout().length:  # of an imported part nobody knows it
        own = ("length",) if "length" in type(geometry).model_fields else ()
        yield from _say("length", length, ("geometry", *own), "the length")


def _materials(spec: Spec) -> Iterator[Oddity]:
    softest = math.inf
    for region, law in spec.materials.items():
        place, mu = ("materials", region), law.shear_modulus
        softest = min(softest, mu)
        if isinstance(law, Linear):
            yield from _say("solid", law.youngs_modulus, (*place, "youngs_modulus"))
        else:
            yield from _say("rubber", mu, place, "an initial shear modulus of")
        yield from ((place, text) for text in compressible.remarks(law))
        yield from _law(law, place)
    if all(isinstance(law, Linear) for law in spec.materials.values()) and spec.materials:
        yield from _say("softest", softest, ("materials",), "a shear modulus of")


def _law(law: Law, place: Place) -> Iterator[Oddity]:
    """What every material has, in a solid or in a film."""
    kind = "poisson" if isinstance(law, Linear) else "rubber_poisson"
    ratio = law.poissons_ratio
    if ratio is None:
        mu, bulk = law.shear_modulus, law.initial_bulk_modulus
        ratio = (3 * bulk - 2 * mu) / (6 * bulk + 2 * mu)
    yield from _say(kind, ratio, place, "a Poisson's ratio of")
    yield from _say("density", law.density, (*place, "density"))
    if law.strength is not None:
        yield from _say("strength", law.strength, (*place, "strength"))
    if isinstance(law, FibreLaw):
        yield from _size("fibres", law.k1, (*place, "k1"))


def _film(film: LayerSpec | PlySpec, place: Place) -> Iterator[Oddity]:
    """A layer or a ply."""
    law, inside = film.material, (*place, "material")
    yield from _say("film", film.thickness, (*place, "thickness"))
    modulus = law.youngs_modulus if isinstance(law, Linear) else 3 * law.shear_modulus
    yield from _say("sheet", modulus, inside, "a Young's modulus of")
    yield from _law(law, inside)


def _supports(supports: Sequence[SupportSpec] | None, place: Place) -> Iterator[Oddity]:
    for i, support in enumerate(supports or ()):
        for component, value in support.move.items():
            yield from _size("motion", value, (*place, i, "move", component))
        for component, value in (support.spring or {}).items():
            yield from _size("spring", value, (*place, i, "spring", component))


def _obstacle(obstacle: SpecObstacle, place: Place) -> Iterator[Oddity]:
    yield from _say("friction", obstacle.friction, (*place, "friction"))
    for name in ("radius", "length"):
        yield from _size("obstacle", getattr(obstacle, name, None), (*place, name))
    for name in ("center", "point"):
        for i, coordinate in enumerate(getattr(obstacle, name, None) or ()):
            yield from _size("place", coordinate, (*place, name, i))
    for i, edge in enumerate(getattr(obstacle, "size", ())):
        yield from _size("obstacle", edge, (*place, "size", i))


# Kind of range, key of a step, and the vector in it.
DEAD = (
    ("traction", "traction", "value"),
    ("force", "payload", "force"),
    ("moment", "torque", "moment"),
)


def _step(step: Step, place: Place) -> Iterator[Oddity]:
    for cavity, value in (step.pressure or {}).items():
        kind = "pressure" if value > 0 else "vacuum"
        yield from _size(kind, value, (*place, "pressure", cavity))
    for cavity, value in (step.inject or {}).items():
        yield from _size("volume", value, (*place, "inject", cavity))
    for surface, value in (step.surface_pressure or {}).items():
        yield from _size("pressure", value, (*place, "surface_pressure", surface))
    if step.gravity is not None:
        yield from _size("gravity", math.hypot(*step.gravity), (*place, "gravity"))
    for kind, key, name in DEAD:
        for load, at in placed(getattr(step, key), (*place, key)):
            yield from _size(kind, math.hypot(*getattr(load, name)), at)
    yield from _supports(step.supports, (*place, "supports"))
    for name, change in (step.obstacles or {}).items():
        for i, value in enumerate(change.move or ()):
            yield from _size("motion", value, (*place, "obstacles", name, "move", i))

"""What a STEP file (ISO 10303-21) says of its solids and faces, which gmsh reads for products only.

A CAD program writes the name of a face into its ADVANCED_FACE, that of a solid into its
MANIFOLD_SOLID_BREP or BREP_WITH_VOIDS; where the solid has none, the name of its PRODUCT counts.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

from softact.errors import MeshError

ENTITY = re.compile(r"#(\d+)\s*=\s*([A-Z0-9_]*)\s*\(")
# What may hold a semicolon that ends nothing, and the semicolon.
TOKEN = re.compile(r"'(?:[^']|'')*'|/\*.*?\*/|;", re.DOTALL)
COMMENT = re.compile(r"('(?:[^']|'')*')|/\*.*?\*/", re.DOTALL)
STRING = re.compile(r"'((?:[^']|'')*)'")
REFERENCE = re.compile(r"#(\d+)")
# Letters beyond ASCII in a string: \X\E4, \X2\00E400DF\X0\, \X4\...\X0\, \S\d; \P sets a code page.
ENCODED = re.compile(
    r"\\X([24])\\([0-9A-F]*)\\X0\\|\\X\\([0-9A-F]{2})|\\S\\(.)|\\P[A-I]\\|\\(\\)", re.DOTALL
)
SOLIDS = ("MANIFOLD_SOLID_BREP", "BREP_WITH_VOIDS")
SHELLS = ("CLOSED_SHELL", "OPEN_SHELL", "ORIENTED_CLOSED_SHELL")
NAMELESS = ("", "NONE")  # what programs write where there is no name
# Units of length in mm; those of a STEP file by their prefix to the metre.
PREFIXES = {"MICRO": 1e-3, "MILLI": 1.0, "CENTI": 10.0, "DECI": 100.0, "": 1e3, "KILO": 1e6}
UNITS = {"um": 1e-3, "mm": 1.0, "cm": 10.0, "in": 25.4, "ft": 304.8, "m": 1e3, "km": 1e6}
RELATION = "SHAPE_REPRESENTATION_RELATIONSHIP"


@dataclass(frozen=True)
class Face:
    """A face of a solid: its name and the corners (vertices) of its bounds in the file's unit."""

    name: str
    corners: frozenset[tuple[float, ...]]


@dataclass(frozen=True)
class Body:
    """A solid: its name, its faces in the order of the file, those of voids last, and the name of
    its product."""

    name: str
    faces: tuple[Face, ...]
    product: str = ""


class StepFile:
    """The entities of a STEP file's data section: number -> type and text of the arguments.

    An entity of several types has the type "" and all of them in its text. Raises MeshError where
    there is no data section; what is missing or malformed in it is left out.
    """

    def __init__(self, text: str):
        start = re.search(r"\bDATA\s*(\([^;]*\))?\s*;", text)
        if not start:
            raise MeshError("this is no STEP file: it has no DATA section")
        self.entities = {}
        for statement in _statements(text[start.end() :]):
            if found := ENTITY.match(statement):
                self.entities[int(found[1])] = found[2], statement[found.end() : -1]

    def kinds(self, *kinds: str) -> list[int]:
        """Numbers of the entities of some types, in the order of the file."""
        return [number for number, (kind, _) in self.entities.items() if kind in kinds]

    def name(self, number: int) -> str:
        """The first string of an entity, its name; "" where it has none."""
        found = STRING.match(self._entity(number)[1].lstrip())
        name = decoded(found[1]).strip() if found else ""
        return "" if name in NAMELESS else name

    def references(self, number: int) -> list[int]:
        """The entities that one refers to, in order."""
        return [int(n) for n in REFERENCE.findall(STRING.sub("", self._entity(number)[1]))]

    def bodies(self) -> list[Body]:
        """All solids, in the order of the file."""
        return [
            Body(
                self.name(number) or self._products.get(number, ""),
                tuple(face for shell in self.references(number) for face in self._faces(shell)),
                self._products.get(number, ""),
            )
            for number in self.kinds(*SOLIDS)
        ]

    def units(self) -> list[str]:
        """The units of length that the file names, 'mm' or 'in' or '25.1 mm'; each once."""
        found: dict[str, None] = {}
        for _, text in self.entities.values():
            if "LENGTH_UNIT" not in text or "GLOBAL_UNIT" in text:
                continue
            size = self._size(text)
            if size and not self._is_base_of_another(text):
                found[unit_name(size)] = None
        return list(found)

    def _size(self, text: str) -> float | None:
        """A unit of length in mm."""
        if si := re.search(r"SI_UNIT\s*\(\s*(?:\.(\w+)\.|\$)\s*,\s*\.METRE\.", text):
            return PREFIXES.get(si[1] or "")
        if "CONVERSION_BASED_UNIT" not in text:
            return None
        for number in REFERENCE.findall(text):
            inner = self._entity(int(number))[1]
            measure = re.search(r"LENGTH_MEASURE\s*\(\s*([-+.\dEe]+)\s*\)", inner)
            bases = [self._size(self._entity(n)[1]) for n in self.references(int(number))]
            if measure and bases and bases[0]:
                return _number(measure[1]) * bases[0]
        return None

    def _is_base_of_another(self, text: str) -> bool:
        """Whether a unit only says how long an inch is."""
        return any(self._entity(base)[1] == text for base in self._bases)

    @cached_property
    def _bases(self) -> set[int]:
        measures = self.kinds("LENGTH_MEASURE_WITH_UNIT")
        return {reference for number in measures for reference in self.references(number)}

    @cached_property
    def _products(self) -> dict[int, str]:
        """Solid -> name of its product, by way of the representation that holds it."""
        same: dict[int, list[int]] = {}  # representations of one shape
        for number, (kind, text) in self.entities.items():
            if kind == RELATION or (not kind and RELATION in text):
                a, b = (*self.references(number), 0, 0)[:2]
                if "REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION" not in text:
                    same.setdefault(a, []).append(b)
                    same.setdefault(b, []).append(a)
        product: dict[int, str] = {}
        for number in self.kinds("SHAPE_DEFINITION_REPRESENTATION"):
            definition, representation = (*self.references(number), 0, 0)[:2]
            for _ in range(3):  # definition's shape -> definition -> formation -> product
                definition = (*self.references(definition), 0)[0]
            if self._entity(definition)[0] == "PRODUCT":
                for one in (representation, *same.get(representation, ())):
                    product.setdefault(one, self.name(definition))
        return {
            item: name
            for representation, name in product.items()
            for item in self.references(representation)
            if self._entity(item)[0] in SOLIDS
        }

    def _entity(self, number: int) -> tuple[str, str]:
        return self.entities.get(number, ("", ""))

    def _faces(self, shell: int) -> Iterator[Face]:
        kind = self._entity(shell)[0]
        for number in self.references(shell):
            inner = self._entity(number)[0]
            if kind == "ORIENTED_CLOSED_SHELL" and inner in SHELLS[:2]:
                yield from self._faces(number)
            elif inner == "ADVANCED_FACE":
                places = map(self._place, self._corners(number))
                yield Face(self.name(number), frozenset(place for place in places if place))

    def _place(self, vertex: int) -> tuple[float, ...]:
        point = (*self.references(vertex), 0)[0]
        numbers = STRING.sub("", self._entity(point)[1])
        return tuple(_number(n) for n in re.findall(r"[-+.\dEe]+", numbers))

    def _corners(self, face: int) -> set[int]:
        corners: set[int] = set()
        for bound in self.references(face)[:-1]:  # the last is the face's surface
            for loop in self.references(bound):
                for oriented in self.references(loop):
                    for edge in self.references(oriented):
                        if self._entity(edge)[0] == "EDGE_CURVE":
                            corners.update(self.references(edge)[:2])
        return corners


def unit_name(size: float) -> str:
    """The name of a unit of length of some mm."""
    for name, known in UNITS.items():
        if abs(size - known) < 1e-4 * known:
            return name
    return f"{size:g} mm"


def decoded(text: str) -> str:
    """A string of a STEP file as it is meant (ISO 10303-21, 6.4.3)."""

    def letter(found: re.Match[str]) -> str:
        if found[1]:
            width = 2 * int(found[1])
            stops = range(0, len(found[2]) + 1, width)
            codes = [int(found[2][a:b], 16) for a, b in pairwise(stops)]
            return "".join(chr(code) for code in codes if code < 0x110000)
        if found[3]:
            return chr(int(found[3], 16))
        if found[4]:
            return chr((ord(found[4]) + 128) % 256)
        return found[5] or ""

    return ENCODED.sub(letter, re.sub(r"[\r\n]", "", text).replace("''", "'"))


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")


def _statements(text: str) -> Iterator[str]:
    """Statements of a data section without the semicolons and comments."""
    start = 0
    for token in TOKEN.finditer(text):
        if token[0] == ";":
            yield COMMENT.sub(lambda found: found[1] or " ", text[start : token.start()]).strip()
            start = token.end()

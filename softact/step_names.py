"""Names of solids and faces in a STEP file (ISO 10303-21), which gmsh reads for products only.

A CAD program writes the name of a face into its ADVANCED_FACE, that of a solid into its
MANIFOLD_SOLID_BREP or BREP_WITH_VOIDS; where the solid has none, its PRODUCT's counts. OCC keeps
the order of the file, and the corners of each face say whether it did.
"""

import re
from dataclasses import dataclass

from softact.errors import MeshError

ENTITY = re.compile(r"#(\d+)\s*=\s*([A-Z0-9_]+)\s*\(")
STRING = re.compile(r"'((?:[^']|'')*)'")
REFERENCE = re.compile(r"#(\d+)")
SOLIDS = ("MANIFOLD_SOLID_BREP", "BREP_WITH_VOIDS")
SHELLS = ("CLOSED_SHELL", "OPEN_SHELL", "ORIENTED_CLOSED_SHELL")


@dataclass(frozen=True)
class Face:
    """A face of a solid: its name and the corners (vertices) of its bounds in the file's unit."""

    name: str
    corners: frozenset[tuple[float, ...]]


@dataclass(frozen=True)
class Body:
    """A solid: its name and its faces in the order of the file, those of voids last."""

    name: str
    faces: tuple[Face, ...]


class StepFile:
    """The entities of a STEP file's data section: number -> type and text of the arguments."""

    def __init__(self, text: str):
        start = text.find("DATA;")
        if start < 0:
            raise MeshError("this is no STEP file: it has no DATA section")
        self.entities = {}
        for statement in _statements(text[start + 5 :]):
            if found := ENTITY.match(statement):
                self.entities[int(found[1])] = found[2], statement[found.end() : -1]

    def kinds(self, *kinds: str) -> list[int]:
        """Numbers of the entities of some types, in the order of the file."""
        return [number for number, (kind, _) in self.entities.items() if kind in kinds]

    def name(self, number: int) -> str:
        """The first string of an entity, its name."""
        found = STRING.match(self.entities[number][1].lstrip())
        return found[1].replace("''", "'").strip() if found else ""

    def references(self, number: int) -> list[int]:
        """The entities that one refers to, in order."""
        return [int(n) for n in REFERENCE.findall(STRING.sub("", self.entities[number][1]))]

    def bodies(self) -> list[Body]:
        """All solids, in the order of the file."""
        products = [self.name(number) for number in self.kinds("PRODUCT")]
        solids = self.kinds(*SOLIDS)
        found = []
        for position, number in enumerate(solids):
            name = self.name(number)
            if not name and len(products) == len(solids):
                name = products[position]
            faces = [face for shell in self.references(number) for face in self._faces(shell)]
            found.append(Body(name, tuple(faces)))
        return found

    def _faces(self, shell: int):
        kind = self.entities[shell][0]
        for number in self.references(shell):
            inner = self.entities.get(number, ("", ""))[0]
            if kind == "ORIENTED_CLOSED_SHELL" and inner in SHELLS:
                yield from self._faces(number)
            elif inner == "ADVANCED_FACE":
                yield Face(self.name(number), frozenset(map(self._place, self._corners(number))))

    def _place(self, vertex: int) -> tuple[float, ...]:
        point = self.references(vertex)[0]
        numbers = STRING.sub("", self.entities[point][1])
        return tuple(float(n) for n in re.findall(r"[-+.\dEe]+", numbers))

    def _corners(self, face: int) -> set[int]:
        corners: set[int] = set()
        for bound in self.references(face)[:-1]:  # the last is the face's surface
            for loop in self.references(bound):
                for oriented in self.references(loop):
                    for edge in self.references(oriented):
                        if self.entities[edge][0] == "EDGE_CURVE":
                            corners.update(self.references(edge)[:2])
        return corners


def _statements(text: str):
    """Statements of a data section without the semicolons; strings may hold semicolons."""
    start, quoted = 0, False
    for position, letter in enumerate(text):
        if letter == "'":
            quoted = not quoted
        elif letter == ";" and not quoted:
            yield text[start:position].strip()
            start = position + 1

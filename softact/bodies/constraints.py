"""Faces that keep their shape while they move freely: those of plates on a soft body.

``rigid``: glued to a rigid plate that moves and turns. ``plane``: pressed on a plate without
friction, that moves and turns; points slide along it. ``parallel``: the same, of a plate that does
not turn. A few nodes of the face, its masters, span it; the others follow them as an affine map
does (``rigid``), or stay in their plane. Bars between the masters of a rigid face keep their
distances. Where a half is meshed, the mirror images of the masters belong to the face too.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from pydantic import Field

from softact.bodies.base import BodyKind
from softact.bodies.face_nodes import FaceNodes
from softact.bodies.ties import Follow, Height, Length, Tie
from softact.errors import SpecError
from softact.fields import Fault, Part, Place
from softact.loads.base import surface_fault
from softact.mesh.layout import Layout

if TYPE_CHECKING:
    from softact.model import Model
    from softact.system.term import Term

# Stiffness of the ties of a face, by that of the body, μ V^⅔ by its size. A strain ε of the body
# deforms a face by some 1e-4 ε of its size: 1.1e-4 mm of 4 mm at a strain of 0.3 between rubbers of
# 0.1 and 0.3 MPa (tests/bodies/test_constraints.py). With 1e6 the rounding of the linear solves
# came near to the solver's tolerance under small loads.
STIFFNESS = 1e5
IDENTITY = np.eye(3)


class Constraint(Part):
    """A face that keeps its shape while it moves freely, as loads and supports let it."""

    surface: str = Field(description="surface of the geometry")
    stays: Literal["rigid", "plane", "parallel"] = Field(
        description="rigid: as if glued to a rigid plate; plane: on such a plate without friction; "
        "parallel: the same, and the plate does not turn"
    )


class ConstrainedFace:
    """A constraint as a body beside the others: its energy is none of the actuator's."""

    elastic: Sequence[Term] = ()
    slowness, slackens, smooth, stiffness = 0.0, False, True, 0.0

    def __init__(self, model: Model, made_of: Constraint, place: str):
        self.made_of, self._place = made_of, place
        most = 1 if made_of.stays == "parallel" else 4
        self._model, self._face = model, FaceNodes(model, made_of.surface, most)
        self._terms: Sequence[Term] | None = None
        if self._normal is None and made_of.stays != "rigid":
            raise SpecError(
                f"{place}: the surface '{made_of.surface}' is not flat; only stays: rigid keeps it"
            )

    @property
    def external(self) -> Sequence[Term]:
        """See ``Body``; made when the stiffness of all bodies is known."""
        if self._terms is None:
            bodies = max(body.stiffness for body in self._model.bodies)
            self._terms = self._tie(STIFFNESS * bodies / self._model.diagonal)
        return self._terms

    @property
    def _normal(self) -> np.ndarray | None:
        """Normal of a flat face, times the area that its masters span; None: it is not flat."""
        if len(self._face.spanning) != 3:
            return None
        first, *others = self._face.spanning
        return np.cross(*(other - first for other in others))

    def _tie(self, stiffness: float) -> list[Term]:
        face = self._face
        each = stiffness / face.count
        normal = self._normal
        if self.made_of.stays == "rigid":
            return [Follow(face, each, face.shares(), IDENTITY), *self._bars(stiffness)]
        assert normal is not None  # or it was refused
        area = float(np.linalg.norm(normal))
        if self.made_of.stays == "parallel":
            along = np.outer(normal, normal) / area**2
            return [Follow(face, each, np.ones((len(face.followers), 1)), along)]
        return self._plane(each, stiffness, area)

    def _bars(self, stiffness: float) -> list[Term]:
        """Between the masters, and from them to the mirror images of all."""
        count = len(self._face.masters)
        pairs = [(i, j, IDENTITY) for i, j in itertools.combinations(range(count), 2)]
        for mirror in self._mirrors:
            pairs += [(i, j, mirror) for i in range(count) for j in range(i + 1)]
        maps = np.zeros((len(pairs), 1, count, 3, 3))
        for bar, (i, j, image) in zip(maps[:, 0], pairs, strict=True):
            bar[i] += IDENTITY
            bar[j] -= image
        edges = np.einsum("nrmab,mb->nra", maps, self._face.masters)
        lengths = np.linalg.norm(edges[:, 0], axis=1)
        has = lengths > 1e-6 * self._face.size  # a master in the symmetry plane is its own image
        return [Tie(self._face, stiffness, Length(lengths[has]), maps[has])]

    def _plane(self, each: float, stiffness: float, area: float) -> list[Term]:
        face, form = self._face, Height(area)
        spanned = np.zeros((1, 3, 3, 3, 3))  # x₂ − x₁, x₃ − x₁, and −x₁ + what is added
        spanned[0, :, 0] = -IDENTITY
        spanned[0, 0, 1] = spanned[0, 1, 2] = IDENTITY
        ties: list[Term] = [Tie(face, each, form, spanned, follow=True)]
        images = [(i, mirror) for mirror in self._mirrors for i in range(3)]
        if images:
            maps = np.repeat(spanned, len(images), axis=0)
            for one, (i, mirror) in zip(maps, images, strict=True):
                one[2, i] += mirror
            ties.append(Tie(face, stiffness, form, maps))
        return ties

    @property
    def _mirrors(self) -> list[np.ndarray]:
        planes = self._model.mesh.layout.symmetry.values()
        return [np.diag(np.where(np.arange(3) == plane, -1.0, 1.0)) for plane in planes]

    def weight(self) -> None:
        """See ``Body``."""

    def inertia(self) -> None:
        """See ``Body``."""


class Constraints(BodyKind):
    """The kind of body that a spec's ``constraints`` are."""

    key = "constraints"
    annotation = list[Constraint]
    description = "faces that stay rigid, plane or parallel while they move freely"

    def faults(self, written: Any, place: Place, layout: Layout) -> Iterator[Fault]:
        """See ``BodyKind``."""
        seen: set[str] = set()
        for index, entry in enumerate(written if isinstance(written, list) else ()):
            name = entry.get("surface") if isinstance(entry, dict) else None
            yield from surface_fault(name, (*place, index, "surface"), layout)
            if isinstance(name, str) and name in seen:
                yield (*place, index), f"'{name}' has a constraint already; keep one"
            seen |= {name} if isinstance(name, str) else set()

    def build(self, model: Model, parts: Sequence[Constraint]) -> list[ConstrainedFace]:
        """See ``BodyKind``."""
        return [
            ConstrainedFace(model, part, f"constraints.{index}") for index, part in enumerate(parts)
        ]

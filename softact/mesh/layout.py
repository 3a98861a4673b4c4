"""Named parts of a mesh and what they mean."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

Place = tuple[float, float, float]
#: Between two points (mm), or where two surfaces meet.
Line = tuple[Place, Place] | tuple[str, str]


#: Of the motion between the faces of a module.
COMPONENTS = tuple(f"{kind}_{c}" for kind in ("turn", "shift") for c in "xyz")


def free_components(symmetry: Mapping[str, int]) -> np.ndarray:
    """Which of ``COMPONENTS``, as turns and shifts (2, 3), symmetry planes leave: in one plane a
    turn and two shifts."""
    planes = set(symmetry.values())
    return np.array([[planes <= {c} for c in range(3)], [c not in planes for c in range(3)]])


@dataclass(frozen=True)
class Repeats:
    """Two faces of one module of a long chain, see ``softact.bodies.repeat``.

    left, right: names of the surface groups. hold: name of a component -> its value, mm or rad:
    of the ``shift_`` and ``turn_`` along and about x, y, z of the right face beside the left one.
    """

    left: str
    right: str
    hold: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Layout:
    """Named parts of a mesh and what they mean. Lengths in mm.

    regions: names of the volume groups.
    surfaces: names of all surface groups (outer, cavity walls, embedded).
    cavities: cavity name -> names of the surface groups that wall it. Together with the symmetry
        planes they close the cavity.
    clamp, tip: names of the surface groups at the two ends.
    base: name of the surface or curve from whose rotation the tip's is counted, as between two
        markers; None: from the undeformed state, where the clamp is held.
    axis: unit vector from clamp to tip in the undeformed state.
    bending_axis: unit vector about which a positive bending angle turns ``axis`` (right-hand
        rule), or None where the actuator can bend in any plane.
    symmetry: name of a surface group in a symmetry plane -> index (0, 1, 2) of the coordinate
        that is zero there. Each halves the model: the whole has ``copies`` parts.
    layers: names of surface groups meant for thin layers (outer or embedded).
    origin: a point on the axis at the clamp.
    length: distance from clamp to tip along the axis.
    sheets: names of the sheets (triangles in space, no volume); curves: of edges on them. Supports,
        loads, the clamp and the tip may be a sheet or a curve too.
    covers: sheet -> the surface of the solid on which it lies, with its triangles; of an actuator
        with both. bonded: those that share the solid's nodes; others slide where contact is given.
    points, lines: that a spec names beside; supports and forces may act on them.
    flux: weights of x, y and z in the volume that sheets enclose, see
    ``softact.loads.sheet_cavity``.
    repeats: where the mesh is one module of a chain, the two faces at which its like go on.
    """

    regions: tuple[str, ...]
    surfaces: tuple[str, ...]
    cavities: dict[str, tuple[str, ...]]
    clamp: str = "clamp"
    tip: str = "tip"
    base: str | None = None
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    bending_axis: tuple[float, float, float] | None = None
    symmetry: dict[str, int] = field(default_factory=dict)
    layers: tuple[str, ...] = ()
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    length: float = 0.0
    sheets: tuple[str, ...] = ()
    curves: tuple[str, ...] = ()
    covers: dict[str, str] = field(default_factory=dict)
    bonded: tuple[str, ...] = ()
    points: dict[str, Place] = field(default_factory=dict)
    lines: dict[str, Line] = field(default_factory=dict)
    flux: tuple[float, float, float] = (1 / 3, 1 / 3, 1 / 3)
    repeats: Repeats | None = None

    @property
    def outside(self) -> tuple[str, ...]:
        """Surfaces that may touch something: no cavity walls, symmetry planes, layers inside, and
        not the two faces of a module."""
        walls = {name for names in self.cavities.values() for name in names}
        hidden = walls | set(self.symmetry) | set(self.layers)
        if self.repeats:
            hidden |= {self.repeats.left, self.repeats.right}
        return tuple(name for name in self.surfaces if name not in hidden)

    @property
    def marks(self) -> tuple[str, ...]:
        """Names of points and lines."""
        return (*self.points, *self.lines)

    @property
    def copies(self) -> int:
        """How many mirrored parts make the whole actuator."""
        return 2 ** len(self.symmetry)

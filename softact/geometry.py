"""What a geometry tells the rest of softact about its mesh (the rest of this file: helper B)."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Layout:
    """Named parts of a mesh and what they mean. Lengths in mm.

    regions: names of the volume groups.
    surfaces: names of all surface groups (outer, cavity walls, embedded).
    cavities: cavity name -> names of the surface groups that wall it. Together with the symmetry
        planes they close the cavity.
    clamp, tip: names of the surface groups at the two ends.
    axis: unit vector from clamp to tip in the undeformed state.
    bending_axis: unit vector about which a positive bending angle turns ``axis`` (right-hand
        rule), or None where the actuator can bend in any plane.
    symmetry: name of a surface group in a symmetry plane -> index (0, 1, 2) of the coordinate
        that is zero there. Each halves the model: the whole has ``copies`` parts.
    layers: names of surface groups meant for thin layers (outer or embedded).
    origin: a point on the axis at the clamp.
    length: distance from clamp to tip along the axis.
    """

    regions: tuple[str, ...]
    surfaces: tuple[str, ...]
    cavities: dict[str, tuple[str, ...]]
    clamp: str = "clamp"
    tip: str = "tip"
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    bending_axis: tuple[float, float, float] | None = None
    symmetry: dict[str, int] = field(default_factory=dict)
    layers: tuple[str, ...] = ()
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    length: float = 0.0

    @property
    def copies(self) -> int:
        """How many mirrored parts make the whole actuator."""
        return 2 ** len(self.symmetry)

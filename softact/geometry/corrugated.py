"""Bellows along x: wide chambers, and gaps between them with channels inside."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import replace
from types import ModuleType
from typing import TYPE_CHECKING

from softact.geometry.base import THINNEST
from softact.geometry.boxes import Plane
from softact.geometry.filleted import Filleted
from softact.geometry.fillets import halves
from softact.geometry.prisms import Prisms
from softact.mesh.layout import Layout


class Corrugated(Filleted):
    """Base of bellows; their parameters ``pitch``, ``gap``, ``side_wall``, ``top_wall``,
    ``midsection_radius``, ``symmetry`` and ``mesh_size`` are in mm.

    Each gap lies in the middle between two chambers; a channel of each cavity runs through it.
    """

    if TYPE_CHECKING:  # Each kind has a default and a description of its own for them.
        pitch: float
        gap: float
        side_wall: float
        top_wall: float
        midsection_radius: float
        fillet: float
        symmetry: bool

    @property
    @abstractmethod
    def outside(self) -> tuple[str, float]:
        """Name and value of the parameter that is the radius of the chambers' outside, mm."""

    @property
    @abstractmethod
    def length(self) -> float:
        """Length of the actuator, mm."""

    @abstractmethod
    def _meshed(self) -> Mapping[str, tuple]:
        """Cavities that are meshed, by name."""

    @abstractmethod
    def solid(self) -> Prisms:
        """The actuator as prisms painted over each other."""

    @property
    def chamber_length(self) -> float:
        """Length of the air space of a chamber."""
        return self.pitch - self.gap - 2 * self.side_wall

    @property
    def chamber_radius(self) -> float:
        """Radius of the air space in the chambers."""
        return self.outside[1] - self.top_wall

    @property
    def channel_radius(self) -> float:
        """Radius of the air space in the gaps."""
        return self.midsection_radius - self.side_wall

    def faults(self) -> Iterator[tuple[str, str]]:
        """Parameters that leave no room for chambers or gaps."""
        yield from super().faults()
        if self.chamber_length < THINNEST:
            yield (
                "pitch",
                f"leaves {self.chamber_length:g} mm for the length of a chamber: the chambers "
                "would vanish between their walls and the gaps",
            )
        name, radius = self.outside
        if self.midsection_radius >= radius:
            yield (
                "midsection_radius",
                f"{self.midsection_radius:g} mm is not less than {name} ({radius:g} mm): the gaps "
                "would vanish",
            )

    def layout(self) -> Layout:
        cavities, ends = tuple(self._meshed()), self.ends
        surfaces = (*ends, "outer", *cavities)
        return Layout(
            regions=("body",),
            surfaces=(*surfaces, "symmetry") if self.symmetry else surfaces,
            cavities={name: (name,) for name in cavities},
            bending_axis=(0.0, 1.0, 0.0) if self.symmetry else None,
            symmetry={"symmetry": 1} if self.symmetry else {},
            length=self.span,
            clamp=ends[0],
            tip=ends[1],
            repeats=self.repeats,
        )

    @property
    def span(self) -> float:
        """Length of what is meshed, mm."""
        return self.pitch if self.alone else self.length

    def planes(self) -> tuple[Plane, ...]:
        """The flat ends and, of a half, the plane of symmetry."""
        ends = Plane(self.ends[0], 0, 0.0), Plane(self.ends[1], 0, self.span)
        return (*ends, Plane("symmetry", 1, 0.0)) if self.symmetry else ends

    @property
    def fillets(self) -> Mapping[str, float]:
        return {"fillet": self.fillet}

    def _whole(self) -> Prisms:
        """The whole actuator: edges of a half would be rounded in its plane, too."""
        return self.model_copy(update={"symmetry": False}).solid()

    def entities(self, gmsh: ModuleType) -> None:
        replace(self._whole(), planes=self.planes()).divide(gmsh)

    def build(self, gmsh: ModuleType) -> None:
        if not self.filleted:
            self.solid().build(gmsh)
            return
        solids = self._whole().build(gmsh)
        if self.symmetry:
            halves(gmsh, solids)
        gmsh.model.occ.synchronize()

    def mesh(self, gmsh: ModuleType) -> None:
        if self.filleted:
            return super().mesh(gmsh)
        self.solid().mesh(gmsh, self.mesh_size, self.least_steps)

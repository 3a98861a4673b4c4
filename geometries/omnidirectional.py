"""An omnidirectional bellows: three or four corrugated cavities around the axis.

Xavier et al. (2021), Sensors and Actuators A 332:113199. Run by itself it writes a mesh:
``python geometries/omnidirectional.py --cavities 4 -o bellows.msh``.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import asin, cos, pi, sin, sqrt, tan
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from softact.geometry.base import THINNEST, ThroughWall, main
from softact.geometry.boxes import OUTSIDE
from softact.geometry.chains import OneModule
from softact.geometry.corrugated import Corrugated
from softact.geometry.filleted import FilletSize
from softact.geometry.fillets import Rounded, mouth, too_large
from softact.geometry.prisms import Prism, Prisms, Shapes, lacking
from softact.geometry.walls import Wall
from softact.units import Length

SHORT = 3  # modules of an arm whose middle one knows nothing of the ends


class Omnidirectional(Corrugated):
    """A corrugated cylinder whose cavities lie around the axis, divided by inner walls.

    Each module along x is a wide chamber between two halves of a gap. In the chamber the outside
    has the actuator radius, in the gap the midsection radius, where a channel of each cavity runs
    on to the next module. The inner walls are planes through the axis, as long as the actuator.
    The outer half gaps of the two ends are solid. cavity_1 is the topmost; the others follow
    towards y and down.

    An arm of several segments has so many modules in each, and cavities that end with it:
    segment_1_cavity_1 is the topmost at the clamp. The gap between two segments is solid.
    """

    type: Literal["omnidirectional"] = "omnidirectional"
    cavities: Annotated[int, Field(ge=3, le=6)] = Field(3, description="number of cavities")
    modules: Annotated[int, Field(ge=1, le=100)] = Field(
        11, description="number of modules, of each segment"
    )
    segments: Annotated[int, Field(ge=1, le=20)] = Field(
        1,
        description="segments in a row with cavities of their own, from two on named "
        "segment_1_cavity_1 and so on, from the clamp",
    )
    pitch: Length = Field(10.0, description="length of a module")
    gap: Length = Field(3.0, description="length of the gap between two chambers, outside")
    actuator_radius: Length = Field(12.0, description="radius r_a of the outside")
    midsection_radius: Length = Field(4.5, description="radius r_m of the outside in the gaps")
    top_wall: Length = Field(1.5, description="thickness t_t of the outer wall of the chambers")
    side_wall: Length = Field(
        1.0, description="thickness t_s of the walls that face the gaps, and of the midsection"
    )
    inner_wall: Length = Field(1.0, description="thickness t_i of the walls between the cavities")
    channels: bool = Field(
        True, description="join the chambers of a cavity by a channel through the gaps; else solid"
    )
    core_radius: Length | None = Field(
        None,
        description="radius of a solid core around which the chambers lie; by default they reach "
        "in to the axis",
    )
    on_top: Literal["cavity", "wall"] = Field(
        "cavity", description="what lies in the plane y = 0 above the axis"
    )
    symmetry: bool = Field(
        False,
        description="model the half y >= 0 only: the cavities of the other half get the pressures "
        "of their mirror images",
    )
    mesh_size: Length = Field(3.5, description="longest edge")
    fillet: Length = Field(
        0.0, description="radius of the edges of chambers and channels, inside; 0 mm: sharp"
    )
    fillet_mesh_size: FilletSize = None
    through_wall: ThroughWall = None
    module_alone: OneModule = None

    counted: ClassVar[tuple[str, str] | None] = ("modules", "module")

    def short(self) -> dict[str, Any]:
        return {"modules": SHORT, "segments": 1}

    @property
    def pitches(self) -> float:
        return self._total

    @property
    def _total(self) -> int:
        """Modules of all segments."""
        return self.segments * self.modules

    def in_segments(self) -> tuple[Mapping[str, str], ...]:
        sectors = self._sectors()
        return tuple({name: self._named(n, name) for name in sectors} for n in self._numbers)

    @property
    def _numbers(self) -> range:
        """Of the segments, from the clamp."""
        return range(1, self.segments + 1)

    def _named(self, segment: int, cavity: str) -> str:
        """A cavity of a segment as the whole arm calls it."""
        return f"segment_{segment}_{cavity}" if self.segments > 1 else cavity

    def faults(self) -> Iterator[tuple[str, str]]:
        yield from super().faults()
        if self.alone and self.segments > 1:
            yield "segments", "a module alone is of one segment; leave segments out"
        inside = max(
            self._apex, self.core_radius or 0.0, self.channel_radius if self.channels else 0.0
        )
        if self.chamber_radius - inside < THINNEST:
            yield (
                "top_wall",
                f"{self.top_wall:g} mm leaves nothing beside the inner walls, the core or the "
                "channels in the gaps: the chambers would vanish",
            )
        if self.channels and self.core_radius is not None:
            yield "core_radius", "a solid core has no channels; write channels: false"
        elif self.channels and self.channel_radius - self._apex < THINNEST:
            yield (
                "midsection_radius",
                f"{self.midsection_radius:g} mm less the side walls and the inner walls leaves no "
                "room: the channels in the gaps would vanish",
            )

        if self.fillet and self.core_radius is not None:
            yield "fillet", "around a core edges are sharp; leave one of the two out"
        else:
            yield from self._fillet_faults()

    def _fillet_faults(self) -> Iterator[tuple[str, str]]:
        rooms = {"a chamber's length": self.chamber_length}
        spans = {"a chamber's section": self.chamber_radius}
        if self.channels and self.modules > 1:
            spans["a channel's section"] = self.channel_radius
        # The largest circle in a sector touches its two planes and its arc.
        rooms |= {
            name: 2 * (radius * sin(pi / self.cavities) - self.inner_wall / 2)
            / (1 + sin(pi / self.cavities))
            for name, radius in spans.items()
        }  # fmt: skip
        yield from too_large("fillet", self.fillet, rooms)
        flat = self.chamber_radius - self.fillet
        if self.fillet and self.channels and self.channel_radius > flat:
            yield (
                "fillet",
                f"{self.fillet:g} mm leaves flat ends of the chambers up to {flat:g} mm from the "
                f"axis, and channels reach {self.channel_radius:g} mm; write a smaller one",
            )

    @property
    def outside(self) -> tuple[str, float]:
        return "actuator_radius", self.actuator_radius

    @property
    def length(self) -> float:
        """Length of the actuator."""
        return self._total * self.pitch

    @property
    def _apex(self) -> float:
        """Distance from the axis to the inner corner of a cavity."""
        return self.inner_wall / 2 / sin(pi / self.cavities)

    def _middle(self, number: int) -> float:
        """Direction of the middle of a cavity (0, 1, ...) in the plane y, z; radians from y."""
        turns = (number + (0.5 if self.on_top == "wall" else 0.0)) / self.cavities
        return pi / 2 - 2 * pi * turns

    def _meshed(self) -> dict[str, tuple[float, float]]:
        """Cavity -> direction of its middle, and which part of it is meshed."""
        sectors = self._sectors().items()
        return {self._named(n, name): which for n in self._numbers for name, which in sectors}

    def _sectors(self) -> dict[str, tuple[float, float]]:
        """The same of one segment."""
        found = {}
        for number in range(self.cavities):
            angle = self._middle(number)
            across = cos(angle) if self.symmetry else 1.0
            if across > -1e-9:
                found[f"cavity_{number + 1}"] = angle, 0.5 if across < 1e-9 else 1.0
        return found

    def _sector(self, radius: float) -> float:
        """Area of a cavity's section: between two planes half a wall off the axis, in a circle."""
        angle = pi / self.cavities - asin(self.inner_wall / 2 / radius)
        return radius**2 * angle - self._apex * radius * sin(angle)

    @property
    def _gaps(self) -> int:
        """Gaps of what is meshed."""
        return 1 if self.alone else self._total - 1

    @property
    def _opening(self) -> float:
        """Area of a whole cavity's section in a chamber."""
        section = self._sector(self.chamber_radius)
        if self.core_radius is not None and self.core_radius > self._apex:
            section -= self._sector(self.core_radius)
        return section

    def _rounded(self, radius: float) -> Rounded:
        """A cavity's section with rounded corners in a circle of so many mm."""
        r, wall = self.fillet, self.inner_wall / 2 + self.fillet
        inner, apex = radius - r, wall / sin(pi / self.cavities)
        angle = pi / self.cavities - asin(wall / inner)
        area = inner**2 * angle - apex * inner * sin(angle)
        return Rounded(r, area, 2 * (inner * angle + self._side(inner, wall)))

    def _side(self, radius: float, wall: float) -> float:
        """Length of a side of a sector whose sides lie ``wall`` (mm) off planes by the axis."""
        return sqrt(radius**2 - wall**2) - wall / tan(pi / self.cavities)

    def _rounded_cavity(self) -> float:
        """Volume of a whole cavity with fillets."""
        n, between, r = self.modules, self.pitch - self.chamber_length, self.fillet
        volume = n * self._rounded(self.chamber_radius).prism(self.chamber_length)
        if not self.channels:
            return volume
        channel = self._rounded(self.channel_radius)
        sides = 2 * self._side(self.channel_radius - r, self.inner_wall / 2 + r)
        turn = pi - 2 * pi / self.cavities  # of the walls beside the apex
        return volume + (n - 1) * (between * channel.section + 2 * mouth(r, sides, turn))

    def _cavity(self) -> float:
        """Volume of a whole cavity."""
        if self.fillet:
            return self._rounded_cavity()
        chambers = (1 if self.alone else self.modules) * self.chamber_length * self._opening
        if not self.channels:
            return chambers
        passages = 1 if self.alone else self.modules - 1
        between = passages * (self.pitch - self.chamber_length)
        return chambers + between * self._sector(self.channel_radius)

    def walls(self) -> tuple[Wall, ...] | None:
        if self.filleted:
            return None
        sides = {"side_wall": self.side_wall} if self._total > 1 else {}
        round_ = self.walls_between_curves(top_wall=self.top_wall, inner_wall=self.inner_wall)
        return (*round_, *self.walls_between_planes(**sides))

    def volumes(self) -> dict[str, float]:
        half = 0.5 if self.symmetry else 1.0
        notches = self._gaps * self.gap
        disc, midsection = (pi * r**2 for r in (self.actuator_radius, self.midsection_radius))
        outside = self.span * disc - notches * (disc - midsection)
        cavities = {name: part * self._cavity() for name, (_, part) in self._meshed().items()}
        body = half * (outside - self.segments * self.cavities * self._cavity())
        face = disc - self.cavities * self._opening if self.alone else disc
        return {"body": body, **dict.fromkeys(self.ends, half * face), **cavities}

    def volume_tolerance(self, name: str) -> float:
        def lost(radius: float) -> float:
            """Area between a circle and its polygon, at most."""
            return pi * radius**2 * lacking(radius, self.mesh_size)

        share = 1 if name in ("body", *self.ends) else 1 / (self.segments * self.cavities)
        if name in self.ends:
            face = self.volumes()[name] * (2 if self.symmetry else 1)
            chambers = lost(self.chamber_radius) if self.alone else 0.0
            return (lost(self.actuator_radius) + chambers) / face
        air = self.span / self.pitch * self.chamber_length * lost(self.chamber_radius)
        inner = self.channel_radius if self.channels else self.core_radius or 0.0
        air += self.span * lost(inner) if inner else 0.0
        if self.fillet:
            edges = self._rounded(self.chamber_radius).round_edges(self.chamber_length)
            air += self.cavities * self._total * edges * self.chord_error(self.fillet)
        if share < 1:
            return share * air / self._cavity()
        skin = self.span * (lost(self.actuator_radius) + lost(self.midsection_radius))
        return (air + skin) * (0.5 if self.symmetry else 1) / self.volumes()["body"]

    def _shapes(self, occ: Any) -> Shapes:
        """Discs of the outside, and sectors of the cavities in chambers and in gaps."""
        shapes: Shapes = {
            "wide": [(2, occ.addDisk(0, 0, 0, *[self.actuator_radius] * 2))],
            "narrow": [(2, occ.addDisk(0, 0, 0, *[self.midsection_radius] * 2))],
        }
        for name, (angle, _) in self._sectors().items():
            for kind, radius in (
                ("chamber", self.chamber_radius),
                ("channel", self.channel_radius),
            ):
                sector = [(2, self._add_sector(occ, angle, radius))]
                if self.core_radius is not None:
                    sector, _ = occ.cut(
                        sector, [(2, occ.addDisk(0, 0, 0, *[self.core_radius] * 2))]
                    )
                shapes[f"{kind} of {name}"] = sector
        if self.symmetry:
            size = 2 * self.actuator_radius
            for name, faces in shapes.items():
                half = [(2, occ.addRectangle(0, -size, 0, size, 2 * size))]
                shapes[name], _ = occ.intersect(faces, half)
        return shapes

    def _add_sector(self, occ: Any, angle: float, radius: float) -> int:
        half = pi / self.cavities - asin(self.inner_wall / 2 / radius)
        axis = occ.addPoint(0, 0, 0)
        apex = occ.addPoint(self._apex * cos(angle), self._apex * sin(angle), 0)
        ends = [
            occ.addPoint(radius * cos(angle + turn), radius * sin(angle + turn), 0)
            for turn in (-half, half)
        ]
        sides = [
            occ.addLine(apex, ends[0]),
            occ.addCircleArc(ends[0], axis, ends[1]),
            occ.addLine(ends[1], apex),
        ]
        occ.remove([(0, axis)])
        return occ.addPlaneSurface([occ.addCurveLoop(sides)])

    def solid(self) -> Prisms:
        """The actuator as prisms painted over each other."""
        pitch = self.pitch
        prisms = [Prism("body", "wide", 0.0, self.span)]
        borders = [pitch / 2] if self.alone else [i * pitch for i in range(1, self._total)]
        notches = [(x - self.gap / 2, x + self.gap / 2) for x in borders]
        prisms += [Prism(OUTSIDE, "wide", *notch) for notch in notches]
        prisms += [Prism("body", "narrow", *notch) for notch in notches]
        for number, chambers in enumerate(self._middles(), 1):
            for sector in self._sectors():
                prisms += self._air(self._named(number, sector), sector, chambers)
        cavities = tuple(self._meshed())
        return Prisms(self._shapes, tuple(prisms), ("body",), cavities, planes=self.planes())

    def _middles(self) -> list[list[float]]:
        """Where along x the middles of the chambers lie, segment by segment, mm."""
        if self.alone:
            return [[0.0, self.pitch]]
        places = [(i + 0.5) * self.pitch for i in range(self._total)]
        return [places[i : i + self.modules] for i in range(0, self._total, self.modules)]

    def _air(self, name: str, sector: str, middles: Sequence[float]) -> Iterator[Prism]:
        """A cavity: its channel, and its chambers around middles along x, mm."""
        if self.channels and self.modules > 1:
            yield Prism(name, f"channel of {sector}", middles[0], middles[-1], self.fillet, True)
        for middle in middles:
            start, end = middle - self.chamber_length / 2, middle + self.chamber_length / 2
            inside = max(start, 0.0), min(end, self.span)
            yield Prism(name, f"chamber of {sector}", *inside, rounded=self.fillet)


if __name__ == "__main__":
    main(Omnidirectional)

"""An antagonistic bellows: an upper and a lower pair of opposing PneuNets at right angles.

Palacios-Lazo et al. (2025), Actuators 14:540. Run by itself it writes a mesh:
``python geometries/antagonistic.py --chambers 6 -o bellows.msh``.
"""

from collections.abc import Iterator
from math import acos, cos, pi, sin, sqrt
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from softact.geometry.base import THINNEST, ThroughWall, main
from softact.geometry.boxes import OUTSIDE
from softact.geometry.chains import OneModule
from softact.geometry.corrugated import Corrugated
from softact.geometry.filleted import FilletSize
from softact.geometry.fillets import Rounded, mouth, too_large
from softact.geometry.prisms import Entities, Prism, Prisms, Shapes, lacking
from softact.geometry.walls import Wall
from softact.units import Length

CIRCLE_EDGES = 12
PAIRS = ("upper", "lower")  # upper: at the clamp


class Antagonistic(Corrugated):
    """Two pairs of PneuNets in a row along x: the upper pair at the clamp, the lower at the tip.

    The cavities of a pair, a and b, lie on both sides of a central wall; the lower pair is turned
    by 90 degrees. A cavity is a row of chambers with round tops; in the gaps between them only the
    central wall and a round midsection with the channel that joins the chambers remain. Two bores
    along the central wall of the upper pair bring the air to the lower cavities.
    """

    type: Literal["antagonistic"] = "antagonistic"
    chambers: Annotated[int, Field(ge=1, le=50)] = Field(6, description="chambers of each cavity")
    pitch: Length = Field(13.0, description="from one chamber to the next")
    gap: Length = Field(3.0, description="gap between the chambers, outside")
    radius: Length = Field(18.0, description="radius of the outside")
    top_wall: Length = Field(2.0, description="thickness t_w of the round wall of the chambers")
    side_wall: Length = Field(
        1.5, description="thickness s_w of the walls that face the gaps, and of the midsection"
    )
    central_wall: Length = Field(6.5, description="thickness of the wall between a pair")
    midsection_radius: Length = Field(8.0, description="outer radius around the channels")
    bore: Length = Field(3.5, description="diameter of the bores in the upper central wall")
    bore_distance: Length = Field(11.0, description="distance of the bores from the axis")
    clamp_plate: Length = Field(5.0, description="solid end at the clamp")
    middle_plate: Length = Field(4.0, description="solid between upper and lower pair")
    tip_plate: Length = Field(5.0, description="solid end at the tip")
    in_plane: Literal["upper", "lower"] = Field(
        "upper", description="the pair whose cavities a and b lie above and below the axis"
    )
    symmetry: bool = Field(
        False,
        description="model the half y >= 0 only: the cavity b beside the plane gets the pressure "
        "of a",
    )
    mesh_size: Length = Field(5.0, description="longest edge")
    fillet: Length = Field(
        0.0, description="radius of the edges of chambers, channels and bores, inside; 0 mm: sharp"
    )
    fillet_mesh_size: FilletSize = None
    through_wall: ThroughWall = None
    module_of: Literal["upper", "lower"] = Field(
        "upper", description="the pair of which softact module takes a chamber"
    )
    module_alone: OneModule = None

    counted: ClassVar[tuple[str, str] | None] = ("chambers", "chamber")

    def faults(self) -> Iterator[tuple[str, str]]:
        yield from super().faults()
        half = self.central_wall / 2
        if self.chamber_radius - half < THINNEST:
            yield "top_wall", "leaves no room above the central wall: the chambers would vanish"
        if self.channel_radius - half < THINNEST:
            yield (
                "midsection_radius",
                f"{self.midsection_radius:g} mm less the side wall leaves nothing above the "
                "central wall: the channels between the chambers would vanish",
            )
        if self.central_wall - self.bore < THINNEST:
            yield (
                "bore",
                f"{self.bore:g} mm is as thick as the central wall ({self.central_wall:g} mm): the "
                "walls around the bores would vanish",
            )
        if not half < self.bore_distance - self.bore / 2 < self.chamber_radius - self.bore:
            yield (
                "bore_distance",
                f"{self.bore_distance:g} mm does not bring the bores into the lower chambers, "
                f"{half:g} to {self.chamber_radius:g} mm from the axis",
            )

        yield from self._fillet_faults()

    def _fillet_faults(self) -> Iterator[tuple[str, str]]:
        half, r = self.central_wall / 2, self.fillet
        rooms = {
            "a chamber's length": self.chamber_length,
            "a chamber's height": self.chamber_radius - half,
            "a bore": self.bore,
        }
        if self.chambers > 1:
            rooms["a channel's height"] = self.channel_radius - half
        yield from too_large("fillet", r, rooms)
        flat = self.chamber_radius - r
        reach = {"the bores": self.bore_distance + self.bore / 2, "channels": self.channel_radius}
        for what, radius in reach.items():
            if r and radius > flat:
                yield (
                    "fillet",
                    f"{r:g} mm leaves flat ends of the chambers up to {flat:g} mm from the axis, "
                    f"and {what} reach {radius:g} mm; write a smaller one",
                )
        if r and self.bore_distance - self.bore / 2 < half + r:
            yield (
                "fillet",
                f"{r:g} mm runs into the bores, which begin "
                f"{self.bore_distance - self.bore / 2 - half:g} mm above the central wall; write a "
                "smaller one",
            )

    @property
    def outside(self) -> tuple[str, float]:
        return "radius", self.radius

    @property
    def length(self) -> float:
        """Length of the actuator."""
        plates = self.clamp_plate + self.middle_plate + self.tip_plate
        return plates + 2 * self.chambers * self.pitch

    def _starts(self) -> dict[str, float]:
        """Where along x each pair starts."""
        lower = self.clamp_plate + self.chambers * self.pitch + self.middle_plate
        return {"upper": self.clamp_plate, "lower": lower}

    def _bore_length(self) -> float:
        first = self._starts()["lower"] + (self.pitch - self.chamber_length) / 2
        return first - self.clamp_plate

    def _meshed(self) -> dict[str, tuple[str, float, float]]:
        """Cavity -> its pair, the direction in which it lies (radians from y), meshed part."""
        lower = self.alone and self.module_of == "lower"
        return {name: of for name, of in self._cavities().items() if not lower or of[0] == "lower"}

    def _cavities(self) -> dict[str, tuple[str, float, float]]:
        """The same, also of a pair that is not there in a module."""
        found = {}
        for pair in PAIRS:
            above = pair == self.in_plane
            found[f"{pair}_a"] = pair, pi / 2 if above else 0.0, 1.0
            found[f"{pair}_b"] = pair, -pi / 2 if above else pi, 1.0
        if not self.symmetry:
            return found
        return {
            name: (pair, angle, 0.5 if pair == self.in_plane else 1.0)
            for name, (pair, angle, _) in found.items()
            if cos(angle) > -0.5
        }

    def _segment(self, radius: float) -> float:
        """Area of a circle beyond the central wall, on one side."""
        h = self.central_wall / 2
        return radius**2 * acos(h / radius) - h * sqrt(radius**2 - h**2)

    def _rounded(self, radius: float) -> Rounded:
        """A cavity's section with rounded corners in a circle of so many mm."""
        h, inner = self.central_wall / 2 + self.fillet, radius - self.fillet
        area = inner**2 * acos(h / inner) - h * sqrt(inner**2 - h**2)
        perimeter = 2 * (inner * acos(h / inner) + sqrt(inner**2 - h**2))
        return Rounded(self.fillet, area, perimeter)

    def _rounded_cavity(self, pair: str) -> float:
        """Volume of a cavity with fillets."""
        r = self.fillet
        volume = self.chambers * self._rounded(self.chamber_radius).prism(self.chamber_length)
        if self.chambers > 1:
            volume += (self.chambers - 1) * self._rounded_channel()
        if pair == "lower":
            inner = self.bore / 2 - r
            bore = Rounded(r, pi * inner**2, 2 * pi * inner)
            long = 2 * self._bore_length()  # both halves have one blind end
            volume += bore.prism(long) / 2
        return volume

    def _rounded_channel(self) -> float:
        """Volume of a channel between two chambers, with what it takes from their roundings."""
        r, inner = self.fillet, self.channel_radius - self.fillet
        chord = 2 * sqrt(inner**2 - (self.central_wall / 2 + r) ** 2)
        section = self._rounded(self.channel_radius).section
        return (self.pitch - self.chamber_length) * section + 2 * mouth(r, chord)

    def _cavity(self, pair: str) -> float:
        if self.alone:
            return self.pitch * self._opening(pair) - self._narrowed(pair)
        if self.fillet:
            return self._rounded_cavity(pair)
        n, between = self.chambers, self.pitch - self.chamber_length
        volume = n * self.chamber_length * self._segment(self.chamber_radius)
        volume += (n - 1) * between * self._segment(self.channel_radius)
        bore = pi * self.bore**2 / 4 * self._bore_length()
        return volume + (bore if pair == "lower" else 0.0)

    def _opening(self, pair: str) -> float:
        """Area of a cavity in a face of a module: of a chamber, or of a bore."""
        if pair == self.module_of:
            return self._segment(self.chamber_radius)
        return pi * self.bore**2 / 4

    def _narrowed(self, pair: str) -> float:
        """What the air of a module lacks between two chambers."""
        if pair != self.module_of:
            return 0.0
        channel = self._opening(pair) - self._segment(self.channel_radius)
        return (self.pitch - self.chamber_length) * channel

    def walls(self) -> tuple[Wall, ...] | None:
        if self.filleted:
            return None
        sides = {"side_wall": self.side_wall} if self.chambers > 1 else {}
        round_ = self.walls_between_curves(top_wall=self.top_wall, central_wall=self.central_wall)
        return (*round_, *self.walls_between_planes(**sides))

    def volumes(self) -> dict[str, float]:
        half = 0.5 if self.symmetry else 1.0
        disc = pi * self.radius**2
        notch = 2 * (self._segment(self.radius) - self._segment(self.midsection_radius))
        gaps = 1 if self.alone else 2 * (self.chambers - 1)
        outside = self.span * disc - gaps * self.gap * notch
        cavities = {name: part * self._cavity(p) for name, (p, _, part) in self._meshed().items()}
        pairs = {pair for pair, *_ in self._meshed().values()}
        air = 2 * sum(self._cavity(pair) for pair in pairs)
        face = disc - 2 * sum(map(self._opening, pairs)) if self.alone else disc
        return {"body": half * (outside - air), **dict.fromkeys(self.ends, half * face), **cavities}

    def volume_tolerance(self, name: str) -> float:
        def lost(radius: float) -> float:
            """Area between a circle and its polygon, at most."""
            return pi * radius**2 * lacking(radius, self.mesh_size, CIRCLE_EDGES)

        if name in self.ends:
            holes = lost(self.chamber_radius) + 2 * lost(self.bore / 2) if self.alone else 0.0
            whole = self.volumes()[name] * (2 if self.symmetry else 1)
            return (lost(self.radius) + holes) / whole
        n, between = 1 if self.alone else self.chambers, self.pitch - self.chamber_length
        air = n * self.chamber_length * lost(self.chamber_radius) / 2
        air += n * between * lost(self.channel_radius) / 2
        bores = (self.pitch if self.alone else self._bore_length()) * lost(self.bore / 2)
        if self.alone and name in self._meshed() and self._meshed()[name][0] != self.module_of:
            return bores / self._cavity("lower")
        air += bores
        if self.fillet:
            edges = n * self._rounded(self.chamber_radius).round_edges(self.chamber_length)
            air += 2 * edges * self.chord_error(self.fillet)
        if name != "body":
            return air / self._cavity(self.module_of if self.alone else "upper")
        skin = self.span * (lost(self.radius) + lost(self.midsection_radius))
        return (4 * air + skin) * (0.5 if self.symmetry else 1) / self.volumes()["body"]

    def _shapes(self, occ: Any) -> Shapes:
        """Sections of the outside, of the central walls, of chambers, channels and bores."""
        size = 2 * self.radius

        def disc(radius: float, y: float = 0.0, z: float = 0.0) -> Entities:
            return [(2, occ.addDisk(y, z, 0, radius, radius))]

        def cut_box(faces: Entities, start: float, end: float, angle: float) -> Entities:
            """The part of faces whose distance along a direction is between start and end."""
            box = [(2, occ.addRectangle(start, -size, 0, end - start, 2 * size))]
            occ.rotate(box, 0, 0, 0, 0, 0, 1, angle)
            return occ.intersect(faces, box)[0]

        wall = self.central_wall / 2
        shapes = {"wide": disc(self.radius), "narrow": disc(self.midsection_radius)}
        # Of both pairs in a module, too: so it has the whole's section.
        for pair in PAIRS:
            angle = pi / 2 if pair == self.in_plane else 0.0
            shapes[f"{pair} wall"] = cut_box(disc(self.radius), -wall, wall, angle)
        for name, (pair, angle, _) in self._cavities().items():
            for kind, radius in (
                ("chamber", self.chamber_radius),
                ("channel", self.channel_radius),
            ):
                shapes[f"{name} {kind}"] = cut_box(disc(radius), wall, size, angle)
            if pair == "lower":
                place = self.bore_distance * cos(angle), self.bore_distance * sin(angle)
                shapes[f"{name} bore"] = disc(self.bore / 2, *place)
        if self.symmetry:
            shapes = {name: cut_box(faces, 0.0, size, 0.0) for name, faces in shapes.items()}
        return shapes

    def solid(self) -> Prisms:
        """The actuator as prisms painted over each other."""
        prisms = self._module_prisms() if self.alone else self._prisms()
        return Prisms(
            self._shapes,
            tuple(prisms),
            ("body",),
            tuple(self._meshed()),
            planes=self.planes(),
            circle_edges=CIRCLE_EDGES,
        )

    def _module_prisms(self) -> list[Prism]:
        """Of a module: from the middle of a chamber to that of the next."""
        pair, length, half = self.module_of, self.pitch, self.chamber_length / 2
        notch = (length - self.gap) / 2, (length + self.gap) / 2
        prisms = [Prism("body", "wide", 0.0, length), Prism(OUTSIDE, "wide", *notch)]
        prisms += [Prism("body", shape, *notch) for shape in (f"{pair} wall", "narrow")]
        for name, (of, _, _) in self._meshed().items():
            kind = "channel" if of == pair else "bore"
            prisms.append(Prism(name, f"{name} {kind}", 0.0, length))
            if of == pair:
                ends = (0.0, half), (length - half, length)
                prisms += [Prism(name, f"{name} chamber", *end) for end in ends]
        return prisms

    def _prisms(self) -> list[Prism]:
        """Of the whole actuator."""
        pitch, half = self.pitch, self.chamber_length / 2
        starts, length = self._starts(), self.length
        prisms = [Prism("body", "wide", 0.0, length)]
        notches = [
            (pair, start + i * pitch - self.gap / 2, start + i * pitch + self.gap / 2)
            for pair, start in starts.items()
            for i in range(1, self.chambers)
        ]
        prisms += [Prism(OUTSIDE, "wide", start, end) for _, start, end in notches]
        for pair, start, end in notches:
            prisms += [Prism("body", shape, start, end) for shape in (f"{pair} wall", "narrow")]
        for name, (pair, _, _) in self._meshed().items():
            middles = [starts[pair] + (i + 0.5) * pitch for i in range(self.chambers)]
            if pair == "lower":
                bore = self.clamp_plate, middles[0], self.fillet
                prisms.append(Prism(name, f"{name} bore", *bore))
            if len(middles) > 1:
                channel = middles[0], middles[-1], self.fillet, True
                prisms.append(Prism(name, f"{name} channel", *channel))
            prisms += [
                Prism(name, f"{name} chamber", x - half, x + half, self.fillet) for x in middles
            ]
        return prisms


if __name__ == "__main__":
    main(Antagonistic)

"""Whether a part and the size of its elements fit each other, before gmsh fills the memory."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import ModuleType

import numpy as np

from softact.errors import MeshError
from softact.geometry.step_names import UNITS
from softact.mesh.cells import MOST_TETRAHEDRA

# Least numbers of tetrahedra in a cube of their edge, and of triangles in a square of theirs.
IN_A_CUBE, IN_A_SQUARE = 6.0, 2.3
LEAST_FILLED = 0.1  # part of its bounding box that a solid of unknown volume fills at least
# Largest dimensions of actuators, mm: beyond, the unit of the file is doubted.
SMALL, LARGE = 1.0, 3000.0
LIKELY = ("mm", "m", "in", "cm")  # units in which parts are drawn


@dataclass(frozen=True)
class Drawn:
    """The size of a part, and how the file comes by it.

    extents: (3,) mm along x, y, z. volume, area: mm^3 and mm^2 of all solids and faces, as far as
    they are known. unit: in which the file is taken to be written, "" where there is no choice;
    said: whether the file itself says so.
    """

    extents: np.ndarray
    volume: float = 0.0
    area: float = 0.0
    unit: str = ""
    said: bool = False

    @classmethod
    def of_model(cls, gmsh: ModuleType, unit: str = "", said: bool = False) -> Drawn:
        """The current gmsh model, before it is meshed."""
        box = np.array(gmsh.model.getBoundingBox(-1, -1)).reshape(2, 3)
        extents, occ = box[1] - box[0], gmsh.model.occ
        solids, faces = occ.getEntities(3), occ.getEntities(2)
        if not solids:
            return cls(extents, LEAST_FILLED * float(np.prod(extents)), 0.0, unit, said)
        volume, area = (sum(occ.getMass(*entity) for entity in kind) for kind in (solids, faces))
        return cls(extents, volume, area, unit, said)

    @property
    def sides(self) -> str:
        """The extents as text."""
        return " x ".join(f"{float(f'{side:.4g}'):g}" for side in self.extents) + " mm"

    def refuse(self, mesh_size: float) -> None:
        """Raise MeshError where there would be too many elements, or one larger than the part."""
        count = max(IN_A_CUBE * self.volume / mesh_size**3, IN_A_SQUARE * self.area / mesh_size**2)
        if count > MOST_TETRAHEDRA:
            by_volume = math.cbrt(IN_A_CUBE * self.volume / MOST_TETRAHEDRA)
            by_area = math.sqrt(IN_A_SQUARE * self.area / MOST_TETRAHEDRA)
            raise MeshError(
                f"the part is {self.sides}; mesh_size {mesh_size:g} mm would make about "
                f"{count:.0e} tetrahedra, and {MOST_TETRAHEDRA:.0e} are the most; "
                f"{self._other_unit}write mesh_size: {_up(max(by_volume, by_area))} mm or more"
            )
        longest = float(max(self.extents))
        if mesh_size > 2 * longest:
            raise MeshError(
                f"the part is {self.sides}, and mesh_size {mesh_size:g} mm is larger than that; "
                f"{self._other_unit}write mesh_size: {longest / 10:.2g} mm or so"
            )

    @property
    def doubt(self) -> str:
        """What to say of a size that is unlikely, "" where it is not."""
        if SMALL <= max(self.extents) <= LARGE:
            return ""
        doubted = f"the part is {self.sides}, an unlikely size for an actuator; {self._other_unit}"
        return f"{doubted}leave it so" if self.unit else f"{doubted}is it in mm?"

    @property
    def _other_unit(self) -> str:
        """In which unit an unlikely size would be a likely one."""
        if SMALL <= max(self.extents) <= LARGE or not self.unit:
            return ""
        source = f"the file says {self.unit}" if self.said else f"it is read in {self.unit}"
        for unit in LIKELY:
            other = Drawn(self.extents * UNITS[unit] / UNITS.get(self.unit, 1.0))
            if unit != self.unit and SMALL <= max(other.extents) <= LARGE:
                return (
                    f"{source}: if it was drawn in {unit} ({other.sides}) write unit: {unit}; else "
                )
        return f"{source}; "


def _up(size: float) -> str:
    """A size rounded up to two digits."""
    digits = 10.0 ** (math.floor(math.log10(size)) - 1)
    return f"{math.ceil(size / digits) * digits:g}"

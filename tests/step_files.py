"""STEP files as CAD programs write them, made by OCC, with names where they are wanted."""

import re
from collections.abc import Callable
from pathlib import Path

import gmsh
import numpy as np

from softact.geometry.step_names import SOLIDS, StepFile

# A block 40 x 14 x 12 mm on the plane z = 2 mm with a room of 32 x 8 x 6 mm, and a plate under it.
BLOCK, ROOM = (0, -7, 2, 40, 14, 12), (4, -4, 5, 32, 8, 6)
WIDE, LIKE_THE_BLOCK = (0, -9, 0, 40, 18, 2), (0, -7, 0, 40, 14, 2)
BLOCK_VOLUME, ROOM_VOLUME = 40 * 14 * 12 - 32 * 8 * 6, 32 * 8 * 6


def ends_and_room(x: float, y: float, z: float) -> str:
    """Names of the faces of ``bladder`` and its plate, by the middle of their corners."""
    if x in (0, 40):
        return "tip" if x else "clamp"
    return "cavity" if 3.9 < x < 36.1 and -4.1 < y < 4.1 and 4.9 < z < 11.1 else ""


def write(
    path: Path,
    make: Callable,
    faces: Callable[..., str] = lambda x, y, z: "",
    solids: tuple[str, ...] = (),
) -> Path:
    """Write what ``make(occ)`` adds to OCC, with names for its faces and solids."""
    gmsh.initialize(readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        make(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    text = path.read_text()
    file = StepFile(text)
    for number in file.kinds("ADVANCED_FACE"):
        corners = [file._place(corner) for corner in file._corners(number)]
        middle = np.mean(corners, axis=0) if corners else np.full(3, np.nan)  # of a ball
        text = renamed(text, number, faces(*middle))
    for number, name in zip(file.kinds(*SOLIDS), solids, strict=False):
        text = renamed(text, number, name)
    path.write_text(text)
    return path


def renamed(text: str, number: int, name: str) -> str:
    """The text of a STEP file with another name for an entity."""
    return re.sub(rf"(#{number}\s*=\s*\w+\(')[^']*'", lambda m: f"{m[1]}{name}'", text)


def bladder(occ) -> None:
    """The block with its room."""
    occ.cut([(3, occ.addBox(*BLOCK))], [(3, occ.addBox(*ROOM))])


def on_a_plate(plate: tuple[float, ...] = WIDE) -> Callable:
    """The block with its room and a plate under it, two solids."""

    def make(occ) -> None:
        bladder(occ)
        occ.addBox(*plate)

    return make


MILLI = r"\( LENGTH_UNIT\(\) NAMED_UNIT\(\*\) SI_UNIT\(\.MILLI\.,\.METRE\.\) \)"
INCH = """#9001 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#9002);
#9002 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );
#9003 = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);
"""


def in_unit(text: str, unit: str) -> str:
    """The text of a STEP file in mm with the same numbers in another unit."""
    if unit == "in":
        inch = "( CONVERSION_BASED_UNIT('INCH',#9001) LENGTH_UNIT() NAMED_UNIT(#9003) )"
        return re.sub(MILLI, inch, text).replace("ENDSEC;\nEND-ISO", f"{INCH}ENDSEC;\nEND-ISO")
    prefix = {"m": "$", "cm": ".CENTI.", "mm": ".MILLI."}[unit]
    return text.replace("SI_UNIT(.MILLI.,.METRE.)", f"SI_UNIT({prefix},.METRE.)")

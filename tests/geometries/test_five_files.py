"""One part in files of different habits, each run from its file to its pictures.

The block with its room of tests/step_files.py, clamped at one end, under pressure: what it does
must not depend on how its file came about.
"""

from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path

import gmsh
import numpy as np
import pytest
from PIL import Image

from softact.api import DataSheet
from softact.api import run as softact_run
from softact.errors import MeshError
from softact.geometry.base import make_mesh
from softact.spec import loads
from tests import step_files
from tests.geometries.test_step_slivers import with_lump

SPEC = """
name: bladder
geometry: {{type: {type}, file: {file}, mesh_size: 8 mm, {more}}}
materials: {{{materials}}}
steps: [{{name: inflate, pressure: 30 kPa}}]
solver: {{initial_increment: 1, max_increment: 1}}
measures: [pressure, tip, elongation, volume, reaction]
"""
SOFT = "{law: neo_hookean, c10: 0.1 MPa}"


@dataclass(frozen=True)
class Habit:
    """How a file comes about. make: what is in it; faces, solids: its names; unit: what it says
    that it is in; more: what a spec has to say beside its path."""

    make: object = step_files.bladder
    faces: object = staticmethod(lambda x, y, z: "")
    solids: tuple[str, ...] = ()
    unit: str = "mm"
    suffix: str = ".step"
    more: str = ""
    materials: dict = field(default_factory=lambda: {"body": SOFT})


HABITS = {
    "without names": Habit(),
    "with names": Habit(faces=step_files.ends_and_room, solids=("silicone",),
                        more="regions: [silicone]", materials={"silicone": SOFT}),
    "with slivers": Habit(make=with_lump, more="heal: 0.02 mm"),
    "in mm, and says m": Habit(unit="m", more="unit: mm"),
    "closed surface": Habit(suffix=".stl"),
    "two solids": Habit(make=step_files.on_a_plate(step_files.LIKE_THE_BLOCK), solids=("a", "b"),
                        more="regions: [a, b]",
                        materials={"a": SOFT, "b": "{law: neo_hookean, c10: 1 MPa}"}),
}  # fmt: skip


def written(habit: Habit, folder: Path) -> Path:
    """The file of a habit."""
    path = folder / f"part{habit.suffix}"
    if habit.suffix == ".step":
        step_files.write(path, habit.make, habit.faces, habit.solids)
        path.write_text(step_files.in_unit(path.read_text(), habit.unit))
        return path
    gmsh.initialize(readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        habit.make(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", 8.0)
        gmsh.model.mesh.generate(2)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    return path


def spec_of(habit: Habit, folder: Path, more: str | None = None):
    materials = ", ".join(f"{name}: {text}" for name, text in habit.materials.items())
    text = SPEC.format(
        type="from_mesh" if habit.suffix == ".stl" else "from_step", file=written(habit, folder),
        more=habit.more if more is None else more, materials=materials,
    )  # fmt: skip
    return loads(text)


@pytest.fixture(scope="module")
def sheets(tmp_path_factory) -> dict[str, DataSheet]:
    """Habit -> its run, with report and pictures."""
    found = {}
    for name, habit in HABITS.items():
        folder = tmp_path_factory.mktemp("habit")
        found[name] = softact_run(spec_of(habit, folder), folder / "run")
    return found


@pytest.mark.parametrize("name", HABITS)
def test_each_file_comes_to_its_pictures(name, sheets):
    """All steps are solved; the pictures show a body coloured by its stress, not a blank."""
    sheet = sheets[name]
    assert sheet.status == "complete"
    assert "The pictures of the actuator are missing" not in (
        (sheet.directory / "report.html").read_text(encoding="utf-8")
    )
    for picture in ("shape.png", "states.png"):
        content = (sheet.directory / picture).read_bytes()
        seen = np.asarray(Image.open(BytesIO(content)).convert("RGB"), float)
        assert (np.ptp(seen, axis=2) > 60).mean() > 0.03


@pytest.mark.parametrize("name", ["with names", "with slivers", "in mm, and says m",
                                  "closed surface"])  # fmt: skip
def test_it_does_the_same_whatever_its_file(name, sheets):
    """Elongation and volume as without names: to what meshes differ by, the lump's 0.01 mm too, and
    further where the surface's triangles make another mesh, of which each gmsh has its own: with
    8 mm the elongation is 12 % less than with 2.5 mm."""
    wanted, found = sheets["without names"].summary, sheets[name].summary
    assert wanted["elongation_mm"] > 0.08
    within = 0.1 if name == "closed surface" else 0.02
    for column in ("elongation_mm", "cavity_volume_mm3"):
        assert found[column] == pytest.approx(wanted[column], rel=within)


def test_the_plate_of_an_assembly_holds_its_side_back(sheets):
    """Ten times as stiff and glued below the block: the tip goes less far, and down. The clamp has
    no reaction, for the pressure in a closed room has no resultant."""
    free, glued = sheets["without names"].summary, sheets["two solids"].summary
    assert 0 < glued["elongation_mm"] < 0.8 * free["elongation_mm"]
    down = glued["tip_z_mm"] - sheets["two solids"].curve["tip_z_mm"].iloc[0]
    assert down < -0.1
    assert max(abs(glued[f"reaction_{c}_N"]) for c in "xyz") < 1e-4


def test_metres_by_mistake_are_told_before_anything_is_meshed(tmp_path):
    spec = spec_of(HABITS["in mm, and says m"], tmp_path, more="")
    with pytest.raises(MeshError) as caught:
        make_mesh(spec.geometry, tmp_path / "x.msh", 60.0)
    (line,) = caught.value.lines
    assert "40000" in line and "if it was drawn in mm (40 x 14 x 12 mm) write unit: mm" in line

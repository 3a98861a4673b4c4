"""Faces beside others, slivers that are named, and OCC's healing of them."""

import numpy as np
import pytest

from softact.errors import MeshError
from softact.geometries.from_step import FromStep
from softact.spec import json_schema
from tests import step_files
from tests.geometries.looking import looked

THIN = 0.01  # mm by which a lump stands out of the roof


def with_lump(occ):
    """The bladder with a lump of 10 x 14 mm on its roof."""
    x, y, z, _, wide, high = step_files.BLOCK
    block, lump = (
        occ.addBox(*step_files.BLOCK),
        occ.addBox(x + 10, y, z + high - 1, 10, wide, 1 + THIN),
    )
    whole, _ = occ.fuse([(3, block)], [(3, lump)])
    occ.cut(whole, [(3, occ.addBox(*step_files.ROOM))])


@pytest.fixture(scope="module")
def lumpy(tmp_path_factory):
    return str(step_files.write(tmp_path_factory.mktemp("step") / "lumpy.step", with_lump))


@pytest.fixture(scope="module")
def bladder(tmp_path_factory):
    return str(
        step_files.write(tmp_path_factory.mktemp("step") / "bladder.step", step_files.bladder)
    )


def step(file: str, **given) -> FromStep:
    return FromStep.model_validate({"file": file, "mesh_size": "6 mm", **given})


def test_slivers_are_named_with_what_removes_them(lumpy, bladder):
    said = [text for text in looked(step(lumpy)) if "sliver" in text]
    assert len(said) == 2  # the lump's two sides towards clamp and tip
    for text, x in zip(said, (10, 20), strict=True):
        assert f"is a sliver {THIN:g} mm wide near ({x}, 0, 14" in text
        assert text.endswith("heal: 0.02 mm removes it")
    assert not any("sliver" in text for text in looked(step(bladder)))


def test_healing_removes_them_and_nothing_else(lumpy, meshed):
    geometry = step(lumpy, heal="0.02 mm", surfaces=["outer"])
    said = looked(geometry)
    assert not any("sliver" in text for text in said)
    assert any("with 14 faces" in text for text in said)  # of 16
    solid = meshed(geometry)
    whole = step_files.BLOCK_VOLUME + 10 * 14 * THIN
    assert solid.volumes.sum() == pytest.approx(whole, rel=2 * 10 * 14 * THIN / whole)
    cavity = np.linalg.norm(solid.outward_areas("cavity")[1], axis=1).sum()
    assert cavity == pytest.approx(2 * (32 * 8 + 32 * 6 + 8 * 6))


@pytest.mark.parametrize(
    ("select", "numbers"),
    [
        # The block's faces: 1 and 6 its ends, 2 to 5 around it; 7 to 12 those of the room.
        ({"rim": {"beside": "clamp"}}, "faces 2 to 5"),
        ({"rim": {"beside": 1}}, "faces 2 to 5"),
        ({"rim": {"beside": "clamp", "normal": [0, 0, 1]}}, "face"),
        ({"rim": {"beside": "roof"}, "roof": {"plane": {"z": "14 mm"}}}, "faces"),
    ],
)
def test_faces_beside_others(bladder, select, numbers):
    geometry = step(bladder, select=select, surfaces=list(select))
    (said,) = [text for text in looked(geometry) if text.startswith("'rim' is ")]
    assert said.startswith(f"'rim' is {numbers}")
    if "roof" in select:  # all that touch the roof: the ends and both sides
        (roof,) = [text for text in looked(geometry) if text.startswith("'roof' is face ")]
        number = roof.split()[-1]
        assert number not in said.split("faces ")[1].replace(",", "").split()


def test_what_is_beside_nothing_is_told(bladder):
    for beside in ("nowhere", 99, "rim"):
        with pytest.raises(MeshError, match=r"select\.rim chooses no face"):
            looked(step(bladder, select={"rim": {"beside": beside}}, surfaces=["rim"]))


def test_an_editor_knows_what_may_stand_there():
    selection = json_schema()["$defs"]["Selection"]["properties"]["beside"]
    assert {"type": "string"} in selection["anyOf"]

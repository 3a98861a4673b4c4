"""The examples of a part of one's own: a STEP file without names, and the script that made it."""

import importlib.util
from math import pi
from pathlib import Path

import numpy as np
import pytest

from softact.geometry.base import make_mesh
from softact.mesh.msh_file import read_msh
from softact.mesh.quality import signed_volumes
from softact.spec import load

ROOT = Path(__file__).parents[2]
# geometries/examples/bladder.py: two half-round rooms of radius 6 mm and length 26 mm in a block of
# 60 x 16 x 12 mm, on a strip 1.5 mm thick.
ROOM = pi / 2 * 6**2 * 26
VOLUMES = [60 * 16 * 12 - 2 * ROOM, 60 * 16 * 1.5]


@pytest.mark.parametrize("name", ["own_step", "own_script"])
def test_both_have_the_same_parts(name, tmp_path):
    spec = load(ROOT / "configs" / f"{name}.yaml")
    layout = spec.geometry.layout()
    make_mesh(spec.geometry, tmp_path / "mesh.msh")
    mesh = read_msh(tmp_path / "mesh.msh", layout)
    volume = np.abs(signed_volumes(mesh.points, mesh.cells))
    found = [volume[mesh.region == number].sum() for number in range(2)]
    # Chords of 4 mm on a radius of 6 mm cut 7 % off a room.
    assert found == pytest.approx(VOLUMES, rel=0.03)
    assert sum(found) >= sum(VOLUMES)
    for walls in layout.cavities.values():
        a, b, c = np.moveaxis(mesh.points[mesh.surfaces[walls[0]]], 1, 0)
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
        assert area == pytest.approx(26 * (pi * 6 + 12) + pi * 6**2, rel=0.03)


def test_the_file_is_what_the_script_writes(tmp_path):
    path = ROOT / "geometries" / "examples" / "bladder.py"
    spec = importlib.util.spec_from_file_location("bladder", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.main(str(tmp_path / "bladder.step"))

    def entities(file: Path) -> int:
        return sum(line.startswith("#") for line in file.read_text().splitlines())

    kept = ROOT / "configs" / "parts" / "bladder.step"
    # Other versions of OCC write some more or fewer lines.
    assert entities(tmp_path / "bladder.step") == pytest.approx(entities(kept), rel=0.05)

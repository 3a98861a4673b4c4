"""Rounded edges: closed forms, what OCC builds, what is refused, and that none changes nothing."""

from math import pi

import meshio
import numpy as np
import pytest
from pydantic import ValidationError

from softact.geometries.antagonistic import Antagonistic
from softact.geometries.omnidirectional import Omnidirectional
from softact.geometries.pneunet import Pneunet
from softact.geometries.slow_pneunet import SlowPneunet
from softact.geometry.base import make_mesh
from softact.geometry.fillets import Rounded, mouth
from softact.mesh.curves import VTK_EDGES, of_quadratic, volumes

COARSE = {"mesh_size": "4 mm", "fillet_mesh_size": "0.8 mm"}
PNEUNET = {"chambers": 2, "gap": "1.5 mm", "fillet": "0.8 mm", "gap_fillet": "0.6 mm"}
SLOW = {"chambers": 2, "chamber_length": "4 mm", "inner_wall": "3 mm", "fillet": "0.8 mm"}
ROUNDED = {
    "pneunet": Pneunet.model_validate(PNEUNET | COARSE),
    "whole pneunet": Pneunet.model_validate(PNEUNET | COARSE | {"symmetry": False}),
    "slow, bending": SlowPneunet.model_validate(SLOW | COARSE),
    "antagonistic": Antagonistic.model_validate(
        {"chambers": 2, "fillet": "1 mm", "mesh_size": "8 mm", "fillet_mesh_size": "1.5 mm"}
    ),
    "half antagonistic": Antagonistic.model_validate(
        {"chambers": 1, "fillet": "1 mm", "symmetry": True, "mesh_size": "8 mm"}
    ),
    "omnidirectional": Omnidirectional.model_validate({"modules": 2, "fillet": "0.5 mm"}),
    "half omnidirectional": Omnidirectional.model_validate(
        {"modules": 2, "fillet": "0.5 mm", "symmetry": True}
    ),
    "two segments": Omnidirectional.model_validate(
        {"modules": 1, "segments": 2, "fillet": "0.5 mm", "symmetry": True}
    ),
    "slow, linear": SlowPneunet.model_validate(SLOW | COARSE | {"kind": "linear"}),
}


def test_a_rounded_cube_becomes_a_ball():
    """Of a cube of 2 r all edges of which have the radius r a ball is left."""
    assert Rounded.rectangle(2.0, 2.0, 1.0).prism(2.0) == pytest.approx(4 / 3 * pi, rel=1e-12)


def test_a_mouth_by_counting():
    """A channel 3 x 2 leaves a chamber along its floor, both with roundings of 0.7: points that lie
    in the channel and below the chamber's rounding, on a grid."""
    r, n = 0.7, 400
    y, z, t = np.meshgrid(*(np.linspace(0, e, n, endpoint=False) + e / n / 2 for e in (1.5, r, r)))
    beside = np.maximum(y - (1.5 - r), 0.0)
    inside = beside**2 + (r - z) ** 2 < r**2
    below = r - z > np.sqrt(r**2 - t**2)
    counted = 2 * (inside & below).mean() * 1.5 * r * r
    assert mouth(r, 3.0 - 2 * r) == pytest.approx(counted, rel=2e-3)


@pytest.mark.parametrize("name", ROUNDED)
def test_occ_builds_the_closed_forms(name, occ_volume):
    """The solid that OCC builds has the volume of the closed form, to what OCC is exact to."""
    geometry = ROUNDED[name]
    volumes = geometry.volumes()
    solid = sum(volumes[region] for region in geometry.layout().regions)
    assert occ_volume(geometry) == pytest.approx(solid, rel=1e-7)


def curved_volume(path) -> float:
    """Of a mesh of quadratic tetrahedra."""
    raw = meshio.read(path)
    cells = np.vstack([block.data for block in raw.cells if block.type == "tetra10"])
    curves = of_quadratic(raw.points, cells, VTK_EDGES)
    return float(volumes(curves.nodes(cells[:, :4], raw.points)).sum())


@pytest.mark.parametrize("name", ["pneunet", "slow, bending"])
def test_a_curved_mesh_has_the_volume_of_the_closed_form(name, tmp_path):
    """To a hundredth of what the roundings add to the solid."""
    geometry = ROUNDED[name]
    make_mesh(geometry, tmp_path / "solid.msh", curved=True)
    sharp = geometry.model_copy(update=dict.fromkeys(geometry.fillets, 0.0))
    of, without = (
        sum(g.volumes()[region] for region in g.layout().regions) for g in (geometry, sharp)
    )
    assert curved_volume(tmp_path / "solid.msh") == pytest.approx(of, abs=0.01 * abs(of - without))


@pytest.mark.parametrize("kind", [Pneunet, SlowPneunet])
def test_no_fillet_is_the_mesh_without(kind, tmp_path):
    meshes = []
    for fillet in ({}, {"fillet": "0 mm"}):
        geometry = kind.model_validate({"chambers": 2, "mesh_size": "4 mm"} | fillet)
        make_mesh(geometry, tmp_path / "solid.msh")
        meshes.append((tmp_path / "solid.msh").read_bytes())
    assert meshes[0] == meshes[1]


@pytest.mark.parametrize(
    ("kind", "given", "field", "said"),
    [
        (Pneunet, {"fillet": "3 mm", "chambers": 1}, "fillet", "less than 3 mm"),
        (Pneunet, {"fillet": "1 mm"}, "fillet", "channel_height of 2 mm"),
        (Pneunet, {"gap_fillet": "0.5 mm"}, "gap_fillet", "a gap of 1 mm"),
        (Pneunet, {"fillet": "0.9 mm", "channel_width": "11 mm"}, "fillet", "10.2 mm flat"),
        (Pneunet, {"fillet": "-1 mm"}, "fillet", "would vanish"),
        (SlowPneunet, {"fillet": "1 mm"}, "fillet", "chamber_length of 2 mm"),
    ],
)
def test_a_radius_that_does_not_fit(kind, given, field, said):
    with pytest.raises(ValidationError) as caught:
        kind.model_validate(given)
    fault = caught.value.errors()[0]
    assert fault["loc"] == (field,) and said in fault["msg"]


def test_one_chamber_has_no_channel_that_a_fillet_could_be_too_large_for():
    """A channel of 6 mm is left no section by a fillet of 1.5 mm, but is not there."""
    lengths = {"radius": "12 mm", "bore": "3.2 mm", "bore_distance": "6.6 mm", "gap": "2 mm"}
    values = lengths | {"pitch": "12 mm", "side_wall": "2 mm", "fillet": "1.5 mm"}
    one = Antagonistic.model_validate({**values, "chambers": 1})
    assert [*one.faults()] == []
    assert (
        0 < one.volumes()["upper_a"] < one.model_copy(update={"fillet": 0.0}).volumes()["upper_a"]
    )

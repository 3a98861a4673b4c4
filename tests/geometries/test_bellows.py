"""Bellows against a thin shell of revolution, and what is refused."""

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.integrate import solve_bvp

from softact.geometries.bellows import Bellows
from softact.geometry.waves import Wave
from softact.results.folder import read
from softact.run.start import run
from softact.spec import loads

BELLOWS = """
geometry:
  {{type: bellows, convolutions: 1, pitch: 8 mm, inner_radius: {inner} mm, outer_radius: {outer} mm,
    wall: {wall} mm, through_wall: 2, mesh_size: {size} mm}}
materials: {{body: {{law: neo_hookean, c10: 0.1 MPa, density: 1000 kg/m^3}}}}
solver: {{initial_increment: 1, max_increment: 1}}
contact: none
"""
PULLED, PRESSURE = 0.002, 1e-6  # mm, MPa: so little that all is linear
HELD = """
supports:
  - {surface: clamp, fix: [x, y, z]}
  - {surface: tip, fix: [y, z], move: {x: 0.002 mm}}
steps:
  - {name: pulled, pressure: 0 kPa}
  - {name: blown, pressure: 0.001 kPa}
"""
ROOT, CREST, WALL, MODULUS = 8.5, 14.5, 0.4, 0.6  # mm, MPa: that of the neo-Hookean law, 6 c10


@pytest.fixture
def curve(tmp_path):
    """Function from the text of a spec to the columns of its curve."""

    def solve(text):
        outcome = run(loads(text), tmp_path / "result", report=False)
        assert outcome.status == "complete", outcome.message
        return read(tmp_path / "result").curve

    return solve


def written(size):
    """The spec of bellows with the middle of their wall at ROOT and CREST."""
    inner, outer = ROOT - WALL / 2, CREST + WALL / 2
    return BELLOWS.format(inner=inner, outer=outer, wall=WALL, size=size) + HELD


def shell(pulled, pressure):
    """Force of the wall along the axis at the crest, N, of one convolution between rigid plates,
    one of which moves away by ``pulled`` (mm) under a pressure (MPa).

    Linear theory of thin shells of revolution without shear (Reissner 1949, On the theory of thin
    elastic shells), as a boundary value problem along half of the wall. State: displacements along
    the radius and the axis, rotation, and r times the forces along both and the moment.
    """
    wave, poisson = Wave(1, 8.0, ROOT, CREST, 2.0), 0.5
    stretching = MODULUS * WALL / (1 - poisson**2)
    bending = stretching * WALL**2 / 12

    def rates(along, state):
        out, _, turned, radial, axial, moment = state
        _, r, slope = wave.place(along)
        cos, sin = np.cos(slope), np.sin(slope)  # the wall's direction: cos along x, sin along r
        hoop, bent = out / r, sin * turned / r
        strain = (radial * sin + axial * cos) / r / stretching - poisson * hoop
        curved = moment / r / bending - poisson * bent
        return np.array([
            strain * sin - turned * cos,
            strain * cos + turned * sin,
            curved,
            stretching * (hoop + poisson * strain) - r * pressure * cos,
            r * pressure * sin,
            bending * (bent + poisson * curved) * sin + radial * cos - axial * sin,
        ])  # fmt: skip

    def ends(root, crest):
        return np.array([*root[:3], crest[1] - pulled / 2, crest[2], crest[3]])

    along = np.linspace(0.0, wave.half, 200)
    found = solve_bvp(rates, ends, along, np.zeros((6, along.size)), tol=1e-5, max_nodes=20_000)
    assert found.success
    return 2 * np.pi * found.y[4, -1]


def test_they_are_as_stiff_as_a_thin_shell_and_push_with_its_area(curve):
    """The force of the shell and of the mesh that pull one convolution longer, and the thrust under
    pressure of one that is held: p times the area inside the crest, less what the wall carries
    there. The wall is curved in the mesh: as coarse as that is, it is as stiff as the shell to 1 %,
    where a shell leaves out parts as small as the wall beside its folds. The area is nearly that of
    the mean diameter (Expansion Joint Manufacturers Association), but not quite: 0.6 % less."""
    stiffness = shell(PULLED, 0.0) / PULLED
    area = np.pi * CREST**2 - shell(0.0, PRESSURE) / PRESSURE
    row = curve(written(3))
    force = dict(zip(row["step"], row["tip_force_x_N"], strict=True))
    assert -force["pulled"] / PULLED == pytest.approx(stiffness, rel=0.01)
    thrust = (force["blown"] - force["pulled"]) / PRESSURE
    assert thrust == pytest.approx(area, rel=3e-3)
    assert area == pytest.approx(np.pi / 4 * (ROOT + CREST) ** 2, rel=0.01)


def test_normals_point_out_of_the_wall(meshed):
    """Those of the facets, within the angle that an arc turns between two stations."""
    solid = meshed(Bellows.model_validate({"convolutions": 2, "mesh_size": "2 mm"}))
    middles, areas = solid.outward_areas("outer")
    normal = solid.geometry.wall_normal("body", middles)
    assert np.linalg.norm(normal, axis=1) == pytest.approx(1.0)
    outward = areas / np.linalg.norm(areas, axis=1)[:, None]
    assert np.einsum("ij,ij->i", normal, outward).min() > np.cos(np.pi / 12)


@pytest.mark.parametrize("part", ["quarter", "whole"])
def test_the_number_of_tetrahedra_is_known_before_there_is_a_mesh(part, meshed):
    bellows = Bellows.model_validate({"convolutions": 1, "part": part, "through_wall": 2})
    assert bellows.cells() == len(meshed(bellows).cells)


@pytest.mark.parametrize(
    ("given", "field", "reason"),
    [
        ({"outer_radius": "9 mm"}, "outer_radius", "would vanish; write more than 9 mm"),
        ({"fold_radius": "0.5 mm"}, "fold_radius", "write a radius of more than 0.5 mm"),
        (
            {"pitch": "2 mm"},
            "pitch",
            "more than 2 mm, or a wall of less than 1 mm",
        ),
        ({"fold_radius": "2.1 mm"}, "fold_radius", "into each other; write at most 2 mm"),
    ],
)
def test_what_cannot_be_built_is_refused(given, field, reason):
    with pytest.raises(ValidationError) as caught:
        Bellows.model_validate(given)
    assert [fault["loc"][0] for fault in caught.value.errors()] == [field]
    assert reason in caught.value.errors()[0]["msg"]

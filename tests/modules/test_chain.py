"""A module beside the inner modules of whole actuators of the same mesh, at three pressures."""

import numpy as np
import pytest

from softact.loads.cavity_pressure import CavityPressure
from softact.loads.repeated_cavity import Opening, area_vector
from softact.measures.cross_section import CrossSection
from softact.system.rotation import RotationVector
from tests.modules.solving import solved

RUBBER = {"law": "yeoh", "c10": "0.11 MPa", "c20": "0.02 MPa", "bulk_modulus": "22 MPa"}
FINGER = {
    "type": "pneunet",
    "chambers": 6,
    "chamber_height": "8 mm",
    "chamber_width": "8 mm",
    "base": "3 mm",
    "mesh_size": "4 mm",
    "cavity_mesh_size": "2 mm",
}
PRESSURES = (5.0, 10.0, 15.0)  # kPa


def spec(geometry):
    """Plain data of a spec that goes to the pressures one by one."""
    steps = [{"name": f"to_{p:g}", "pressure": f"{p} kPa"} for p in PRESSURES]
    return {"geometry": geometry, "materials": {"body": RUBBER}, "steps": steps}


def turned_by(angle):
    """Rotation matrix about y."""
    return RotationVector(np.array([0.0, angle, 0.0])).matrix


def angle_between(weights, before, after):
    """Rotation about y, rad, of points (n, 3) about their means, by weights (n,)."""
    one, other = (points - weights @ points for points in (before, after))
    sine = weights @ (one[:, 2] * other[:, 0] - one[:, 0] * other[:, 2])
    return np.arctan2(sine, weights @ (one[:, 0] * other[:, 0] + one[:, 2] * other[:, 2]))


def on_plane(model, plane):
    """Nodes in the plane x = ``plane``, in the order of y and z."""
    places = model.nodes.places
    nodes = np.flatnonzero(abs(places[:, 0] - plane) < 1e-6)
    return nodes[np.lexsort(np.round(places[nodes, 1:], 6).T)]


def inner_module(model, x, planes, weights):
    """Turn, stretch and air (mm³) of the part of a finger between two planes x = const.

    weights: (n,) shares of the section's area of the nodes in a plane.
    """
    places = model.nodes.places
    one, other = (on_plane(model, plane) for plane in planes)
    left, right = (places[nodes] + x[model.displacement_dofs[nodes]] for nodes in (one, other))
    turn = angle_between(weights, left, right)
    frame = turned_by(angle_between(weights, places[one], left))
    shift = frame.T @ (weights @ right - weights @ left)
    mean = RotationVector(np.array([0.0, turn, 0.0]), integral=True).matrix
    stretch = np.linalg.solve(mean, shift)[0] / (planes[1] - planes[0])
    facets = model.surfaces.facets("cavity")
    middles = places[model.surfaces.facet_nodes(facets)].mean(axis=1)[:, 0]
    facets = facets[(planes[0] < middles) & (middles < planes[1])]
    walls = CavityPressure(model.assembler, "part", facets, model.degree).volume(x)
    area = area_vector(*Opening(model, facets, one).at(x))
    rotation = turned_by(turn)
    closing = (weights @ right - rotation @ (weights @ left)) @ rotation @ area / 3
    return turn, stretch, walls + closing


@pytest.fixture(scope="module")
def module(tmp_path_factory):
    geometry = {**FINGER, "module_alone": True}
    return solved(spec(geometry), tmp_path_factory.mktemp("module"))


@pytest.fixture(scope="module")
def finger(tmp_path_factory):
    return solved(spec(FINGER), tmp_path_factory.mktemp("finger"))


@pytest.mark.parametrize("number", range(len(PRESSURES)))
def test_a_module_is_an_inner_one_of_the_finger(module, finger, number):
    """Turn, stretch and air of the third module of a finger of six chambers."""
    model, state = module.model, module.ends[number]
    nodes, share = model.surfaces.shares("left")
    place = {int(node): part for node, part in zip(nodes, share, strict=True)}
    weights = np.array([place.get(int(node), 0.0) for node in on_plane(model, 0.0)])
    planes = 4.0 + 2.0 + 9.0 * np.array([2, 3])  # the plug, a third of a chamber, the pitch
    inside = inner_module(finger.model, finger.ends[number].x, planes, weights)
    section = CrossSection(model, state)
    pitch = section.repeat.length
    found = section.strain[1] * pitch, section.strain[3], model.cavity_volume(state, "cavity")
    print(PRESSURES[number], np.array(found), np.array(found) / inside - 1)
    assert found[0] == pytest.approx(inside[0], rel=1e-3)
    assert found[1] == pytest.approx(inside[1], rel=1e-4)
    assert found[2] == pytest.approx(inside[2], rel=1e-4)
    assert found[0] > 0.02 * (number + 1)

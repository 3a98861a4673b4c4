"""A module beside an inner one of the whole actuator with the same mesh, at three pressures."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from softact.loads.cavity_pressure import CavityPressure
from softact.loads.repeated_cavity import Opening, area_vector
from softact.measures.cross_section import CrossSection
from softact.system.rotation import RotationVector
from tests.modules.solving import solved

RUBBER = {"law": "yeoh", "c10": "0.11 MPa", "c20": "0.02 MPa", "bulk_modulus": "22 MPa"}
WOUND = {"law": "holzapfel", "c10": "0.11 MPa", "k1": "20 MPa", "angle": "80 deg", "families": 2}
PAPER = {
    "thickness": "0.1 mm",
    "bending": 0,
    "material": {"law": "linear", "youngs_modulus": "100 MPa", "poissons_ratio": 0.3},
}
PRESSURES = (0.25, 0.5, 1.0)  # of the case's


@dataclass(frozen=True)
class Case:
    """An actuator, its highest pressure (kPa), where one of its inner modules begins (mm), and the
    cavity that is driven."""

    geometry: dict[str, Any]
    pressure: float
    begins: float
    cavity: str = "cavity"
    more: dict[str, Any] = field(default_factory=dict)
    materials: dict[str, Any] = field(default_factory=lambda: {"body": RUBBER})

    def spec(self, alone: bool) -> dict[str, Any]:
        """Plain data of a spec that goes to the pressures one by one."""
        geometry = {**self.geometry, "module_alone": True} if alone else self.geometry
        steps = [
            {"name": f"to_{p * 100:g}", "pressure": {self.cavity: f"{p * self.pressure} kPa"}}
            for p in PRESSURES
        ]
        return {"geometry": geometry, "materials": self.materials, "steps": steps, **self.more}


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


def inner_module(model, x, planes, weights, cavity):
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
    facets = model.surfaces.facets(cavity)
    middles = places[model.surfaces.facet_nodes(facets)].mean(axis=1)[:, 0]
    facets = facets[(planes[0] < middles) & (middles < planes[1])]
    walls = CavityPressure(model.assembler, "part", facets, model.degree).volume(x)
    area = area_vector(*Opening(model, facets, one).at(x))
    rotation = turned_by(turn)
    closing = (weights @ right - rotation @ (weights @ left)) @ rotation @ area / 3
    return turn, stretch, walls + closing


def assert_like_an_inner_one(case, folder):
    """Turn within 1e-3, stretch and air within 1e-4, at three pressures."""
    model, states = solved(case.spec(alone=True), folder / "module")
    whole, ends = solved(case.spec(alone=False), folder / "whole")
    nodes, share = model.surfaces.shares("left")
    place = {int(node): part for node, part in zip(nodes, share, strict=True)}
    weights = np.array([place.get(int(node), 0.0) for node in on_plane(model, 0.0)])
    planes = case.begins, case.begins + model.repeat.length
    for state, end in zip(states, ends, strict=True):
        inside = inner_module(whole, end.x, planes, weights, case.cavity)
        section = CrossSection(model, state)
        turn = section.strain[1] * section.repeat.length
        found = turn, section.strain[3], model.cavity_volume(state, case.cavity)
        print(np.array(found), np.array(found) / inside - 1)
        assert found[0] == pytest.approx(inside[0], rel=1e-3)
        assert found[1] == pytest.approx(inside[1], rel=1e-4)
        assert found[2] == pytest.approx(inside[2], rel=1e-4)
    assert abs(turn) > 0.01

"""A module beside an inner one of the whole actuator with the same mesh, at three pressures."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from softact.bodies.named_surfaces import turned_round
from softact.geometries import GEOMETRIES
from softact.geometry.base import Geometry
from softact.loads.cavity_pressure import CavityPressure
from softact.loads.repeated_cavity import Opening, area_vector
from softact.loads.sheet_cavity import SheetCavity
from softact.measures.cross_section import CrossSection
from softact.mesh.layout import free_components
from softact.mesh.triangles import Triangles
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
    cavity or surface that is driven. whole: kind of geometry that meshes the whole, where it is not
    its own. bends: whether it turns at all. inflate: whether the highest pressure comes first, once
    more, since the states of flat sheets on the way there are of a slow motion."""

    geometry: dict[str, Any]
    pressure: float
    begins: float
    cavity: str = "cavity"
    load: str = "pressure"
    whole: type[Geometry] | None = None
    bends: bool = True
    inflate: bool = False
    more: dict[str, Any] = field(default_factory=dict)
    materials: dict[str, Any] = field(default_factory=lambda: {"body": RUBBER})

    def spec(self, alone: bool) -> dict[str, Any]:
        """Plain data of a spec that goes to the pressures one by one."""
        geometry = {**self.geometry, "module_alone": True} if alone else self.geometry
        parts = {f"to_{p * 100:g}": p for p in PRESSURES}
        parts = {"inflate": 1.0} | parts if self.inflate else parts
        steps = [
            {"name": name, self.load: {self.cavity: f"{p * self.pressure} kPa"}}
            for name, p in parts.items()
        ]
        data = {"geometry": geometry, "materials": self.materials, "steps": steps}
        data |= {"contact": "none"} | self.more
        if "sheets" in data:
            there = GEOMETRIES[geometry["type"]].model_validate(geometry).layout().sheets
            data["sheets"] = {name: data["sheets"][name] for name in there}
        return data


def rotation_between(weights, before, after):
    """The rotation (3, 3) that takes points (n, 3) about their means to others best, by weights
    (n,): the polar factor of Σ w x Xᵀ."""
    one, other = (points - weights @ points for points in (before, after))
    u, _, v = np.linalg.svd((weights[:, None] * other).T @ one)
    return u @ np.diag([1.0, 1.0, np.linalg.det(u @ v)]) @ v


def on_plane(model, plane):
    """Nodes in the plane x = ``plane``, in the order of y and z; of two sheets that lie on each
    other the lower one first."""
    places, upward = model.nodes.places, np.zeros(len(model.nodes.places))
    for part in model.sheets.values():
        np.add.at(upward, part.triangles.nodes, part.triangles.normals[:, 2:])
    nodes = np.flatnonzero(abs(places[:, 0] - plane) < 1e-6)
    return nodes[np.lexsort([upward[nodes], *np.round(places[nodes, 1:], 6).T])]


class Section:
    """Nodes (n,) in the planes x = const. of a model, with shares (n,) of the section's area.

    A half stands for both: its mirror images count, too.
    """

    def __init__(self, model, weights):
        self.model, self.weights = model, weights
        self.turns = free_components(model.mesh.layout.symmetry)[0].any()
        self.mirrors = [np.eye(3)]
        for axis in model.mesh.layout.symmetry.values():
            flip = np.diag(1.0 - 2.0 * np.eye(3)[axis])
            self.mirrors += [mirror @ flip for mirror in self.mirrors]

    def at(self, plane, x):
        """Undeformed and deformed places (m, 3) of the section in a plane, with their weights."""
        nodes = on_plane(self.model, plane)
        places = self.model.nodes.places[nodes]
        both = places, places + x[self.model.displacement_dofs[nodes]]
        count = len(self.mirrors)
        whole = [np.concatenate([points @ mirror for mirror in self.mirrors]) for points in both]
        return *whole, np.tile(self.weights, count) / count


def walls_between(model, x, planes, cavity):
    """Volume (mm³) of a cavity's walls between two planes x = const., and their nodes (m, n), which
    turn as the facets of solids. cavity: its name, or that of a surface that walls it."""
    places = model.nodes.places
    names = model.mesh.layout.cavities.get(cavity, (cavity,))

    def inside(nodes):
        middles = places[nodes].mean(axis=1)[:, 0]
        return (planes[0] < middles) & (middles < planes[1])

    if set(names) & set(model.sheets):
        nodes = np.concatenate([model.sheets[name].triangles.nodes for name in names])
        nodes = nodes[inside(nodes)]
        triangles = Triangles(nodes, places[nodes], model.nodes.dofs[nodes], None)
        return SheetCavity("part", [triangles]).volume(x), turned_round(nodes)
    facets = model.surfaces.facets(*names)
    facets = facets[inside(model.surfaces.facet_nodes(facets))]
    walls = CavityPressure(model.assembler, "part", facets, model.degree)
    return walls.volume(x), model.surfaces.facet_nodes(facets)


def inner_module(section, x, planes, cavity):
    """Turn (3,), stretch and shears (3,) and air (mm³) of the part between two planes x = const.

    cavity: surface that walls the air.
    """
    model = section.model
    (rest, left, weights), (_, right, _) = (section.at(plane, x) for plane in planes)
    frame, rotation = np.eye(3), np.eye(3)
    if section.turns:
        frame = rotation_between(weights, rest, left)
        rotation = rotation_between(weights, left, right)
    turn = Rotation.from_matrix(frame.T @ rotation @ frame).as_rotvec()
    shift = frame.T @ (weights @ right - weights @ left)
    mean = RotationVector(turn, integral=True).matrix
    stretch = np.linalg.solve(mean, shift) / (planes[1] - planes[0])
    walls, nodes = walls_between(model, x, planes, cavity)
    area = area_vector(*Opening(model, nodes, on_plane(model, planes[0])).at(x))
    closing = (weights @ right - rotation @ (weights @ left)) @ rotation @ area / 3
    return turn, stretch, walls + closing


def face_weights(model):
    """Shares (n,) of the left face's area of its nodes, in the order of ``on_plane``."""
    nodes, share = model.surfaces.shares("left")
    place = {int(node): part for node, part in zip(nodes, share, strict=True)}
    return np.array([place.get(int(node), 0.0) for node in on_plane(model, 0.0)])


STRAIGHT = 1e-5  # rad, of what the mesh turns of an actuator that does not bend


def assert_like_an_inner_one(case, folder):
    """Turn within 1e-3, stretch with shears and air within 1e-4, at three pressures."""
    model, states = solved(case.spec(alone=True), folder / "module")
    whole, ends = solved(case.spec(alone=False), folder / "whole", case.whole)
    weights = face_weights(model)
    section, own = Section(whole, weights), Section(model, weights)
    planes = case.begins, case.begins + model.repeat.length
    for state, end in list(zip(states, ends, strict=True))[-len(PRESSURES) :]:
        turn, stretch, air = inner_module(section, end.x, planes, case.cavity)
        strain = CrossSection(model, state).strain
        off = strain - np.concatenate([turn / model.repeat.length, stretch])
        if case.cavity in model.cavities:
            volume = model.cavity_volume(state, case.cavity)
        else:
            volume = inner_module(own, state.x, (0.0, model.repeat.length), case.cavity)[2]
        size = np.linalg.norm(strain[:3]) if case.bends else STRAIGHT / model.repeat.length * 1e3
        wrong = np.linalg.norm(off[:3])
        found = np.array([wrong / size, np.linalg.norm(off[3:]), volume / air - 1])
        print(strain, found)
        assert found[0] < 1e-3
        assert found[1] < 1e-4
        assert abs(found[2]) < 1e-4
    assert (size * model.repeat.length if case.bends else abs(strain[3] - 1)) > 0.01

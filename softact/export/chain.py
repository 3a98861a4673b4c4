"""The reduced model as simulators of rigid bodies take it: links with joints between them, in SI.

A piece of constant curvature becomes two rigid halves with joints in the middle. With n joints, a
tip that has turned by an angle is off that of an arc by about angle²/(24 n²) of the length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softact.export import masses
from softact.export.reduced import Reduced

M, KG = 1e-3, 1e3  # from mm and tonne
NM, NM2 = 1e-3, 1e-6  # from N·mm and N·mm²
#: Axes of the joints in the model's directions.
AXES = {"twist": (1, 0, 0), "bending_y": (0, 1, 0), "bending_z": (0, 0, 1), "stretch": (1, 0, 0)}
#: Stretch that moves the tip by less than this part of the length gets no joint.
NO_STRETCH = 2e-3


@dataclass(frozen=True)
class Link:
    """A rigid part, in metres and kilograms.

    joint: (3,) where its joint lies in the undeformed actuator, counted from the clamp's centre.
    mass, centre (3,) from the joint, inertia (3, 3) about the centre. box: (2, 3) corners of the
    undeformed part, from the joint.
    """

    joint: np.ndarray
    mass: float
    centre: np.ndarray
    inertia: np.ndarray
    box: np.ndarray


@dataclass(frozen=True)
class Drive:
    """One component of all joints, in SI: N·m and radians, or N and metres for the stretch.

    stiffness: of one joint where nothing is driven. damping: the same, N·m·s. pressure: kPa.
    load: (rows,) moment or force in all joints by which the pressure acts. stiffening: (rows,) what
    the pressure adds to the stiffness of the whole row of joints. rest: (rows,) angle or way of one
    joint without a load.
    """

    component: str
    stiffness: float
    damping: float
    pressure: np.ndarray
    load: np.ndarray
    stiffening: np.ndarray
    rest: np.ndarray


@dataclass(frozen=True)
class Chain:
    """Links from the clamp's on, the first of them fixed; tip: (3,) from the last joint, m.
    slowness: seconds, damping by stiffness of every joint."""

    name: str
    links: tuple[Link, ...]
    drives: tuple[Drive, ...]
    tip: np.ndarray
    gravity: np.ndarray
    slowness: float


def chain_of(model: Reduced, damping_ratio: float) -> Chain:
    """The links and joints of a model. damping_ratio: of the first bending vibration, assumed."""
    data, body = model.data, model.body
    pieces, length = data["pieces"], data["active_length_mm"]
    piece = length / pieces
    joints = data["start_mm"] + piece * (np.arange(pieces) + 0.5)
    borders = np.array([0.0, *joints, body.length])
    lumps = masses.lumps(body.places, body.masses, borders)
    line = [data["offset_y_mm"], data["offset_z_mm"]]
    places = np.array([[0.0, 0.0, 0.0], *([x, *line] for x in joints)])
    links = []
    for number, place in enumerate(places):
        box = body.box.copy()
        box[:, 0] = borders[number : number + 2]
        inertia = lumps.inertia[number] * KG * M**2
        centre = lumps.centre[number] if lumps.mass[number] > 0 else place
        links.append(
            Link(place * M, lumps.mass[number] * KG, (centre - place) * M, inertia,
                 (box - place) * M)
        )  # fmt: skip
    tip = body.tip - places[-1]
    slow = damping_ratio * 2 / first_frequency(model)
    drives = tuple(
        _drive(model, name, piece, slow) for name in data["components"] if _has_joint(model, name)
    )
    gravity = model.states.gravity[np.argmax(np.linalg.norm(model.states.gravity, axis=1))]
    return Chain(data["name"], tuple(links), drives, tip * M, gravity * M, slow)


def _has_joint(model: Reduced, component: str) -> bool:
    if component != "stretch":
        return True
    moved = np.abs(model.data["table"]["rest_stretch"]).max() * model.data["active_length_mm"]
    return moved > NO_STRETCH * model.body.length


def _drive(model: Reduced, component: str, piece: float, slow: float) -> Drive:
    table, length = model.data["table"], model.data["active_length_mm"]
    pressure = np.array(table["pressure_kPa"])
    rest = np.array(table[f"rest_{component}"])
    stiff = np.array(table[f"stiffness_{component}"])
    still = float(np.interp(0.0, pressure, stiff))
    # Moments in N·mm per 1/mm become N·m per radian of a joint; forces per stretch become N/m.
    per_joint, moment = (1 / M, 1.0) if component == "stretch" else (NM, NM)
    at = M if component == "stretch" else 1.0
    return Drive(
        component,
        stiffness=still / piece * per_joint,
        damping=still / piece * per_joint * slow,
        pressure=pressure,
        load=stiff * rest * moment,
        stiffening=(stiff - still) / length * per_joint,
        rest=rest * piece * at,
    )


def first_frequency(model: Reduced) -> float:
    """Of the unloaded cantilever, radians per second: bending as Euler and Bernoulli have it, of an
    actuator that does not bend its stretch."""
    table, length = model.data["table"], model.body.length * M
    name = next((c for c in ("bending_y", "bending_z") if c in model.data["components"]), "stretch")
    stiff = np.interp(0.0, table["pressure_kPa"], table[f"stiffness_{name}"])
    per_length = model.body.masses.sum() * KG / length
    if name == "stretch":
        return float(np.pi / 2 / length * np.sqrt(stiff / per_length))
    return float(1.875104**2 / length**2 * np.sqrt(stiff * NM2 / per_length))

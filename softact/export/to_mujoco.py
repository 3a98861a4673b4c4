"""MuJoCo: a chain of hinges (and slides) with springs, driven through tendons.

A fixed tendon over all joints of one component brings the same moment into each of them. It has two
motors: one for the moment of the pressure, one for what the pressure adds to the stiffness. What
they get at a pressure stands in tables in the file; a small module beside it reads these.
"""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree import ElementTree as Xml

import numpy as np

from softact.export.chain import AXES, Chain, Link
from softact.export.job import Job
from softact.export.statement import comment

#: Springs are explicit in MuJoCo's integrators: with the damping implicit, an overdamped joint is
#: stable below twice its time of decay.
PART_OF_DECAY, LONGEST_STEP = 0.2, 1e-3


def files(job: Job) -> dict[str, str | bytes]:
    """The model and the module that drives it."""
    chain, model = job.chain, f"{job.name}.xml"
    components = tuple(drive.component for drive in chain.drives)
    return {
        model: text(chain, job.about),
        f"{job.name}_mujoco.py": MODULE.format(file=model, components=components),
    }


def text(chain: Chain, about: list[str]) -> str:
    """The MJCF document."""
    root = Xml.Element("mujoco", model=chain.name)
    root.append(comment(about))
    Xml.SubElement(root, "compiler", angle="radian", inertiafromgeom="false")
    decay = min((d.damping / d.stiffness for d in chain.drives), default=1.0)
    step = min(LONGEST_STEP, PART_OF_DECAY * decay)
    Xml.SubElement(
        root, "option", timestep=_number(step), integrator="implicitfast",
        gravity=_vector(chain.gravity),
    )  # fmt: skip
    custom = Xml.SubElement(root, "custom")
    world = Xml.SubElement(root, "worldbody")
    _bodies(chain, world)
    tendons, motors = Xml.SubElement(root, "tendon"), Xml.SubElement(root, "actuator")
    if chain.drives:
        _table(custom, "pressure_kPa", chain.drives[0].pressure)
    for drive in chain.drives:
        name = drive.component
        fixed = Xml.SubElement(tendons, "fixed", name=name)
        for number in range(1, len(chain.links)):
            Xml.SubElement(fixed, "joint", joint=f"{name}_{number}", coef="1")
        _table(custom, f"{name}_load", drive.load)
        _table(custom, f"{name}_stiffening", drive.stiffening)
        Xml.SubElement(motors, "general", name=f"{name}_load", tendon=name, gainprm="1")
        Xml.SubElement(
            motors, "general", name=f"{name}_stiffening", tendon=name, gaintype="affine",
            gainprm="0 -1 0",
        )  # fmt: skip
    Xml.indent(root)
    return Xml.tostring(root, "unicode") + "\n"


def _bodies(chain: Chain, world: Xml.Element) -> None:
    parent, before = world, np.zeros(3)
    for number, link in enumerate(chain.links):
        name = "clamp" if number == 0 else f"piece_{number}"
        parent = Xml.SubElement(parent, "body", name=name, pos=_vector(link.joint - before))
        before = link.joint
        _inertial(parent, link)
        if number:
            for drive in sorted(chain.drives, key=lambda d: d.component != "stretch"):
                kind = "slide" if drive.component == "stretch" else "hinge"
                Xml.SubElement(
                    parent, "joint", name=f"{drive.component}_{number}", type=kind,
                    axis=_vector(AXES[drive.component]), stiffness=_number(drive.stiffness),
                    damping=_number(drive.damping),
                )  # fmt: skip
        low, high = link.box
        # Touches what is around it, but not itself.
        Xml.SubElement(
            parent, "geom", name=f"{name}_box", type="box", pos=_vector((low + high) / 2),
            size=_vector((high - low) / 2), rgba="0.35 0.6 0.85 1", contype="2", conaffinity="1",
        )  # fmt: skip
    Xml.SubElement(parent, "site", name="tip", pos=_vector(chain.tip), size="0.001")


def _inertial(body: Xml.Element, link: Link) -> None:
    m = link.inertia
    full = [m[0, 0], m[1, 1], m[2, 2], m[0, 1], m[0, 2], m[1, 2]]
    Xml.SubElement(
        body,
        "inertial",
        pos=_vector(link.centre),
        mass=_number(link.mass),
        fullinertia=_vector(full),
    )


def _table(custom: Xml.Element, name: str, values: np.ndarray) -> None:
    Xml.SubElement(custom, "numeric", name=name, size=str(len(values)), data=_vector(values))


def _vector(values: Iterable[float]) -> str:
    return " ".join(_number(value) for value in values)


def _number(value: float) -> str:
    return f"{float(value):.9g}"


MODULE = '''\
"""Drives {file} by its pressure; needs numpy and mujoco only. Written by softact.

    model = mujoco.MjModel.from_xml_path("{file}")
    data = mujoco.MjData(model)
    finger = Actuator(model)
    finger.set_pressure(data, 20.0)      # kPa, before each mj_step or where it changes
    mujoco.mj_step(model, data)
    finger.angle(data)                   # radians from clamp to tip
"""

import mujoco
import numpy as np

COMPONENTS = {components!r}


class Actuator:
    """The actuator in a model; prefix: of its names, where it was attached to another model."""

    def __init__(self, model, prefix=""):
        self._columns = []
        self._pressure = self._table(model, prefix + "pressure_kPa")
        for component in COMPONENTS:
            for part in ("load", "stiffening"):
                name = f"{{prefix}}{{component}}_{{part}}"
                motor = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, name)
                self._columns.append((motor, self._table(model, name)))
        self._tendons = {{
            component: mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_TENDON, prefix + component)
            for component in COMPONENTS
        }}

    @staticmethod
    def _table(model, name):
        number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_NUMERIC, name)
        start = model.numeric_adr[number]
        return np.array(model.numeric_data[start : start + model.numeric_size[number]])

    def set_pressure(self, data, kpa):
        """Set the motors; a pressure outside the table counts as its end."""
        for motor, values in self._columns:
            data.ctrl[motor] = np.interp(kpa, self._pressure, values)

    def angle(self, data, component="bending_y"):
        """Sum of the joints of a component, radians; metres of the stretch."""
        return float(data.ten_length[self._tendons[component]])
'''

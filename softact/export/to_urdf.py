"""URDF: the chain of links and joints, with what the pressure does in a table beside it.

URDF has no springs and no actuators that know a pressure. Springs stand in the file as Gazebo reads
them; a controller takes moment and stiffness of a joint at a pressure from the table. The stretch
has no joint: links without a length would need masses that are not there.
"""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree import ElementTree as Xml

import numpy as np

from softact.errors import SpecError
from softact.export.chain import AXES, Chain, Drive, Link
from softact.export.job import Job
from softact.export.statement import comment
from softact.files.text import csv_text

#: Joints of one place that turn about several axes need links between them, which must not be
#: without mass (kg, kg·m²).
LEAST_MASS, LEAST_INERTIA = 1e-6, 1e-12
#: URDF wants limits of each joint, of which no run tells: wide ones, in rad, N·m and rad/s.
MOST_TURN, LARGEST_MOMENT, LARGEST_SPEED = 3.14159, 10.0, 100.0
LIMITS = (
    f"limits of the joints, {MOST_TURN:g} rad, {LARGEST_MOMENT:g} N·m and {LARGEST_SPEED:g} rad/s: "
    "wide ones, since the format wants some and no run tells them"
)


def files(job: Job) -> dict[str, str | bytes]:
    """The robot and its table. Raises SpecError where nothing turns."""
    chain = job.chain
    if not _turning(chain):
        raise SpecError("--to urdf: this actuator only stretches, and the file would have no joint")
    return {
        f"{job.name}.urdf": text(chain, [*job.about, *_left_out(chain), LIMITS]),
        f"{job.name}_joints.csv": csv_text(rows(chain)),
    }


def _turning(chain: Chain) -> list[Drive]:
    return [drive for drive in chain.drives if drive.component != "stretch"]


def _left_out(chain: Chain) -> list[str]:
    way = sum(np.abs(d.rest).max() * (len(chain.links) - 1) for d in chain.drives
              if d.component == "stretch")  # fmt: skip
    return (
        [f"left out: the stretch, which moves the tip by up to {1e3 * way:.3g} mm"] if way else []
    )


def rows(chain: Chain) -> list[dict]:
    """Of one joint, over the pressure: angle without a load, moment that turns it, stiffness."""
    count = len(chain.links) - 1
    found = []
    for at, pressure in enumerate(chain.drives[0].pressure):
        row = {"pressure_kPa": pressure}
        for drive in _turning(chain):
            name = drive.component
            row |= {
                f"{name}_rest_rad": drive.rest[at],
                f"{name}_moment_Nm": drive.load[at],
                f"{name}_stiffness_Nm_per_rad": drive.stiffness + drive.stiffening[at] * count,
            }
        found.append(row)
    return found


def text(chain: Chain, about: list[str]) -> str:
    """The URDF document."""
    root = Xml.Element("robot", name=chain.name)
    root.append(comment(about))
    drives, before, parent = _turning(chain), np.zeros(3), ""
    for number, link in enumerate(chain.links):
        name = "clamp" if number == 0 else f"piece_{number}"
        if number:
            place = link.joint - before
            for drive in drives[:-1]:
                between = f"{drive.component}_link_{number}"
                _small_link(root, between)
                _joint(root, drive, number, parent, between, place)
                parent, place = between, np.zeros(3)
            _joint(root, drives[-1], number, parent, name, place)
        _link(root, name, link)
        before, parent = link.joint, name
    Xml.SubElement(root, "link", name="tip")
    fixed = Xml.SubElement(root, "joint", name="tip_fixed", type="fixed")
    Xml.SubElement(fixed, "parent", link=parent)
    Xml.SubElement(fixed, "child", link="tip")
    Xml.SubElement(fixed, "origin", xyz=_vector(chain.tip))
    Xml.indent(root)
    return '<?xml version="1.0"?>\n' + Xml.tostring(root, "unicode") + "\n"


def _joint(
    root: Xml.Element, drive: Drive, number: int, parent: str, child: str, place: np.ndarray
) -> None:
    name = f"{drive.component}_{number}"
    joint = Xml.SubElement(root, "joint", name=name, type="revolute")
    Xml.SubElement(joint, "parent", link=parent)
    Xml.SubElement(joint, "child", link=child)
    Xml.SubElement(joint, "origin", xyz=_vector(place), rpy="0 0 0")
    Xml.SubElement(joint, "axis", xyz=_vector(AXES[drive.component]))
    Xml.SubElement(joint, "dynamics", damping=_number(drive.damping), friction="0")
    Xml.SubElement(
        joint, "limit", lower=_number(-MOST_TURN), upper=_number(MOST_TURN),
        effort=_number(LARGEST_MOMENT), velocity=_number(LARGEST_SPEED),
    )  # fmt: skip
    spring = Xml.SubElement(root, "gazebo", reference=name)
    Xml.SubElement(spring, "springReference").text = "0"
    Xml.SubElement(spring, "springStiffness").text = _number(drive.stiffness)


def _link(root: Xml.Element, name: str, link: Link) -> None:
    found = Xml.SubElement(root, "link", name=name)
    inertial = Xml.SubElement(found, "inertial")
    Xml.SubElement(inertial, "origin", xyz=_vector(link.centre), rpy="0 0 0")
    Xml.SubElement(inertial, "mass", value=_number(link.mass))
    m = link.inertia
    Xml.SubElement(
        inertial, "inertia", ixx=_number(m[0, 0]), iyy=_number(m[1, 1]), izz=_number(m[2, 2]),
        ixy=_number(m[0, 1]), ixz=_number(m[0, 2]), iyz=_number(m[1, 2]),
    )  # fmt: skip
    low, high = link.box
    for kind in ("visual", "collision"):
        shape = Xml.SubElement(found, kind)
        Xml.SubElement(shape, "origin", xyz=_vector((low + high) / 2), rpy="0 0 0")
        box = Xml.SubElement(shape, "geometry")
        Xml.SubElement(box, "box", size=_vector(high - low))


def _small_link(root: Xml.Element, name: str) -> None:
    inertial = Xml.SubElement(Xml.SubElement(root, "link", name=name), "inertial")
    Xml.SubElement(inertial, "mass", value=_number(LEAST_MASS))
    small = _number(LEAST_INERTIA)
    Xml.SubElement(inertial, "inertia", ixx=small, iyy=small, izz=small, ixy="0", ixz="0", iyz="0")


def _vector(values: Iterable[float]) -> str:
    return " ".join(_number(value) for value in values)


def _number(value: float) -> str:
    return f"{float(value):.9g}"

"""SOFA: the chain as articulations with springs, whose rest angles follow the pressure.

SOFA is on no package registry that softact's tests reach, so this scene was never run. It uses the
ArticulatedSystemPlugin; names of components are those of SOFA 23.12.
"""

from __future__ import annotations

import numpy as np

from softact.export.chain import AXES, Chain, Drive
from softact.export.job import Job
from softact.export.statement import quoted

MM = 1e3


def files(job: Job) -> dict[str, str | bytes]:
    """The scene, a Python file for runSofa."""
    name = f"{job.name}_sofa.py"
    return {name: text(job.chain, job.about, name)}


def text(chain: Chain, about: list[str], file: str) -> str:
    """The scene: a script with the chain's numbers in it, lengths in mm, masses in kg, so that
    forces are in mN and moments in mN·mm."""
    drives = [
        {
            "component": drive.component,
            "axis": list(AXES[drive.component]),
            "slides": drive.component == "stretch",
            "stiffness": _stiffness(drive, len(chain.links) - 1).tolist(),
            "rest": (drive.rest * (MM if drive.component == "stretch" else 1.0)).tolist(),
        }
        for drive in chain.drives
    ]
    links = [
        {
            "joint": (link.joint * MM).tolist(),
            "mass": float(link.mass),
            "centre": (link.centre * MM).tolist(),
        }
        for link in chain.links
    ]
    return SCENE.format(
        about=quoted(about),
        file=file,
        name=chain.name,
        damping=chain.slowness,
        gravity=(chain.gravity * MM).tolist(),
        pressure=chain.drives[0].pressure.tolist() if chain.drives else [0.0],
        links=_lines(links),
        drives=_lines(drives),
        tip=(chain.tip * MM).tolist(),
    )


def _stiffness(drive: Drive, joints: int) -> np.ndarray:
    """(rows,) of one joint: mN·mm per radian, or mN/mm."""
    whole = drive.stiffness + drive.stiffening * joints
    return whole * (1.0 if drive.component == "stretch" else MM * MM)


def _lines(items: list[dict]) -> str:
    return "[\n" + "".join(f"    {item!r},\n" for item in items) + "]"


SCENE = '''\
"""{about}

This scene was written without SOFA at hand and has never been run.
Units: mm, kg, s, so forces are in mN. runSofa {file}; set PRESSURE below, in kPa.
"""

import numpy as np
import Sofa
import Sofa.Core

PRESSURE = 0.0
GRAVITY = {gravity}
TABLE = {pressure}
TIP = {tip}
LINKS = {links}
DRIVES = {drives}


class Pressure(Sofa.Core.Controller):
    """Sets rest angles and stiffnesses of the joints to those at a pressure."""

    def __init__(self, joints, springs, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.joints, self.springs, self.pressure = joints, springs, PRESSURE

    def onAnimateBeginEvent(self, event):
        rest, stiffness = at(self.pressure)
        with self.joints.rest_position.writeable() as places:
            places[:] = np.array(rest).reshape(places.shape)
        self.springs.stiffness.value = stiffness


def at(pressure):
    """Rest values and stiffnesses of all joints, link after link."""
    rest = [np.interp(pressure, TABLE, drive["rest"]) for drive in DRIVES]
    stiffness = [np.interp(pressure, TABLE, drive["stiffness"]) for drive in DRIVES]
    return rest * (len(LINKS) - 1), stiffness * (len(LINKS) - 1)


def createScene(root):
    root.gravity = GRAVITY
    root.dt = 0.001
    for plugin in (
        "ArticulatedSystemPlugin", "Sofa.Component.LinearSolver.Direct", "Sofa.Component.Mass",
        "Sofa.Component.ODESolver.Backward", "Sofa.Component.SolidMechanics.Spring",
        "Sofa.Component.StateContainer",
    ):
        root.addObject("RequiredPlugin", name=plugin)
    root.addObject("DefaultAnimationLoop")
    chain = root.addChild("{name}")
    chain.addObject("EulerImplicitSolver", rayleighStiffness={damping!r})
    chain.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixd")
    rest, stiffness = at(PRESSURE)
    joints = chain.addObject(
        "MechanicalObject", name="joints", template="Vec1d", position=[0.0] * len(rest),
        rest_position=rest,
    )
    springs = chain.addObject(
        "RestShapeSpringsForceField", points=list(range(len(rest))), stiffness=stiffness
    )
    chain.addObject("ArticulatedHierarchyContainer")
    rigid = chain.addChild("links")
    # A joint of several components has frames between; only the last of them has the mass.
    centres = chain.addChild("joints")
    places, masses = [[*LINKS[0]["joint"], 0, 0, 0, 1]], [LINKS[0]["mass"]]
    for number in range(1, len(LINKS)):
        step = [b - a for a, b in zip(LINKS[number - 1]["joint"], LINKS[number]["joint"])]
        for order, drive in enumerate(DRIVES):
            child = len(places)
            places.append([*LINKS[number]["joint"], 0, 0, 0, 1])
            masses.append(LINKS[number]["mass"] if order == len(DRIVES) - 1 else 1e-9)
            node = centres.addChild(f"joint_{{number}}_{{drive['component']}}")
            node.addObject(
                "ArticulationCenter", parentIndex=child - 1, childIndex=child,
                posOnParent=step if order == 0 else [0, 0, 0], posOnChild=[0, 0, 0],
            )
            node.addChild("articulation").addObject(
                "Articulation", translation=drive["slides"], rotation=not drive["slides"],
                rotationAxis=drive["axis"], articulationIndex=child - 1,
            )
    frames = rigid.addObject("MechanicalObject", name="frames", template="Rigid3d", position=places)
    for number, mass in enumerate(masses):
        node = rigid.addChild(f"mass_{{number}}")
        node.addObject("MechanicalObject", template="Rigid3d", position=[0, 0, 0, 0, 0, 0, 1])
        node.addObject("UniformMass", totalMass=mass)
        node.addObject("RigidRigidMapping", index=number)
    rigid.addObject(
        "ArticulatedSystemMapping", input1=joints.getLinkPath(), output=frames.getLinkPath()
    )
    tip = rigid.addChild("tip")
    tip.addObject("MechanicalObject", name="tip", template="Vec3d", position=TIP, showObject=True)
    tip.addObject("RigidMapping", index=len(places) - 1)
    chain.addObject(Pressure(joints, springs, name="pressure"))
    return root
'''

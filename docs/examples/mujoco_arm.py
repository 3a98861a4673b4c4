"""A MuJoCo arm with an exported finger as its hand, beside the finite-element runs.

    softact sweep configs/sweeps/pneunet_tip_loads.yaml
    softact export results/pneunet_tip_loads --to mujoco -o finger
    python docs/examples/mujoco_arm.py finger/pneunet_small.xml results/.runs/??/*

The arm (three joints with position servos) holds the finger level, as the runs have it; at each
pressure the finger comes to rest, without and with the force on its tip.
"""

import importlib.util
import sys
from pathlib import Path

import mujoco
import numpy as np

ARM = """
<mujoco>
  <option integrator="implicitfast" gravity="0 0 -9.81"/>
  <default>
    <geom type="capsule" size="0.02" rgba="0.5 0.5 0.5 1" contype="0" conaffinity="0"/>
    <joint axis="0 1 0" damping="2"/>
    <position kp="4000" kv="100"/>
  </default>
  <worldbody>
    <body name="upper"><joint name="shoulder"/><geom fromto="0 0 0 0.2 0 0"/>
      <body name="fore" pos="0.2 0 0"><joint name="elbow"/><geom fromto="0 0 0 0.2 0 0"/>
        <body name="hand" pos="0.2 0 0"><joint name="wrist"/><geom fromto="0 0 0 0.03 0 0"/>
          <site name="flange" pos="0.05 0 0"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position joint="shoulder"/><position joint="elbow"/><position joint="wrist"/>
  </actuator>
</mujoco>
"""
POSE = (-0.9, 1.3, -0.4)  # radians; they add up to a level hand
STILL, MOST_STEPS = 1e-4, 30000  # rad/s


def arm_with(finger_xml: Path):
    """The model of arm and finger, and what drives the finger: see the module beside the file."""
    spec = mujoco.MjSpec.from_string(ARM)
    finger = mujoco.MjSpec.from_file(str(finger_xml))
    spec.option.timestep = finger.option.timestep
    spec.attach(finger, site="flange", prefix="finger_")
    model = spec.compile()
    path = finger_xml.with_name(f"{finger_xml.stem}_mujoco.py")
    loaded = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(loaded)
    loaded.loader.exec_module(module)
    return model, module.Actuator(model, "finger_")


def rest(model, data, tip_force) -> None:
    """Let everything come to rest under a force (N, in the world's directions) on the tip."""
    tip = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, "finger_tip")
    last = model.site_bodyid[tip]
    for _ in range(MOST_STEPS):
        data.qfrc_applied[:] = 0
        place = data.site_xpos[tip].copy()
        mujoco.mj_applyFT(
            model, data, np.asarray(tip_force, float), np.zeros(3), place, last, data.qfrc_applied
        )
        mujoco.mj_step(model, data)
        if np.abs(data.qvel).max() < STILL and data.time > 0.2:
            return


def angles(finger_xml: Path, pressures, tip_force) -> list[float]:
    """Degrees from the hand to the tip at each pressure (kPa), at rest."""
    model, finger = arm_with(finger_xml)
    data = mujoco.MjData(model)
    data.qpos[:3], data.ctrl[:3] = POSE, POSE
    found = []
    for pressure in pressures:
        finger.set_pressure(data, pressure)
        data.time = 0.0
        rest(model, data, tip_force)
        found.append(float(np.degrees(finger.angle(data))))
    return found


def main(finger_xml: str, *folders: str) -> None:
    """Print the angles of arm and finite elements."""
    from softact.export.states import spec_of
    from softact.results.folder import read

    for folder in folders:
        run = read(folder)
        force = next((s.payload.force for s in spec_of(run).steps if s.payload), (0.0, 0.0, 0.0))
        curve, inflating = run.curve, run.curve["step"] == "inflate"
        rows = np.flatnonzero(inflating)[2::3]
        pressures = curve["pressure_kPa"][rows]
        print(f"tip force {force} N")
        for p, solved, found in zip(
            pressures, curve["bending_angle_deg"][rows],
            angles(Path(finger_xml), pressures, force), strict=True,
        ):  # fmt: skip
            apart = 100 * (found / solved - 1)
            print(
                f"  {p:6.2f} kPa  finite elements {solved:7.2f}°  arm {found:7.2f}°  {apart:+.2f} %"
            )


if __name__ == "__main__":
    main(*sys.argv[1:])

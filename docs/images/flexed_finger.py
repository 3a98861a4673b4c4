"""The flexed index finger that configs/sweeps/flexed_index_finger.yaml follows, and its picture.

    .venv/bin/python docs/images/flexed_finger.py points configs/sweeps/flexed_index_finger.csv
    .venv/bin/python docs/images/flexed_finger.py picture RESULTS docs/images/flexed_finger.png

Joint angles: mean functional flexion of the fingers, Hume, Gellman, McKellop and Brumfield, J Hand
Surg 15A (1990) 240-243. Lengths between the joints of the index finger, and of the soft tissue at
its tip: Buryanov and Kotiuk, Int J Morphol 28 (2010) 755-758, table I. The line is that of the
bones: straight from joint to joint. Where it begins before the first joint is assumed.
"""

import argparse
from itertools import pairwise
from pathlib import Path

import numpy as np

ANGLES = {
    "metacarpophalangeal": 61.0,
    "proximal interphalangeal": 60.0,
    "distal interphalangeal": 39.0,
}
PHALANGES = (39.78, 22.38, 15.82 + 3.84)  # mm; the last with its soft tissue
BEFORE = 14.0  # mm of the metacarpal on which the actuator is clamped: assumed
SPACING = 2.0  # mm between points, at most


def corners() -> np.ndarray:
    """Where the line begins, its joints and its tip: (5, 2) x and z, mm."""
    turned = np.deg2rad(np.concatenate([[0.0], np.cumsum(list(ANGLES.values()))]))
    directions = np.column_stack([np.cos(turned), -np.sin(turned)])
    ways = np.array([BEFORE, *PHALANGES])[:, None] * directions
    return np.vstack([[0.0, 0.0], np.cumsum(ways, axis=0)])


def points(height: float) -> np.ndarray:
    """Points (n, 2) of the line, its corners among them. height: z of its beginning, mm."""
    ends, found = corners(), []
    for one, two in pairwise(ends):
        count = int(np.ceil(np.linalg.norm(two - one) / SPACING))
        found.append(one + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (two - one))
    return np.vstack([*found, ends[-1:]]) + np.array([0.0, height])


def picture(results: Path, target: Path) -> None:
    """The actuator of a run at its start and its end, and the line that it is to follow."""
    import matplotlib.pyplot as plt
    from matplotlib.collections import LineCollection

    from softact.results.folder import read

    found = read(results)
    faces = found.surfaces["symmetry"][:, :3]
    figure, axes = plt.subplots(figsize=(7.0, 6.0), layout="constrained")
    for number, colour in ((0, "0.8"), (len(found.increments) - 1, "#3b7ea1")):
        places = (found.points + found.field(number, "displacement"))[:, [0, 2]]
        edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]))
        axes.add_collection(LineCollection(places[np.unique(edges, axis=0)], colors=colour, lw=0.5))
    line, joints = points(height=1.0), corners() + np.array([0.0, 1.0])
    axes.plot(*line.T, ".", color="#c4451c", ms=5, label="points of the flexed finger")
    axes.plot(*joints.T, "o", mfc="none", mec="#c4451c", ms=9, label="its joints and its tip")
    pressure = found.curve["pressure_kPa"][-1]
    far = found.curve["target_distance_max_mm"][-1]
    axes.set_title(f"at {pressure:g} kPa no point is more than {far:.2f} mm from the layer")
    axes.set(aspect="equal", xlabel="x (mm)", ylabel="z (mm)")
    axes.autoscale_view()
    axes.legend(loc="upper right", frameon=False)
    figure.savefig(target, dpi=110)


def main() -> None:
    """What the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=["points", "picture"])
    parser.add_argument("files", type=Path, nargs="+")
    given = parser.parse_args()
    if given.what == "points":
        rows = [f"{x:.3f},{z:.3f}" for x, z in points(height=1.0)]
        given.files[0].write_text("\n".join(["x (mm),z (mm)", *rows]) + "\n", encoding="utf-8")
    else:
        picture(*given.files)


if __name__ == "__main__":
    main()

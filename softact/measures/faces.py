"""Where faces are that move as a plate does, and how far they have turned."""

from __future__ import annotations

from typing import TYPE_CHECKING

from softact.measures.base import Measure, vector_columns

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    # Imported here: listing the measures shall not wait for dolfinx.
    from scipy.spatial.transform import Rotation

    from softact.bodies.constraints import ConstrainedFace
    from softact.measures.snapshot import best_rotation

    model = snapshot.model
    names = [b.made_of.surface for b in model.bodies if isinstance(b, ConstrainedFace)]
    names += [surface for field, surface in model.load_terms if field == "torque"]
    columns: dict[str, float] = {}
    for name in dict.fromkeys(names):
        motion = snapshot.motion(name)
        turn = Rotation.from_matrix(best_rotation(motion)).as_rotvec(degrees=True)
        columns |= vector_columns(f"face_{name}_<xyz>_mm", motion.centre_after)
        columns |= vector_columns(f"face_{name}_turn_<xyz>_deg", turn)
    return columns


FACES = Measure(
    "faces",
    "places and turns of the faces that have a constraint or a torque",
    {f"face_<surface>_{c}_mm": f"coordinate {c} of the middle of the face" for c in "xyz"}
    | {
        f"face_<surface>_turn_{c}_deg": f"component {c} of the rotation vector; its length is "
        "the angle, up to half a turn"
        for c in "xyz"
    },
    _evaluate,
)

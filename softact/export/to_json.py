"""JSON: the reduced model in numbers; ``softact.export.rod.Rod`` makes a model of it again."""

from __future__ import annotations

import numpy as np

from softact.export.job import Job
from softact.export.rod import blocking_lever
from softact.files.text import json_text

MODEL = "model.json"
SCHEMA = "softact reduced model 1"


def document(job: Job) -> dict:
    """What the file holds. Units stand in the names; N·mm² and N for the stiffnesses."""
    model = job.model
    table = dict(model.data["table"])
    length = model.data["active_length_mm"]
    for name in model.data["components"]:
        rest, stiff = (np.array(table[f"{part}_{name}"]) for part in ("rest", "stiffness"))
        if name == "stretch":
            table |= {"elongation_mm": rest * length, "blocked_pull_N": rest * stiff}
            continue
        table |= {
            f"{name}_angle_deg": np.degrees(rest * length),
            f"{name}_stiffness_Nmm_per_rad": stiff / length,
            f"{name}_blocked_moment_Nmm": rest * stiff,
        }
        if name.startswith("bending"):
            lever = blocking_lever(length, model.data["end_mm"])
            table[f"{name}_blocked_force_N"] = rest * stiff * lever
    return {
        "schema": SCHEMA,
        "about": job.about,
        "damping_ratio": job.damping_ratio,
        **model.data,
        "table": table,
        "deviations": [vars(deviation) for deviation in job.seen],
        "deviations_unseen": [vars(deviation) for deviation in job.unseen[1]] if job.unseen else [],
    }


def files(job: Job) -> dict[str, str | bytes]:
    """``model.json``."""
    return {MODEL: json_text(document(job))}

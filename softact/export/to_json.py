"""JSON: the reduced model in numbers; ``softact.export.rod.Rod`` makes a model of it again."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from softact.export.job import Job
from softact.files import json_text, write_atomic

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
            table[f"{name}_blocked_force_N"] = rest * stiff * blocking_lever(model.data)
    return {
        "schema": SCHEMA,
        "about": job.about,
        "damping_ratio": job.damping_ratio,
        **model.data,
        "table": table,
        "deviations": [vars(deviation) for deviation in job.seen],
        "deviations_unseen": [vars(deviation) for deviation in job.unseen[1]] if job.unseen else [],
    }


def blocking_lever(data: dict) -> float:
    """1/mm: force across the tip by the moment of the pressure, where the force holds the tip's
    centre on the axis and lets it turn; small deflections."""
    beyond, whole = data["end_mm"], data["active_length_mm"] + data["end_mm"]
    return 1.5 * (whole**2 - beyond**2) / (whole**3 - beyond**3)


def write(job: Job, directory: Path) -> list[Path]:
    """Write ``model.json``."""
    path = directory / "model.json"
    write_atomic(path, json_text(document(job)))
    return [path]

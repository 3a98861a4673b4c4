"""What every exported file says of itself: what it was fitted to, how far it is off, what is
assumed."""

from __future__ import annotations

import re
from collections.abc import Sequence
from importlib.metadata import version
from typing import Any
from xml.etree.ElementTree import Comment

import numpy as np

from softact.export.errors import Deviation
from softact.export.reduced import Reduced
from softact.export.stiffness import FITTED, OF_MODULE
from softact.results.folder import INCOMPLETE

Unseen = tuple[str, Sequence[Deviation]] | None


def lines(
    model: Reduced, seen: Sequence[Deviation], unseen: Unseen, damping_ratio: float
) -> list[str]:
    """Plain sentences for the head of a file."""
    origin = model.origin
    return [
        f"{model.data['name']}: reduced model, written by softact {version('softact')}",
        f"from {origin.source}{': ' if origin.fitted else '; beside '}{compared_with(model)}",
        f"verdict on {origin.verdict}",
        *(f"deviation from the {origin.beside}, {text}" for text in deviations(seen)),
        *(_unseen(unseen) if origin.fitted else []),
        *(f"stiffness of {name}: {why}" for name, why in model.data["stiffness_from"].items()),
        *assumptions(damping_ratio),
    ]


def comment(about: Sequence[str]) -> Any:
    """The lines as a comment of XML, in which no two hyphens may follow each other."""
    text = "\n  ".join(re.sub("-(?=-)", "- ", line) for line in about)
    return Comment(f"\n  {text}\n")


def quoted(about: Sequence[str]) -> str:
    """The lines as they may stand between the triple quotes of a script in Python."""
    return "\n".join(about).replace("\\", "\\\\").replace('"""', "'''")


def deviations(found: Sequence[Deviation]) -> list[str]:
    """One sentence for each figure."""
    return [deviation.text() for deviation in found]


def _unseen(unseen: Unseen) -> list[str]:
    if unseen is None:
        return ["deviation of states that a fit did not see: too few states to say"]
    how, found = unseen
    return [f"deviation of {how}, {text}" for text in deviations(found)]


def compared_with(model: Reduced) -> str:
    """The states and their ranges in words."""
    found = model.states
    force = np.linalg.norm(found.force, axis=1).max()
    left = "; ".join(f"{n} left out {why}" for why, n in found.left_out.items() if n)
    pulled = f", forces on the tip up to {force:.3g} N" if force > 0 else ", no force on the tip"
    weight = ", its weight" if np.abs(found.gravity).max() > 0 else ", no weight"
    return (
        f"{len(found)} states, {found.pressure.min():.4g} to {found.pressure.max():.4g} kPa"
        f"{pulled}{weight}" + (f" ({left})" if left else "")
    )


def assumptions(damping_ratio: float) -> list[str]:
    """What no run tells."""
    return [
        "assumed: masses and inertia from the densities of the spec and the undeformed mesh; air, "
        "tubes and fittings have none",
        f"assumed: damping in proportion to the stiffness, {damping_ratio:g} of critical in the "
        "first bending vibration; no run tells it",
        "assumed: equilibrium follows the pressure at once; viscosity of the material and flow of "
        "the air are left out",
    ]


def warnings(model: Reduced) -> list[str]:
    """What a user should know before relying on it."""
    ended = [
        f"{run.directory}: the run is {run.status.replace('_', ' ')}; its states so far are taken"
        for run in model.runs
        if run.status == INCOMPLETE
    ]
    found = [
        f"stiffness of {name} is {why}"
        for name, why in model.data["stiffness_from"].items()
        if why not in (FITTED, OF_MODULE) and name.startswith("bending")
    ]
    if found:
        found.append(
            "run the actuator under several payloads and export these runs together: see "
            "configs/sweeps/pneunet_tip_loads.yaml"
        )
    return [*ended, *found]

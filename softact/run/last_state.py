"""Whether the last state of a spec can be found without those before."""

from __future__ import annotations

from softact.spec import Spec

#: Loads that are what they are, whichever way they were reached.
OF_NO_WAY = {"pressure", "gravity", "traction", "payload", "torque", "surface_pressure"}


def why_not(spec: Spec) -> str:
    """Why the last state of a spec cannot be sought at once; empty where it can."""
    if spec.sheets or spec.layout().repeats:
        return "it is of sheets, or a module"
    if spec.obstacles or any(contact.friction for contact in spec.contact or ()):
        return "what touches may depend on the way"
    for step in spec.steps:
        if step.supports is not None:
            return "its supports change"
        if set(step.loads) - OF_NO_WAY:
            return "a load depends on the way"
        if step.timing(spec.geometry.layout()) is not None:
            return "it goes in time"
    if any(support.turn or support.move for support in spec.supports or ()):
        return "its supports move"
    return ""

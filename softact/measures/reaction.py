"""What the clamp exerts on the actuator."""

from softact.measures.base import Measure, vector_columns


def _evaluate(snapshot):
    if not snapshot.layout.clamp:
        return {}
    force, moment = snapshot.reaction
    return vector_columns("reaction_<xyz>_N", force) | vector_columns(
        "reaction_moment_<xyz>_Nmm", moment
    )


REACTION = Measure(
    "reaction",
    "force and moment that the clamp exerts on the whole actuator",
    {f"reaction_{c}_N": f"force of the clamp along {c}" for c in "xyz"}
    | {
        f"reaction_moment_{c}_Nmm": f"moment of the clamp about {c}, taken at the origin"
        for c in "xyz"
    },
    _evaluate,
)

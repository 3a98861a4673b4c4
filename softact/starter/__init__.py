"""First specs: from what an actuator shall do, its size and its material to a spec that runs.

A family is one file in ``specs/``: what it says of itself (see ``Family``), a line ``---`` and the
spec, a template of jinja. Every geometry of the registry that has no file there gets its parameters
with their defaults.
"""

from softact.starter.families import MOTIONS, Family, families, family, for_motion
from softact.starter.writing import Wanted, write

__all__ = ["MOTIONS", "Family", "Wanted", "families", "family", "for_motion", "write"]

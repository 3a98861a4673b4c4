"""Bodies, one kind a file; ``BODIES`` holds the kinds by their key."""

from softact.bodies.base import BodyKind, InModule
from softact.bodies.carried_mass import CarriedMasses
from softact.bodies.constraints import Constraints
from softact.bodies.spring import Springs

BODIES: dict[str, BodyKind] = {
    kind.key: kind
    for kind in (
        InModule("materials", "softact.bodies.regions"),
        InModule("layers", "softact.bodies.layer"),
        InModule("sheets", "softact.bodies.sheet_bending"),
        Springs(),
        CarriedMasses(),
        Constraints(),
    )
}

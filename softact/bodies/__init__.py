"""Bodies, one kind a file; ``BODIES`` holds the kinds in the order in which a model makes them."""

from softact.bodies.base import BodyKind
from softact.bodies.layer import Layers
from softact.bodies.sheet_bending import Sheets
from softact.bodies.solid import Solids
from softact.bodies.spring import Springs

BODIES: dict[str, BodyKind] = {kind.key: kind for kind in (Solids(), Layers(), Sheets(), Springs())}

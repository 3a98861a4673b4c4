"""Loads, one kind a file; ``LOADS`` holds them by their key in a spec's step."""

from softact.loads.air import Exhaust, Sealed, Supply
from softact.loads.ambient import Ambient
from softact.loads.base import Load
from softact.loads.cavity_pressure import Pressure
from softact.loads.gravity import Gravity
from softact.loads.injection import Injection
from softact.loads.obstacles import Obstacles
from softact.loads.payload import PayloadLoad
from softact.loads.surface_pressure import SurfacePressure
from softact.loads.torque import TorqueLoad
from softact.loads.traction import TractionLoad
from softact.loads.wrench import WrenchLoad

LOADS: dict[str, Load] = {}
#: The load of each field of a state.
BY_FIELD: dict[str, Load] = {}


def register(load: Load) -> None:
    """Make a load known to specs, states, checkpoints and the reference."""
    LOADS[load.key] = load
    BY_FIELD.update(dict.fromkeys(load.fields, load))


for _load in (
    Gravity(),
    Pressure(),
    Injection(),
    Supply(),
    Exhaust(),
    Sealed(),
    Ambient(),
    TractionLoad(),
    PayloadLoad(),
    TorqueLoad(),
    WrenchLoad(),
    SurfacePressure(),
    Obstacles(),
):
    register(_load)

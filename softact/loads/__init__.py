"""Loads, one kind a file; ``LOADS`` holds them by their key in a spec's step."""

from softact.loads.base import Load
from softact.loads.cavity_pressure import Pressure
from softact.loads.gravity import Gravity
from softact.loads.injection import Injection
from softact.loads.obstacles import Obstacles
from softact.loads.payload import PayloadLoad
from softact.loads.surface_pressure import SurfacePressure
from softact.loads.torque import TorqueLoad
from softact.loads.traction import TractionLoad

LOADS: dict[str, Load] = {
    load.key: load
    for load in (
        Gravity(),
        Pressure(),
        Injection(),
        TractionLoad(),
        PayloadLoad(),
        TorqueLoad(),
        SurfacePressure(),
        Obstacles(),
    )
}
#: The load of each field of a state.
BY_FIELD: dict[str, Load] = {field: load for load in LOADS.values() for field in load.fields}

"""Pressure in each cavity."""

from softact.measures.base import Measure, per_cavity


def _evaluate(snapshot):
    pressures = snapshot.state["pressure"]
    names = snapshot.layout.cavities
    if not names:
        return {}
    return per_cavity("pressure_<cavity>_kPa", {n: 1e3 * float(pressures.get(n, 0)) for n in names})


PRESSURE = Measure(
    "pressure",
    "pressure above ambient",
    {"pressure_<cavity>_kPa": "pressure in the cavity, above ambient"},
    _evaluate,
)

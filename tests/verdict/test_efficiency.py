"""Work on a load by the exergy of the air: closed forms of a rigid vessel, and a run."""

from types import SimpleNamespace

import numpy as np
import pytest

from softact import spec
from softact.loads.gas_flow import AMBIENT
from softact.results.folder import read
from softact.run import start as runs
from softact.sweep import record
from softact.verdict import efficiency


def vessel(lifted):
    """1000 mm³ filled to 40 kPa after the load was hung on it; lifted (n,) mJ on the way."""
    pressure = np.concatenate([[0.0, 0.0], np.linspace(0, 40, len(lifted) + 1)[1:]])
    energy = np.concatenate([[0.0, -5.0], -5.0 + np.asarray(lifted)])
    return SimpleNamespace(
        curve={
            "step": np.array(["hang"] * 2 + ["fill"] * len(lifted)),
            "pressure_kPa": pressure,
            "cavity_volume_mm3": np.full(len(pressure), 1000.0),
            "payload_energy_mJ": energy,
        }
    )


def test_air_of_a_rigid_vessel():
    """Taken in p V, of exergy p V ln(1 + p/p₀); the load counts from where it hung."""
    found = efficiency.liftings(vessel([1.0, 2.0, 3.0, 4.0]))
    pressures = np.array([10, 20, 30, 40]) / 1e3
    exergy = pressures * 1000 * np.log1p(pressures / AMBIENT)
    assert [one.exergy for one in found] == pytest.approx(exergy)
    assert [one.lifted for one in found] == pytest.approx([1, 2, 3, 4])
    most = efficiency.lifting(vessel([1.0, 2.0, 3.0, 4.0]))
    assert most.pressure == 40 and most.efficiency == pytest.approx(4 / exergy[3])
    (line,) = efficiency.lines(vessel([1.0, 2.0, 3.0, 4.0]))
    assert line.startswith("the load is lifted with an efficiency of 30.054% at 40 kPa")


def test_a_load_that_sinks_is_not_lifted():
    sinking = vessel([-1.0, -2.0])
    assert efficiency.lifting(sinking) is None and list(efficiency.lines(sinking)) == []
    assert efficiency.figures(sinking) == {"efficiency_percent": 0.0}
    del sinking.curve["payload_energy_mJ"]
    assert efficiency.figures(sinking) == {}


HUNG = """
geometry: {type: pneunet, chambers: 2, mesh_size: 6 mm, cavity_mesh_size: 4 mm}
materials: {body: {law: neo_hookean, c10: 0.14 MPa, density: 1130 kg/m^3}}
masses: [{mass: 1 g}]
steps: [{name: hang, gravity: [0, 0, 1]}, {name: lift, pressure: 5 kPa}]
measures: [pressure, volume, bending, tip, energy]
"""


def test_a_finger_that_lies_on_its_back_lifts_its_mass(tmp_path):
    runs.run(spec.loads(HUNG), tmp_path / "run", processes=1, report=False)
    results = read(tmp_path / "run")
    percent = results.summary["efficiency_percent"]
    energy, volume = results.curve["payload_energy_mJ"], results.curve["cavity_volume_mm3"]
    hung = int(np.flatnonzero(results.curve["step"] == "hang")[-1])
    absolute = results.curve["pressure_kPa"] / 1e3 + AMBIENT
    taken = absolute * volume - AMBIENT * volume[hung]
    share = (energy - energy[hung])[hung + 1 :] / (taken * np.log(absolute / AMBIENT))[hung + 1 :]
    assert percent == pytest.approx(100 * share[-1], rel=1e-9) and percent > 0
    assert any("the load is lifted with an efficiency" in n for n in results.run["notes"])
    # A sweep's table has it, too.
    assert record.from_results("key", results, 1.0).measures["efficiency_percent"] == percent

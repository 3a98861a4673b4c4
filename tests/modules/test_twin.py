"""A reduced model of a module's table, without a fit: beside the rod and in two simulators."""

import json
import runpy

import numpy as np
import pytest

from softact.errors import SpecError
from softact.export import FORMATS, page, statement
from softact.files.text import write_atomic
from softact.modules import rod_run, table_file, twin
from softact.spec import Spec
from tests.export.test_formats import settle
from tests.modules.test_rod import SPEC


@pytest.fixture(scope="module")
def chain(tmp_path_factory):
    spec = Spec.model_validate(SPEC)
    nowhere = tmp_path_factory.mktemp("table") / "none"
    made = table_file.made_or_read(spec, nowhere, False, lambda text: None)
    return rod_run.Chain(spec, made.table)


@pytest.fixture(scope="module")
def run(chain):
    return rod_run.run(chain, 6)


@pytest.fixture(scope="module")
def job(chain, run):
    return twin.prepare(chain, run)


@pytest.fixture(scope="module")
def last(job):
    """The last state: pressure, force, weight, angle in degrees, tip."""
    found = job.model.states
    return (
        float(found.pressure[-1]),
        found.force[-1],
        found.gravity[-1],
        np.degrees(found.turned[-1, 1]),
        found.tip[-1],
    )


def test_it_is_the_rod_but_for_what_it_leaves_out(job, run):
    seen = {deviation.name: deviation for deviation in job.seen}
    assert seen["bending angle"].percent < 1.0
    assert seen["tip's place"].percent < 1.0
    assert seen["volume"].percent < 1.0
    angles = [row["bending_angle_deg"] for row in run.rows]
    assert np.degrees(job.model.states.turned[:, 1]) == pytest.approx(angles, abs=1e-9)
    assert statement.warnings(job.model) == []
    head = "\n".join(job.about)
    assert "deviation from the states of the rod of modules, bending angle" in head
    assert "finite-element" not in head and "did not see" not in head


def test_its_mass_is_that_of_the_actuator(job, chain):
    lumps, body = chain.table.lumps, job.model.body
    assert body.masses.sum() == pytest.approx(lumps.masses.sum())
    second = np.einsum("n,ni,nj->ij", body.masses, body.places, body.places)
    arms = (lumps.centres - chain.base) @ body.axes.T
    spread = body.axes @ lumps.spreads.sum(axis=0) @ body.axes.T
    assert second == pytest.approx(
        np.einsum("n,ni,nj->ij", lumps.masses, arms, arms) + spread, abs=1e-9 * second.max()
    )


def test_without_a_load_it_stands_as_the_module(job, chain):
    """Curvature, volume and stiffness at no load are those of the table, and of the ends."""
    table, pressure = chain.table, np.array([6e-3])
    (free,) = table.free_curvature(pressure)[table.turns]
    idle, lost = table.ends.at(pressure)
    state = job.model.rod.state(6.0)
    whole = np.degrees((chain.segments.modules - idle) * table.pitch * free)
    assert state["bending_angle_deg"][0] == pytest.approx(whole, rel=1e-3)
    place = np.concatenate([table.free_curvature(pressure), pressure])[None]
    air = -table.energy.first(place)[0, table.k]
    assert state["cavity_volume_mm3"][0] == pytest.approx(
        chain.segments.modules * table.pitch * air - lost[0], rel=1e-4
    )


def test_mujoco_comes_to_rest_where_the_rod_stands(job, last, tmp_path):
    mujoco = pytest.importorskip("mujoco")
    for file, content in FORMATS["mujoco"].files(job).items():
        write_atomic(tmp_path / file, content)
    pressure, force, _, angle, tip = last
    drive = runpy.run_path(str(tmp_path / f"{job.name}_mujoco.py"))
    model = mujoco.MjModel.from_xml_path(str(tmp_path / f"{job.name}.xml"))
    data = mujoco.MjData(model)
    actuator = drive["Actuator"](model)
    actuator.set_pressure(data, pressure)
    place = settle(mujoco, model, data, force)
    joints = [model.joint(n).name for n in range(model.njnt)]
    turned = sum(data.qpos[n] for n, name in enumerate(joints) if name.startswith("bending_y"))
    assert np.degrees(turned) == pytest.approx(angle, rel=0.03)
    assert np.linalg.norm(place - tip) < 0.02 * job.model.body.length


def test_pyelastica_comes_to_rest_where_the_rod_stands(job, last):
    elastica = pytest.importorskip("elastica")
    from tests.export.cosserat_twin import angle_at_rest

    data = json.loads(FORMATS["json"].files(job)["model.json"])
    pressure, force, gravity, angle, _ = last
    found = angle_at_rest(elastica, data, pressure, force, gravity)
    assert found == pytest.approx(angle, rel=0.03)


def test_the_page_says_what_it_is_beside(job):
    text = page.html(job)
    assert "Points are states of the rod of modules" in text
    assert "Of the module, nothing fitted." in text


def test_several_pressures_have_no_reduced_model():
    """Told before anything is solved."""
    arm = {"type": "omnidirectional", "modules": 4}
    given = {"cavity_1": "1 kPa", "cavity_2": "2 kPa"}
    apart = [{"name": "one", "pressure": given}, {"name": "two", "pressure": {"cavity_1": "3 kPa"}}]
    spec = Spec.model_validate(SPEC).with_({"geometry": arm, "steps": apart})
    with pytest.raises(SpecError, match="follows one pressure, and here 2 are driven apart"):
        twin.check(spec)
    rows = {"segment_1_cavity_1": "1 kPa"}
    steps = [{"name": "up", "pressure": rows}]
    spec = spec.with_({"geometry": {**arm, "segments": 2}, "steps": steps})
    with pytest.raises(SpecError, match="each segment has its own"):
        twin.check(spec)

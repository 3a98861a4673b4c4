"""Each file is loaded by the package that it is for and compared with the finite-element states."""

import ast
import importlib.util
import json
import runpy
from pathlib import Path

import numpy as np
import pytest

from softact.errors import SpecError
from softact.export import FORMATS, chain, page, statement, to_fmu, to_urdf
from softact.export.rod import Rod
from softact.fields import STANDARD_GRAVITY
from softact.files.text import csv_rows, write_atomic

ROOT = Path(__file__).parents[2]
ANGLE = 0.03  # of the finite elements' angle


@pytest.fixture(scope="module")
def written(prepared, tmp_path_factory):
    """Folder with the files of all formats that can be written here."""
    folder = tmp_path_factory.mktemp("export")
    for name, found in FORMATS.items():
        if name != "fmu" or importlib.util.find_spec("pythonfmu"):
            files = found.files(prepared)
            assert files
            for file, content in files.items():
                write_atomic(folder / file, content)
    return folder


@pytest.fixture(scope="module")
def inflating(prepared):
    """States under full weight and load, with their angles in degrees."""
    found = prepared.model.states
    part = found.part(found.pressure > 1.0)
    return part, np.degrees(part.turned[:, 1])


def test_the_model_meets_the_finite_elements_and_those_it_did_not_see(prepared):
    seen = {deviation.name: deviation for deviation in prepared.seen}
    assert seen["bending angle"].percent < 1.0
    assert seen["tip's place"].percent < 1.0
    assert seen["volume"].percent < 1.0
    how, unseen = prepared.unseen
    assert how.startswith("each run")
    assert {d.name: d for d in unseen}["bending angle"].percent < 100 * ANGLE
    assert prepared.model.data["stiffness_from"]["bending_y"].startswith("fitted")
    assert statement.warnings(prepared.model) == []


def test_volume_under_loads_is_what_the_moments_say(solved, prepared):
    """∂V/∂angle at one pressure, of the finite elements, and of Maxwell's relation."""
    found, rod = prepared.model.states, prepared.model.rod
    last = [np.flatnonzero(found.run == n)[-1] for n in (0, 2)]
    fem = np.diff(found.volume[last]) / np.diff(found.turned[last, 1])
    state = rod.state(found.pressure[last], found.force[last], None, found.gravity[last])
    model = np.diff(state["cavity_volume_mm3"]) / np.diff(np.radians(state["bending_y_deg"]))
    assert fem[0] > 200.0
    assert model == pytest.approx(fem, rel=0.1)


def test_json_is_the_model_again(written, inflating):
    data = json.loads((written / "model.json").read_text())
    states, angles = inflating
    found = Rod(data).state(states.pressure, states.force, states.moment, states.gravity)
    assert found["bending_angle_deg"] == pytest.approx(angles, rel=ANGLE)
    assert data["deviations"][0]["name"] == "bending angle"
    assert "assumed: masses" in "\n".join(data["about"])
    table = data["table"]
    # Moments and angles of the table are one spring's.
    stiff = np.array(table["bending_y_stiffness_Nmm_per_rad"])
    turned = np.radians(table["bending_y_angle_deg"])
    assert stiff * turned == pytest.approx(table["bending_y_blocked_moment_Nmm"])


def test_the_blocked_force_holds_the_tip_on_the_axis(prepared):
    from softact.export.to_json import document

    data = document(prepared)
    small = int(np.argmax(np.array(data["table"]["pressure_kPa"]) > 0.5))
    pressure, force = (
        data["table"][n][small] for n in ("pressure_kPa", "bending_y_blocked_force_N")
    )
    rod = prepared.model.rod
    free, held = (rod.state(pressure, [[0, 0, f]])["tip_z_mm"][0] for f in (0.0, force))
    assert free < -0.1
    assert held == pytest.approx(0.0, abs=0.05 * abs(free))


def settle(mujoco, model, data, force):
    """Let a chain come to rest under a force on its tip."""
    site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, "tip")
    for _ in range(20000):
        data.qfrc_applied[:] = 0
        mujoco.mj_applyFT(model, data, force, np.zeros(3), data.site_xpos[site].copy(),
                          model.site_bodyid[site], data.qfrc_applied)  # fmt: skip
        mujoco.mj_step(model, data)
        if data.time > 0.05 and np.abs(data.qvel).max() < 1e-4:
            return data.site_xpos[site] * 1e3
    raise AssertionError("the chain does not come to rest")


def test_mujoco_meets_the_finite_elements(written, prepared, inflating):
    mujoco = pytest.importorskip("mujoco")
    drive = runpy.run_path(str(written / f"{prepared.name}_mujoco.py"))
    model = mujoco.MjModel.from_xml_path(str(written / f"{prepared.name}.xml"))
    finger, states, angles = drive["Actuator"](model), *inflating
    assert model.body_mass.sum() == pytest.approx(1e3 * prepared.model.body.masses.sum())
    for n in range(0, len(states), 4):
        data = mujoco.MjData(model)
        finger.set_pressure(data, states.pressure[n])
        tip = settle(mujoco, model, data, states.force[n])
        assert np.degrees(finger.angle(data)) == pytest.approx(angles[n], rel=ANGLE)
        assert tip == pytest.approx(states.tip[n], abs=0.02 * prepared.model.body.length)


def test_an_arm_with_the_finger_meets_the_finite_elements(written, prepared, inflating):
    pytest.importorskip("mujoco")
    example = runpy.run_path(str(ROOT / "docs/examples/mujoco_arm.py"))
    states, angles = inflating
    for run in (0, 1):  # under a force on the tip, and without
        chosen = np.flatnonzero(states.run == run)[[0, -1]]
        found = example["angles"](
            written / f"{prepared.name}.xml", states.pressure[chosen], states.force[chosen[0]]
        )
        assert found == pytest.approx(angles[chosen], rel=ANGLE)


def test_urdf_has_the_shape_of_the_finite_elements(written, prepared, inflating):
    """Loaded by MuJoCo, its joints set by the table: the tip of a state without payload."""
    mujoco = pytest.importorskip("mujoco")
    text = (written / f"{prepared.name}.urdf").read_text()
    text = text.replace(
        "<link", '<mujoco><compiler fusestatic="false" discardvisual="false"/></mujoco><link', 1
    )
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    heads, *rows = csv_rows(written / f"{prepared.name}_joints.csv")
    table = {name: np.array([float(row[n]) for row in rows]) for n, name in enumerate(heads)}
    states, _ = inflating
    last = np.flatnonzero(states.run == 1)[-1]
    state = prepared.model.rod.state(states.pressure[last])
    data.qpos[:] = np.interp(
        states.pressure[last], table["pressure_kPa"], table["bending_y_rest_rad"]
    )
    mujoco.mj_kinematics(model, data)
    assert np.degrees(data.qpos.sum()) == pytest.approx(state["bending_angle_deg"][0], rel=1e-3)
    tip = data.body("tip").xpos * 1e3
    exact = [state[f"tip_{c}_mm"][0] for c in "xyz"]
    # Without the stretch, which the file leaves out and says so.
    assert tip == pytest.approx(exact, abs=0.02 * prepared.model.body.length)
    springs = table["bending_y_stiffness_Nm_per_rad"] * table["bending_y_rest_rad"]
    assert springs == pytest.approx(table["bending_y_moment_Nm"], rel=1e-6, abs=1e-12)


def test_urdf_of_what_only_stretches_is_refused(prepared, monkeypatch):
    only = [drive for drive in prepared.chain.drives if drive.component == "stretch"]
    monkeypatch.setattr(to_urdf, "_turning", lambda chain: [])
    with pytest.raises(SpecError, match="only stretches"):
        to_urdf.files(prepared)
    assert len(only) <= 1


def test_simulink_tables_interpolate_the_finite_elements(written, prepared, inflating):
    from scipy.interpolate import RegularGridInterpolator

    heads, *rows = csv_rows(written / f"{prepared.name}_load.csv")
    table = {name: np.array([float(row[n]) for row in rows]) for n, name in enumerate(heads)}
    p, f = np.unique(table["pressure_kPa"]), np.unique(table["tip_force_z_N"])
    values = table["bending_angle_deg"].reshape(len(f), len(p))
    states, angles = inflating
    found = RegularGridInterpolator((f, p), values)(
        np.column_stack([states.force[:, 2], states.pressure])
    )
    assert found == pytest.approx(angles, rel=ANGLE)


def test_fmu_meets_the_finite_elements(written, prepared, inflating):
    pytest.importorskip("pythonfmu")
    fmpy = pytest.importorskip("fmpy")
    states, angles = inflating
    chosen = np.arange(0, len(states), 3)
    names = [
        "pressure_kPa",
        *(f"tip_force_{c}_N" for c in "xyz"),
        *(f"gravity_{c}_g" for c in "xyz"),
    ]
    values = np.column_stack(
        [states.pressure, states.force, states.gravity / STANDARD_GRAVITY]
    )[chosen]  # fmt: skip
    signals = np.zeros(len(chosen), dtype=[("time", float), *((name, float) for name in names)])
    signals["time"] = np.arange(len(chosen))
    for n, name in enumerate(names):
        signals[name] = values[:, n]
    # The output at the end of a step is of the input at its beginning.
    found = fmpy.simulate_fmu(
        str(written / f"{prepared.name}.fmu"), start_time=0.0, stop_time=float(len(chosen)),
        step_size=1.0, output_interval=1.0, input=signals, output=["bending_angle_deg"],
    )["bending_angle_deg"][1:]  # fmt: skip
    assert found[: len(chosen)] == pytest.approx(angles[chosen], rel=ANGLE)


def test_fmu_without_its_package_is_refused(prepared, monkeypatch):
    monkeypatch.setattr(to_fmu, "find_spec", lambda name: None)
    with pytest.raises(SpecError, match=r"pip install 'softact\[export\]'"):
        to_fmu.files(prepared)


def test_sofa_scene_is_python_with_the_chain_in_it(written, prepared):
    """It was never run: SOFA is on no registry. That it says so, and has the chain's numbers."""
    text = (written / f"{prepared.name}_sofa.py").read_text()
    tree = ast.parse(text)
    assert "has never been run" in ast.get_docstring(tree)
    constants = {
        node.targets[0].id: ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign)
    }
    assert len(constants["LINKS"]) == prepared.model.data["pieces"] + 1
    (bending,) = [d for d in constants["DRIVES"] if d["component"] == "bending_y"]
    angle = np.degrees(sum([bending["rest"][-1]] * prepared.model.data["pieces"]))
    top = prepared.model.rod.state(constants["TABLE"][-1])
    assert angle == pytest.approx(top["bending_angle_deg"][0])
    masses = sum(link["mass"] for link in constants["LINKS"])
    assert masses == pytest.approx(1e3 * prepared.model.body.masses.sum())


def test_cosserat_twin_meets_the_finite_elements(written, inflating):
    """The model's numbers in PyElastica, a Cosserat rod with shear: built from model.json alone."""
    elastica = pytest.importorskip("elastica")
    from .cosserat_twin import angle_at_rest

    data = json.loads((written / "model.json").read_text())
    states, angles = inflating
    for run in (0, 1):
        n = np.flatnonzero(states.run == run)[-1]
        found = angle_at_rest(
            elastica, data, states.pressure[n], states.force[n], states.gravity[n]
        )
        assert found == pytest.approx(angles[n], rel=ANGLE)


def test_the_head_of_each_file_says_how_far_it_is_off(written, prepared):
    head = "deviation from the finite-element states, bending angle: at most"
    (said,) = [line for line in prepared.about if line.startswith(head)]
    name = prepared.name
    for file in (f"{name}.xml", f"{name}.urdf", f"{name}_sofa.py", f"{name}_simulink.txt"):
        assert said in (written / file).read_text()


def test_the_page_shows_model_and_states(prepared):
    text = page.html(prepared)
    for words in ("Points are finite-element states", "tip force 0, 0, -0.05 N", "bending angle",
                  "Stiffness of bending", "each run by a fit to the others"):  # fmt: skip
        assert words in text


def test_damping_is_that_of_the_first_vibration(prepared):
    """A cantilever of one mode: c = 2 ζ k / ω, and ω of a uniform beam by its series."""
    found = chain.chain_of(prepared.model, 0.25)
    drive = next(d for d in found.drives if d.component == "bending_y")
    omega = chain.first_frequency(prepared.model)
    assert drive.damping / drive.stiffness == pytest.approx(2 * 0.25 / omega)
    body = prepared.model.body
    stiff = prepared.model.data["table"]["stiffness_bending_y"][0] * 1e-6
    mass, length = 1e3 * body.masses.sum(), 1e-3 * body.length
    assert omega == pytest.approx(3.516 * np.sqrt(stiff / (mass * length**3)), rel=1e-3)


def test_comments_survive_hyphens():
    assert "--" not in statement.comment(["a--b---c", "d"]).text

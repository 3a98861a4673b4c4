"""Sensitivities of whole runs: the table, resuming, two processes, where they end, bad input."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from mpi4py import MPI

from softact import spec as specs
from softact.errors import SpecError
from softact.geometry.base import make_mesh
from softact.run import start
from softact.run.worker import solve
from softact.sensitivities.choosing import Chosen
from softact.sensitivities.parameters import chosen, parameters
from softact.sensitivities.table import kept, unit_of_slope

BLOCK = """
geometry: {type: block, length: 6 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
materials: {body: {law: neo_hookean, c10: 0.02 MPa}}
supports: [{surface: x_min, fix: [x, y, z]}]
solver: {initial_increment: 0.3, max_increment: 0.3}
steps:
  - {name: first, payload: {surface: x_max, force: [0 N, 0 N, -10 mN]}}
  - name: second
    supports: [{surface: x_min, fix: [x, y, z]}, {surface: x_max, fix: [z]}]
    traction: {surface: y_max, value: [1 kPa, 0 kPa, 0 kPa]}
"""
RUBBING = """
geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
materials: {body: {law: neo_hookean, c10: 0.02 MPa}}
supports: [{surface: z_max, fix: [x, y, z]}]
obstacles: {table: {type: plane, point: [0 mm, 0 mm, -0.1 mm], normal: [0, 0, 1], friction: 0.3}}
solver: {initial_increment: 0.5, max_increment: 0.5}
steps: [{name: up, obstacles: {table: {move: [0 mm, 0 mm, 0.3 mm]}}}]
"""
PATHS = ("geometry.length", "materials.body.c10", "steps.0.payload.force.2")


class Killed(BaseException):
    """Stands for a kill."""


def run(text: str, folder: Path, paths=PATHS, after: int | None = None, again: bool = False):
    """The lines of the table of a run in this process, which is killed after some increments."""
    spec, count = specs.loads(text), 0
    mesh = folder.parent / "mesh.msh"
    make_mesh(spec.geometry, mesh, curved=spec.solver.curved)
    job, _ = Chosen(spec, paths).job(folder.parent)

    def tell(event):
        nonlocal count
        count += event["stage"] == "increment"
        if after is not None and count > after:
            raise Killed

    try:
        solve(MPI.COMM_SELF, spec, mesh, folder, {}, tell, again, [], job)
    except Killed:
        return []
    with (folder / "sensitivities.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def slopes(lines, measure):
    """(increment, parameter) -> derivative of one measure."""
    return {
        (line["increment"], line["parameter"]): float(line["derivative"])
        for line in lines
        if line["measure"] == measure
    }


@pytest.mark.parametrize("after", [3, 7])
def test_a_resumed_run_has_the_same_derivatives(tmp_path, after):
    """Killed inside the first step, and inside the second, whose supports begin where it was."""
    whole = run(BLOCK, tmp_path / "whole")
    run(BLOCK, tmp_path / "killed", after=after)
    resumed = run(BLOCK, tmp_path / "killed", again=True)
    assert len(resumed) == len(whole)
    for measure in ("tip_z_mm", "tip_x_mm", "strain_energy_mJ"):
        one, other = slopes(whole, measure), slopes(resumed, measure)
        assert len(one) > 20
        scale = max(map(abs, one.values()))
        assert other == pytest.approx(one, abs=1e-5 * scale)


def test_two_processes_give_the_same_derivatives(tmp_path):
    spec, found = specs.loads(BLOCK.replace("4 mm}", "3 mm}")), []
    for count in (1, 2):
        folder = tmp_path / str(count)
        start.run(spec, folder, count, report=False, threads=1, sensitivities=PATHS)
        with (folder / "sensitivities.csv").open(encoding="utf-8") as file:
            found.append(slopes(list(csv.DictReader(file)), "tip_z_mm"))
    assert len(found[0]) > 20
    scale = max(map(abs, found[0].values()))
    assert found[1] == pytest.approx(found[0], abs=1e-5 * scale)


def test_an_earlier_run_without_them_does_not_go_on_with_them(tmp_path):
    spec = specs.loads(BLOCK)
    make_mesh(spec.geometry, tmp_path / "mesh.msh")
    solve(MPI.COMM_SELF, spec, tmp_path / "mesh.msh", tmp_path / "run", {}, lambda event: None)
    longer = BLOCK + "  - {name: third, traction: {surface: y_max, value: [2 kPa, 0 kPa, 0 kPa]}}\n"
    with pytest.raises(SpecError, match="begun without sensitivities"):
        run(longer, tmp_path / "run", again=True)


def test_a_line_of_the_table(tmp_path):
    """A dead load bends a block: δ is proportional to 1/c10, and grows with the load."""
    lines = run(BLOCK, tmp_path / "run")
    (line,) = (
        x for x in lines
        if (x["step"], x["step_fraction"], x["measure"]) == ("first", "1.0", "strain_energy_mJ")
        and x["parameter"] == "materials.body.c10"
    )  # fmt: skip
    assert (line["at"], line["unit"]) == ("20 kPa", "mJ/kPa")
    value, slope = float(line["value"]), float(line["derivative"])
    assert float(line["elasticity"]) == pytest.approx(slope * 20 / value, rel=1e-5)
    assert float(line["elasticity"]) == pytest.approx(-1, abs=0.05)  # W = F δ / 2


def test_with_friction_they_end_where_something_touches(tmp_path):
    lines = run(RUBBING, tmp_path / "run", ("materials.body.c10",))
    assert {line["increment"] for line in lines} == {"0"}
    text = (tmp_path / "run/run.json").read_text(encoding="utf-8")
    assert "not available from 50.00% of step 'up' on: something with friction touches" in text


REMEMBERING = """
geometry: {type: thick_sphere, mesh_size: 8 mm}
materials:
  body:
    law: neo_hookean
    c10: 0.1 MPa
    viscoelastic: {constants: long_time, g: [0.2], tau: [1 s]}
steps: [{name: up, duration: 1 s, pressure: 5 kPa}]
"""
FILLED = """
geometry: {type: thick_sphere, mesh_size: 8 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
steps: [{name: up, duration: 10 ms, supply: {pressure: 5 kPa, diameter: 0.5 mm}}]
"""
EMPTIED = """
geometry: {type: thick_sphere, mesh_size: 8 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
steps:
  - {name: out, duration: 10 ms, exhaust: {diameter: 0.5 mm}}
"""
MOVING = """
geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa, density: 1000 kg/m^3}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps: [{name: drop, duration: 1 ms, gravity: [0, 0, -1], dynamics: true}]
"""


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (REMEMBERING, "a material remembers where it has been"),
        (FILLED, "air flows into a cavity"),
        (EMPTIED, "air flows into a cavity"),
        (MOVING, "the actuator moves with inertia"),
    ],
)
def test_none_are_given_of_memory_of_air_or_of_motion(text, why, tmp_path):
    run(text, tmp_path / "run", ("materials.body.c10",))
    assert why in (tmp_path / "run/run.json").read_text(encoding="utf-8")


FAULTS = {
    "geometry.lenght": "geometry has no value 'lenght'; did you mean 'length'?",
    "geometry.mesh_size": "how fine the mesh is",
    "geometry.type": "'block' is no number",
    "solver.tolerance": "it says nothing of the actuator",
    "steps.0.payload": "stands for several values",
    "obstacles.table.friction": "with friction a state depends on the way",
}


@pytest.mark.parametrize("path", FAULTS)
def test_what_is_no_parameter_is_told_in_a_line(path):
    spec = specs.loads(BLOCK + "obstacles: {table: {type: plane, point: [0 mm, 0 mm, -9 mm], "
                       "normal: [0, 0, 1]}}\n")  # fmt: skip
    with pytest.raises(SpecError) as raised:
        chosen(spec, [path, "geometry.length"])
    (line,) = raised.value.lines
    assert line.startswith(f"-p {path}: ")
    assert FAULTS[path] in line


def test_a_whole_number_has_no_derivative():
    spec = specs.loads(
        "geometry: {type: pneunet}\nmaterials: {body: ecoflex-00-30}\nsteps: [{pressure: 1 kPa}]"
    )
    with pytest.raises(SpecError, match="'8' is a whole number, and has no derivative"):
        chosen(spec, ["geometry.chambers"])


def test_lengths_whose_planes_coincide_are_refused_by_name_and_else_left_out(tmp_path):
    """The tunnel is as wide as the chambers: there is no mesh of the same cells where it is not."""
    spec = specs.loads(
        "geometry: {type: slow_pneunet, tunnel_width: 8 mm, mesh_size: 8 mm}\n"
        "materials: {body: ecoflex-00-30, film: ecoflex-00-30}\nsteps: [{pressure: 1 kPa}]"
    )
    with pytest.raises(SpecError, match=r"-p geometry.tunnel_width: planes .* would part"):
        Chosen(spec, ["geometry.tunnel_width"]).job(tmp_path)
    job, notes = Chosen(spec, []).job(tmp_path)
    assert "geometry.tunnel_width" not in job["paths"]
    assert "geometry.roof" in job["paths"]
    (note,) = (note for note in notes if "geometry.tunnel_width" in note)
    assert note.startswith("sensitivities: left out: ")


def test_parameters_are_told_in_the_units_of_the_spec():
    found = {p.path: p for p in parameters(specs.loads(BLOCK))}
    assert (found["materials.body.c10"].told, found["materials.body.c10"].unit) == (20.0, "kPa")
    assert (found["steps.0.payload.force.2"].told, found["steps.0.payload.force.2"].unit) == (
        -10.0, "mN",
    )  # fmt: skip
    assert not found["steps.0.payload.force.0"].usual
    assert "solver.tolerance" not in found
    assert "geometry.mesh_size" not in found


def test_units_of_derivatives():
    assert unit_of_slope("bending_angle_deg", "mm") == "deg/mm"
    assert unit_of_slope("cavity_volume_mm3", "kg/m^3") == "mm^3/(kg/m^3)"
    assert unit_of_slope("max_principal_stretch", "kPa") == "1/kPa"
    assert unit_of_slope("tip_x_mm", "") == "mm"


def test_a_table_that_was_cut_short_keeps_its_whole_lines():
    text = "step,increment,measure\na,0,x\na,1,x\na,2,x\na,2"
    assert kept(text, 2) == "step,increment,measure\na,0,x\na,1,x\n"
    assert kept("", 2) == ""

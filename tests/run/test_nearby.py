"""A run whose last state is found from that of an actuator like it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from softact import spec as specs
from softact.results.folder import read
from softact.run.last_state import why_not
from softact.run.start import run
from softact.sensitivities import stored

FINGER = """
geometry: {type: pneunet, chambers: 2, chamber_length: 7 mm, mesh_size: 6 mm, inner_wall: 1 mm}
materials: {body: elastosil-m4601}
layers: [{surface: strain_limiting_layer, thickness: 0.1 mm, material: paper}]
measures: [pressure, bending, tip, energy, stress, contact]
contact: none
steps:
  - {name: gravity, gravity: [0, 0, -1]}
  - {name: inflate, pressure: 20 kPa}
"""
PATHS = ("geometry.inner_wall", "geometry.chamber_height", "materials.body.c10")
OTHER = (
    "geometry.inner_wall=1.1 mm",
    "geometry.chamber_height=15 mm",
    "materials.body.c10=100 kPa",
)


def solved(folder: Path, changes=(), near=None, text=FINGER, paths=PATHS):
    """Last row, counts, notes and last derivatives of a run."""
    spec = specs.loads(text, overrides=changes)
    run(spec, folder, report=False, threads=1, sensitivities=paths, near=near)
    found, table = read(folder), stored.read(folder)
    last = len(found.increments) - 1
    slopes = {(s.parameter, s.measure): s.derivative for s in table if s.row == last}
    row = {name: values[-1] for name, values in found.curve.items()}
    return row, found.run["counts"], found.run["notes"], slopes


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    folder = tmp_path_factory.mktemp("first") / "run"
    return folder, solved(folder)


def test_the_last_state_is_that_of_the_run_from_the_beginning(tmp_path, first):
    whole, counts, _, slopes = solved(tmp_path / "whole", OTHER)
    near, fewer, _, there = solved(tmp_path / "near", OTHER, first[0])
    for name in ("bending_angle_deg", "tip_x_mm", "strain_energy_mJ", "max_principal_stress_MPa"):
        assert near[name] == pytest.approx(whole[name], rel=1e-6), name
        for path in PATHS:
            assert there[path, name] == pytest.approx(slopes[path, name], rel=2e-3, abs=1e-6)
    assert fewer["increments"] == 1 < counts["increments"]
    assert fewer["factorisations"] < counts["factorisations"] / 3
    assert near["step"] == "inflate" and near["step_fraction"] == 1.0
    # Far from the first actuator's, so that it was no use to leave its state as it is.
    assert abs(first[1][0]["bending_angle_deg"] / whole["bending_angle_deg"] - 1) > 0.01


def test_turns_are_counted_on_from_the_run_nearby(tmp_path, first):
    """The angle is known up to whole turns: the neighbour's says which one it is."""
    text = (first[0] / "curve.csv").read_text(encoding="utf-8")
    folder = tmp_path / "turned"
    folder.mkdir()
    for path in first[0].iterdir():
        (folder / path.name).write_bytes(path.read_bytes())
    header, *rows = text.splitlines()
    at = header.split(",").index("bending_angle_deg")
    cells = rows[-1].split(",")
    cells[at] = repr(float(cells[at]) + 360.0)
    (folder / "curve.csv").write_text("\n".join([header, *rows[:-1], ",".join(cells)]) + "\n")
    written = json.loads((folder / "run.json").read_text())
    written.pop("checksums", None)
    (folder / "run.json").write_text(json.dumps(written))
    near, *_ = solved(tmp_path / "near", (), folder)
    assert near["bending_angle_deg"] == pytest.approx(first[1][0]["bending_angle_deg"] + 360.0)


def test_another_mesh_is_solved_from_the_beginning_and_says_so(tmp_path, first):
    finer = ("geometry.mesh_size=5 mm",)
    _, counts, notes, _ = solved(tmp_path / "finer", finer, first[0], paths=PATHS[2:])
    assert counts["increments"] > 1
    assert any("from the beginning" in note and "other cells" in note for note in notes)


def test_a_state_too_far_away_is_solved_from_the_beginning(tmp_path, first):
    far = ("materials.body.c10=25 kPa",)
    row, counts, notes, _ = solved(tmp_path / "far", far, first[0], paths=PATHS[2:])
    if counts["increments"] > 1:
        assert any("did not get from its state" in note for note in notes)
    whole, *_ = solved(tmp_path / "whole", far, paths=PATHS[2:])
    assert row["bending_angle_deg"] == pytest.approx(whole["bending_angle_deg"], rel=1e-6)


@pytest.mark.parametrize(
    ("more", "why"),
    [
        (
            "obstacles: {t: {type: plane, point: [0 mm, 0 mm, -9 mm], normal: [0, 0, 1]}}\n",
            "touches",
        ),
        ("  - {name: fill, inject: 1 ml}\n", "a load depends on the way"),
        ("  - {name: hold, pressure: 20 kPa, duration: 1 s}\n", "it goes in time"),
        ("supports: [{surface: clamp, move: {x: 1 mm, y: 0 mm, z: 0 mm}}]\n", "its supports move"),
    ],
)
def test_what_depends_on_the_way_is_never_sought_at_once(more, why):
    assert why_not(specs.loads(FINGER)) == ""
    assert why in why_not(specs.loads(FINGER + more))


def test_what_rubs_depends_on_the_way():
    auto = FINGER.replace("contact: none", "contact: auto")
    assert why_not(specs.loads(auto)) == ""
    rubs = FINGER.replace("contact: none", "contact: [{self: outer, friction: 0.2}]")
    assert "touches may depend on the way" in why_not(specs.loads(rubs))


def test_an_actuator_that_touches_itself_is_solved_from_the_beginning(tmp_path):
    """And one that does not touch, but whose neighbour does, too."""
    auto = FINGER.replace("contact: none\n", "")
    row, *_ = solved(tmp_path / "first", text=auto, paths=None)
    assert row["contact_area_outside_mm2"] > 0
    again, counts, notes, _ = solved(
        tmp_path / "near", ["geometry.inner_wall=1.05 mm"], tmp_path / "first", auto, None
    )
    assert any("that actuator touches itself" in note for note in notes)
    assert counts["increments"] > 1 and again["contact_area_outside_mm2"] > 0


def test_the_guess_goes_along_with_the_parameters(tmp_path, first):
    """To first order: a hundredth of the change leaves a ten-thousandth of the error."""
    from mpi4py import MPI

    from softact.geometry.base import make_mesh
    from softact.run.from_spec import build_model
    from softact.run.nearby import nearby

    errors = []
    for wall in (1.04, 1.01):
        spec = specs.loads(FINGER, overrides=[f"geometry.inner_wall={wall} mm"])
        make_mesh(spec.geometry, tmp_path / "mesh.msh", curved=spec.solver.curved)
        model = build_model(MPI.COMM_SELF, spec, tmp_path / "mesh.msh")
        found = nearby(model, spec, first[0])
        folder = tmp_path / f"{wall}"
        run(spec, folder, report=False, threads=1)
        exact = nearby(model, spec, folder)
        assert not isinstance(found, str) and not isinstance(exact, str)
        moved = model.displacement_dofs
        errors.append(np.linalg.norm((found.guesses[0] - exact.guesses[-1])[moved]))
        assert errors[-1] < np.linalg.norm((found.guesses[-1] - exact.guesses[-1])[moved])
    assert errors[1] < errors[0] / 10

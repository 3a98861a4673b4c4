"""The result folder: what is written is read back, and a killed run never looks complete."""

import csv
import json
import os
import random
import signal
import time
from itertools import pairwise
from pathlib import Path

import h5py
import meshio
import numpy as np
import pytest

from softact.errors import SpecError
from softact.results import writer as results_writer
from softact.results.folder import read
from softact.results.writer import ResultsWriter
from tests import bent_beam

SMALL = {"nx": 2, "ny": 2, "nz": 7}
INCREMENTS = 4


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    directory = tmp_path_factory.mktemp("runs") / "new" / "beam"
    bent_beam.write(directory, angle_deg=200.0, increments=INCREMENTS)
    return directory


def test_meshio_reads_every_increment(folder):
    points, cells, _ = bent_beam.mesh()
    with meshio.xdmf.TimeSeriesReader(folder / "fields.xdmf") as reader:
        read_points, read_cells = reader.read_points_cells()
        assert np.array_equal(read_points, points)
        assert [block.type for block in read_cells] == ["tetra10"]
        assert np.array_equal(read_cells[0].data, cells)
        assert reader.num_steps == INCREMENTS + 1
        for number in range(INCREMENTS + 1):
            time_, nodal, cellwise = reader.read_data(number)
            exact = bent_beam.state(points, 200.0 * number / INCREMENTS)
            assert time_ == number / INCREMENTS
            assert np.array_equal(nodal["displacement"], exact["displacement"])
            assert np.allclose(nodal["von_mises"], exact["von_mises"], rtol=1e-6, atol=1e-9)
            assert set(nodal) == set(exact)
            assert not cellwise["region"][0].any()


def test_h5py_reads_fields_and_surfaces(folder):
    points, _, surfaces = bent_beam.mesh()
    exact = bent_beam.state(points, 200.0)
    with h5py.File(folder / "fields.h5") as file:
        last = file["increments"]["00004"]
        assert last["displacement"].dtype == np.float64
        assert np.array_equal(last["displacement"][()], exact["displacement"])
        stored = file["mesh/surfaces"]
        assert set(stored) == set(surfaces)
        assert np.array_equal(stored["tip"][()], surfaces["tip"])


def test_vtk_reads_the_collection(folder):
    """VTK's reader is ParaView's. Its mid-side nodes must lie in the middle of VTK's edges."""
    pyvista = pytest.importorskip("pyvista")
    reader = pyvista.XdmfReader(str(folder / "fields.xdmf"))
    assert reader.time_values == [n / INCREMENTS for n in range(INCREMENTS + 1)]
    reader.set_active_time_value(1.0)
    grid = reader.read()
    points, cells, _ = bent_beam.mesh()
    assert grid.n_cells == len(cells)
    assert set(grid.celltypes) == {pyvista.CellType.QUADRATIC_TETRA}
    exact = bent_beam.state(points, 200.0)["displacement"]
    assert np.allclose(grid.point_data["displacement"], exact)
    length, width, height = bent_beam.LENGTH, bent_beam.HALF_WIDTH, bent_beam.HEIGHT
    wall = bent_beam.WALL
    channel = (length - 2 * wall) * (width - wall) * (height - 2 * wall)
    assert grid.volume == pytest.approx(length * width * height - channel, rel=1e-6)


def test_numbers_of_the_curve_keep_all_digits(tmp_path):
    awkward = [0.1 + 0.2, 1 / 3, 1e-17, -7.0, float(np.float32(0.1))]
    writer = ResultsWriter(tmp_path / "r", "name: r\n", {})
    for value in awkward:
        writer.increment({"step": "a, b", "value_N": np.float64(value)})
    with open(tmp_path / "r" / "curve.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["value_N"]) for row in rows] == awkward
    assert rows[0]["step"] == "a, b"


def test_a_column_that_comes_later_is_empty_before(tmp_path):
    writer = ResultsWriter(tmp_path / "r", "", {})
    writer.increment({"a_mm": 1.0})
    writer.increment({"a_mm": 2.0, "b_mm": 3.0})
    curve = read(tmp_path / "r").curve
    assert np.isnan(curve["b_mm"][0]) and curve["b_mm"][1] == 3.0


def test_run_json_is_strict_json(tmp_path):
    writer = ResultsWriter(tmp_path / "r", "", {"nan": float("nan"), "n": np.int64(3)})
    writer.finish("no_equilibrium", {"angle_deg": 1.0}, {"array": np.arange(2), "path": Path("a")})
    text = (tmp_path / "r" / "run.json").read_text()
    run = json.loads(text, parse_constant=lambda word: pytest.fail(f"{word} is not JSON"))
    assert run.pop("files").keys() == {"spec.yaml", "curve.csv", "summary.csv"}
    assert len(run.pop("checksum")) == 16
    assert run == {
        "nan": None, "n": 3, "array": [0, 1], "path": "a", "status": "no_equilibrium",
    }  # fmt: skip


def test_the_final_status_is_the_last_thing_written(tmp_path, monkeypatch):
    seen = []
    write = results_writer.write_atomic

    def record(path, data):
        write(path, data)
        run = tmp_path / "r" / "run.json"
        seen.append((path.name, run.exists() and json.loads(run.read_text())["status"]))

    monkeypatch.setattr(results_writer, "write_atomic", record)
    bent_beam.write(tmp_path / "r", increments=2, size=SMALL)
    assert seen[-1] == ("run.json", "complete")
    assert {status for _, status in seen[1:-1]} == {"incomplete"}
    assert {"spec.yaml", "curve.csv", "fields.xdmf", "summary.csv"} <= {name for name, _ in seen}


def test_a_rerun_clears_the_old_results_but_nothing_else(tmp_path):
    directory = tmp_path / "r"
    bent_beam.write(directory, increments=2, size=SMALL)
    (directory / "report.html").write_text("old")
    (directory / "notes.txt").write_text("mine")
    ResultsWriter(directory, "name: new\n", {})
    assert read(directory).status == "incomplete"
    assert sorted(os.listdir(directory)) == ["notes.txt", "run.json", "spec.yaml"]


def test_wrong_use_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(SpecError, match="is a file"):
        ResultsWriter(tmp_path / "file", "", {})
    with pytest.raises(SpecError, match="not a result folder"):
        read(tmp_path)
    writer = ResultsWriter(tmp_path / "r", "", {})
    with pytest.raises(RuntimeError, match="mesh"):
        writer.increment({}, {"displacement": np.zeros((3, 3))})
    with pytest.raises(ValueError, match="incomplete"):
        writer.finish("incomplete")


def test_a_torn_field_file_is_told_not_raised(tmp_path):
    bent_beam.write(tmp_path / "r", increments=2, size=SMALL)
    fields = tmp_path / "r" / "fields.h5"
    fields.write_bytes(fields.read_bytes()[:2000])
    torn = read(tmp_path / "r")
    assert not torn.has_mesh and "fields.h5" in torn.faults[0]
    assert len(torn.curve["pressure_kPa"]) == 3


def test_fields_without_their_row_are_left_out(tmp_path):
    bent_beam.write(tmp_path / "r", increments=2, size=SMALL)
    curve = tmp_path / "r" / "curve.csv"
    curve.write_text("".join(curve.read_text().splitlines(keepends=True)[:-1]))
    assert read(tmp_path / "r").increments == ("00000", "00001")


# ---- kill -9 ----


def _in_child(work, kill_after=None) -> tuple[int, float]:
    """Run ``work`` in a forked process; returns its exit code (-9: killed) and its time (s)."""
    begin = time.perf_counter()
    child = os.fork()
    if child == 0:
        code = 1
        try:
            work()
            code = 0
        finally:
            os._exit(code)
    if kill_after is not None:
        time.sleep(kill_after)
        os.kill(child, signal.SIGKILL)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), time.perf_counter() - begin


def _rerun(directory):
    bent_beam.write(directory, increments=INCREMENTS, size=SMALL, mark="new")


def _check_after_kill(directory, old_rows):
    """Absent, incomplete with a sound curve, or complete and of one piece."""
    if not directory.exists():
        return "absent"
    folder = read(directory)
    rows = len(folder.curve.get("pressure_kPa", ()))
    if folder.status == "incomplete":
        pressures = folder.curve.get("pressure_kPa", np.zeros(0)).tolist()
        new = [bent_beam.PRESSURE * number / INCREMENTS for number in range(INCREMENTS + 1)]
        # Killed while the old files were being removed: they are still of one piece.
        old = [bent_beam.PRESSURE * number / (old_rows - 1) for number in range(old_rows)]
        assert pressures == new[:rows] or pressures == old
        return "incomplete"
    assert folder.status == "complete"
    expected = INCREMENTS + 1 if folder.run.get("mark") == "new" else old_rows
    assert rows == expected == len(folder.increments)
    assert folder.summary["pressure_kPa"] == bent_beam.PRESSURE
    return "complete"


@pytest.mark.parametrize("old_rows", [0, 3])
@pytest.mark.parametrize("call", ["replace", "rename", "unlink", "mkdir"])
def test_killed_before_each_step_of_writing(tmp_path, call, old_rows):
    """SIGKILL before the n-th call that changes the folder, for every n."""
    outcomes = []
    for number in range(200):
        directory = tmp_path / str(number)
        if old_rows:
            bent_beam.write(directory, increments=old_rows - 1, size=SMALL)

        def killed(number=number, directory=directory):
            real, calls = getattr(os, call), iter(range(number))

            def deadly(*args, **options):
                if next(calls, None) is None:
                    os.kill(os.getpid(), signal.SIGKILL)
                return real(*args, **options)

            setattr(os, call, deadly)
            _rerun(directory)

        code, _ = _in_child(killed)
        outcomes.append(_check_after_kill(directory, old_rows))
        if code == 0:
            break
        assert code == -signal.SIGKILL
    assert code == 0 and outcomes[-1] == "complete"
    if call == "replace":
        assert outcomes.count("incomplete") > 2 * INCREMENTS


@pytest.mark.parametrize("old_rows", [0, 3])
def test_killed_at_random_moments(tmp_path, old_rows):
    _, duration = _in_child(lambda: _rerun(tmp_path / "timing"))
    chance = random.Random(20)
    outcomes = set()
    for number in range(40):
        directory = tmp_path / str(number)
        if old_rows:
            bent_beam.write(directory, increments=old_rows - 1, size=SMALL)
        _in_child(lambda directory=directory: _rerun(directory), chance.uniform(0, duration))
        outcomes.add(_check_after_kill(directory, old_rows))
    assert "incomplete" in outcomes


def lying(path, name, shape):
    """Give a dataset of fields.h5 a size that its file cannot hold, as a flipped bit does."""
    with h5py.File(path, "a") as file:
        parent, _, last = name.rpartition("/")
        del file[name]
        # Never written: HDF5 makes up the numbers when it is read.
        file[parent].create_dataset(last, shape=shape, dtype="f8", chunks=(1000, 3))


def test_an_array_larger_than_its_file_is_not_read(tmp_path):
    """24 GB out of a file of some kB: all memory, or the kernel's killer."""
    directory = tmp_path / "beam"
    bent_beam.write(directory, angle_deg=20.0, increments=1)
    lying(directory / "fields.h5", "increments/00001/displacement", (10**9, 3))
    results = read(directory)
    with pytest.raises(
        SpecError, match=r"displacement would take 2.4e\+10 bytes, and the file has"
    ):
        results.field(1, "displacement")
    lying(directory / "fields.h5", "mesh/points", (10**9, 3))
    changed, fault = read(directory).faults
    assert "fields.h5: is not as the run wrote it" in changed
    assert "/mesh/points would take 2.4e+10 bytes" in fault


def test_a_stored_spec_is_read_within_bounds(tmp_path):
    directory = tmp_path / "beam"
    bent_beam.write(directory, angle_deg=20.0, increments=1)
    bomb = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
        f"{b}: &{b} [{', '.join([f'*{a}'] * 9)}]\n" for a, b in pairwise("abcdefghi")
    )
    for text in (
        bomb,
        "{",
        "[1]",
        "",
        "!!python/object:os.system {}",
        "a: [" + "1," * 30_000 + "]",
    ):
        (directory / "spec.yaml").write_text(text)
        assert read(directory).spec == {}
    (directory / "spec.yaml").write_text("name: größe\n", encoding="utf-8")
    assert read(directory).spec == {"name": "größe"}


def test_a_run_json_that_is_nested_without_end_is_told(tmp_path):
    (tmp_path / "run.json").write_text("[" * 100_000)
    with pytest.raises(SpecError, match=r"run.json: is damaged \((maximum recursion|Stack overfl)"):
        read(tmp_path)

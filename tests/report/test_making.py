"""A report that is begun before its run has ended is the report of the run."""

import json

import numpy as np
import pytest

from softact import spec as specs
from softact.report import curves, making, write_report
from softact.results.folder import read
from softact.run import start as runs
from softact.run.ahead import Ahead
from tests import bent_beam

MADE = "report.html", "curve.png", "states.png", "shape.png"
PULLED = """
geometry: {type: block, length: 8 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps: [{name: pull, traction: {surface: x_max, value: [20 kPa, 0 kPa, 6 kPa]}}]
"""


def made(folder):
    return {name: (folder / name).read_bytes() for name in MADE}


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A result folder, and the files of its report as it is made afterwards."""
    folder = tmp_path_factory.mktemp("making") / "r"
    bent_beam.write(folder, 90.0, 2)
    write_report(folder)
    return folder, made(folder)


@pytest.fixture
def unfinished(written):
    """Takes the end out of the folder's run.json, and puts it back."""
    folder, _ = written
    path = folder / "run.json"
    whole = path.read_text()
    data = json.loads(whole)
    path.write_text(json.dumps({"status": "incomplete", "spec_hash": data["spec_hash"]}))
    for name in MADE:
        (folder / name).unlink()
    yield folder, lambda: path.write_text(whole)
    path.write_text(whole)


def begun_and_written(folder, end, monkeypatch):
    """The report begun without the run's end and written with it, and how often it was drawn."""
    drawn, draw = [], curves.picture
    monkeypatch.setattr(
        curves, "picture", lambda results: drawn.append(results.status) or draw(results)
    )
    with making.Report(folder) as report:
        report.prepare()
        report.begin("complete")
        end()
        report.write((), lambda line: None, None)
    return made(folder), drawn


def test_it_is_the_same_report(written, unfinished, monkeypatch):
    folder, end = unfinished
    found, drawn = begun_and_written(folder, end, monkeypatch)
    assert found == written[1]
    assert drawn == ["complete"]  # as it was told, and once


def test_what_could_not_be_begun_is_made_at_the_end(written, unfinished, monkeypatch):
    """Its drawing process has been given pictures already."""
    folder, end = unfinished
    calls, sections = [], making._materials

    def fails_once(results):
        calls.append(results)
        return sections(results) if len(calls) > 1 else 1 / 0

    monkeypatch.setattr(making, "_materials", fails_once)
    found, drawn = begun_and_written(folder, end, monkeypatch)
    assert found == written[1] and len(drawn) == 2


def test_a_process_that_draws_and_has_died_is_replaced(written, unfinished, monkeypatch):
    folder, end = unfinished
    prepare = making.Report.prepare

    def dies(report):
        prepare(report)
        report._renderer.process.kill()
        report._renderer.process.wait()

    monkeypatch.setattr(making.Report, "prepare", dies)
    assert begun_and_written(folder, end, monkeypatch)[0] == written[1]


def test_a_run_begins_its_report_ahead(tmp_path, monkeypatch):
    """Nobody hears of it, and what it makes is what the folder alone gives."""
    stages, begun, begin = [], [], making.Report.begin

    def noted(report, status):
        begun.append((status, read(report.directory).status))
        begin(report, status)

    monkeypatch.setattr(making.Report, "begin", noted)
    spec, folder = specs.loads(PULLED), tmp_path / "out"
    assert runs.run(spec, folder, progress=lambda e: stages.append(e["stage"])).status == "complete"
    assert begun == [("complete", "incomplete")]
    assert set(stages) == {"mesh", "solve", "increment", "done", "report"}
    ahead = made(folder)
    write_report(folder)
    assert made(folder) == ahead


def test_nothing_is_done_ahead_where_runs_lie_beside_each_other(tmp_path, monkeypatch):
    monkeypatch.setattr(making.Report, "prepare", lambda report: 1 / 0)
    with Ahead(tmp_path, wanted=False) as ahead:
        ahead.meshed()
        ahead.solved("complete")
        assert ahead._thread is None


def test_a_run_that_is_broken_off_leaves_no_process_that_draws(tmp_path):
    with pytest.raises(KeyboardInterrupt), Ahead(tmp_path) as ahead:
        ahead.meshed()
        while ahead._report is None or ahead._report._renderer is None:
            np.linalg.svd(np.ones((20, 20)))
        raise KeyboardInterrupt
    assert ahead._report._renderer.process.poll() is not None

"""The cache of runs: each computed once, whoever asks, and never taken when damaged."""

import errno
import json
import multiprocessing
import os
import threading
import time

import numpy as np
import pytest

from softact import spec as specs
from softact.errors import MeshError, SpecError
from softact.results.folder import read
from softact.run.start import CannotWriteError, SolverCrashError
from softact.sweep import compute as computing
from softact.sweep.cache import BusyError, Cache
from softact.sweep.compute import compute
from softact.sweep.local import run_all
from softact.sweep.version import run_key
from tests.sweep.folders import instead_of_run

SPEC = specs.loads(
    "geometry: {type: block}\nmaterials: {body: {law: neo_hookean, c10: 0.1 MPa}}\n"
    "steps: [{name: hang, gravity: [0, 0, -1]}]"
)
KEY = run_key(SPEC)


@pytest.fixture(autouse=True)
def without_solver(monkeypatch):
    monkeypatch.setattr(computing, "run", instead_of_run)


@pytest.fixture
def cache(tmp_path):
    lines = []
    made = Cache(tmp_path / "runs", warn=lines.append)
    made.lines = lines
    return made


def journal(cache):
    path = cache.directory / "journal.csv"
    return path.read_text().splitlines() if path.exists() else []


def test_second_time_it_is_read(cache):
    first, second = (compute(SPEC, KEY, cache) for _ in range(2))
    assert (first.cached, second.cached, len(journal(cache))) == (False, True, 1)
    assert first.record.measures == second.record.measures
    assert np.array_equal(first.record.table, second.record.table)


def test_record_is_the_result_folder(cache):
    found = compute(SPEC, KEY, cache).record
    results = read(cache.folder(KEY))
    assert np.array_equal(found.curve("bending_angle_deg"), results.curve["bending_angle_deg"])
    assert found.measures["bending_angle_deg"] == 10.0 * SPEC.geometry.length
    assert found.steps == ("inflate",) * 5
    assert not list((cache.directory / "tmp").iterdir())


@pytest.mark.parametrize(
    ("name", "how"),
    [
        ("record.json", "cut"),
        ("record.json", "changed"),
        ("fields.h5", "cut"),
        ("fields.h5", "gone"),
        ("curve.csv", "gone"),
    ],
)
def test_damaged_run_is_computed_anew_and_told(cache, name, how):
    before = compute(SPEC, KEY, cache).record
    path = cache.folder(KEY) / name
    raw = path.read_bytes()
    if how == "gone":
        path.unlink()
    else:
        path.write_bytes(raw[: len(raw) // 2] if how == "cut" else raw.replace(b"1", b"2", 3))
    again = compute(SPEC, KEY, cache)
    assert not again.cached
    assert np.array_equal(again.record.table, before.table)
    assert len(cache.lines) == 1
    assert str(cache.folder(KEY)) in cache.lines[0] and "damaged" in cache.lines[0]
    assert compute(SPEC, KEY, cache).cached


def test_two_threads_compute_it_once(cache, monkeypatch):
    def slow(*arguments, **options):
        time.sleep(0.2)
        instead_of_run(*arguments, **options)

    monkeypatch.setattr(computing, "run", slow)
    answers = []
    threads = [
        threading.Thread(target=lambda: answers.append(compute(SPEC, KEY, cache))) for _ in range(2)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(answer.cached for answer in answers) == [False, True]
    assert len(journal(cache)) == 1


def _hold(folder, ready, leave):
    with Cache(folder).lock(KEY):
        ready.set()
        leave.wait(30)
        os._exit(9)  # without a word, as at a kill


def test_lock_of_another_process_is_respected_and_dies_with_it(cache):
    fork = multiprocessing.get_context("spawn")
    ready, leave = fork.Event(), fork.Event()
    other = fork.Process(target=_hold, args=(cache.directory, ready, leave))
    other.start()
    assert ready.wait(30)
    with pytest.raises(BusyError):
        compute(SPEC, KEY, cache, wait=False)
    left = cache.directory / "tmp" / f"{KEY}.12345"
    left.mkdir()
    leave.set()
    answers = list(run_all({KEY: lambda: SPEC}, cache, 1))  # waits for the lock
    other.join()
    assert [answer.cached for answer in answers] == [False]
    assert not left.exists()


@pytest.mark.parametrize(
    ("error", "status", "transient"),
    [
        (MeshError("block: gmsh crashed"), "failed", False),
        (SolverCrashError("the solver was killed by signal 9"), "failed", True),
    ],
)
def test_failures_are_answers_and_not_kept(cache, monkeypatch, error, status, transient):
    def fails(*arguments, **options):
        raise error

    monkeypatch.setattr(computing, "run", fails)
    answer = compute(SPEC, KEY, cache)
    assert (answer.status, answer.cause) == (status, error.lines[0])
    assert (answer.transient, answer.record) == (transient, None)
    monkeypatch.setattr(computing, "run", instead_of_run)
    assert compute(SPEC, KEY, cache).status == "complete"


def test_no_run_begins_after_one_that_the_caller_stops_at(cache, monkeypatch):
    """Else what a study had planned would go on unseen in the process that has left it."""
    begun = []

    def fails(*arguments, **options):
        begun.append(arguments)
        raise MeshError("block: gmsh crashed")

    monkeypatch.setattr(computing, "run", fails)
    answers = run_all({KEY[:-1] + end: lambda: SPEC for end in "0123"}, cache, 1)
    assert next(answers).status == "failed"
    threads = threading.active_count()
    time.sleep(0.2)
    assert len(begun) == 1
    answers.close()
    while threads <= threading.active_count():
        time.sleep(0.01)
    assert len(begun) == 1


@pytest.mark.parametrize("at_the_end", [False, True])
def test_full_disk_ends_it_in_one_line_and_keeps_the_rest(cache, monkeypatch, at_the_end):
    other = SPEC.model_copy(update={"measures": ("bending",)})
    kept = compute(other, run_key(other), cache)

    def full(*arguments, **options):
        raise OSError(errno.ENOSPC, "No space left on device", "curve.csv")

    if at_the_end:
        monkeypatch.setattr("softact.sweep.record.store", full)
    else:
        monkeypatch.setattr(computing, "run", full)
    with pytest.raises(CannotWriteError) as found:
        list(run_all({KEY: lambda: SPEC}, cache, 1))
    assert found.value.lines == [f"{cache.directory}: the disk is full; what was finished is kept"]
    assert cache.find(kept.key) is not None
    assert cache.find(KEY) is None
    assert not list((cache.directory / "tmp").iterdir())


def test_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "runs").write_text("a file")
    with pytest.raises(SpecError, match=r"runs: cannot be written .*--cache"):
        Cache(tmp_path / "runs")


def test_no_equilibrium_is_kept_with_its_cause(cache, monkeypatch):
    def stops(spec, directory, **options):
        instead_of_run(spec, directory, "no_equilibrium")
        path = directory / "run.json"
        story = json.loads(path.read_text()) | {"messages": ["no equilibrium beyond 12 kPa"]}
        path.write_text(json.dumps(story))

    monkeypatch.setattr(computing, "run", stops)
    answer = compute(SPEC, KEY, cache)
    assert (answer.status, answer.cause) == ("no_equilibrium", "no equilibrium beyond 12 kPa")
    assert compute(SPEC, KEY, cache).cached

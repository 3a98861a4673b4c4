"""A folder is written by one process at a time, and a killed one holds nothing."""

import signal
import subprocess
import sys
import threading
import time

import pytest

from softact.cli import main as cli
from softact.converge import carry
from softact.errors import CannotWriteError, FolderBusyError, SpecError
from softact.files.lock import LOCK, held
from tests import bent_beam

HOLD = """
import subprocess, sys, time
from pathlib import Path
from softact.files.lock import held

with held(Path("out"), "run") as inherited:
    if "child" in sys.argv:
        subprocess.Popen(["sleep", "60"], pass_fds=inherited)
    print("held", flush=True)
    time.sleep(60)
"""


@pytest.fixture
def holder(tmp_path):
    """A function that starts another process, which holds the folder ``out``."""
    started = []

    def start(*arguments):
        process = subprocess.Popen(
            [sys.executable, "-c", HOLD, *arguments],
            cwd=tmp_path,
            stdout=subprocess.PIPE,
            start_new_session=True,
        )
        started.append(process)
        assert process.stdout.readline() == b"held\n"
        return process

    yield start
    for process in started:
        process.kill()
        process.wait()
        process.stdout.close()


def test_second_is_refused_with_one_line(tmp_path, holder):
    other = holder()
    with pytest.raises(FolderBusyError) as refused, held(tmp_path / "out", "report"):
        pass
    (line,) = refused.value.lines
    assert line.startswith(f"{tmp_path / 'out'}: softact run (process {other.pid} on ")
    assert refused.value.exit_code == 2


def test_killed_holder_holds_nothing(tmp_path, holder):
    other = holder()
    other.send_signal(signal.SIGKILL)
    other.wait()
    assert (tmp_path / "out" / LOCK).exists()
    with held(tmp_path / "out", "run"):
        pass
    assert not (tmp_path / "out" / LOCK).exists()


def test_held_until_the_process_that_inherits_it_ends(tmp_path, holder):
    other = holder("child")
    other.send_signal(signal.SIGKILL)
    other.wait()
    with pytest.raises(FolderBusyError), held(tmp_path / "out", "run"):
        pass
    subprocess.run(["pkill", "-KILL", "-s", str(other.pid), "sleep"], check=True)
    with held(tmp_path / "out", "run"):
        pass


def test_new_folder_has_its_first_files_and_goes_where_nothing_is_added(tmp_path):
    folder = tmp_path / "results" / "finger"
    with held(folder, "run", {"run.json": "{}"}):
        assert sorted(path.name for path in folder.iterdir()) == [LOCK, "run.json"]
    assert not (tmp_path / "results").exists()
    with held(folder, "run", {"run.json": "{}"}):
        (folder / "curve.csv").write_text("a\n1\n")
    assert sorted(path.name for path in folder.iterdir()) == ["curve.csv", "run.json"]


def test_what_was_there_before_stays(tmp_path):
    with held(tmp_path, "run", {"run.json": "{}"}):
        assert [path.name for path in tmp_path.iterdir()] == [LOCK]
    assert tmp_path.exists() and not list(tmp_path.iterdir())


def test_one_of_many_at_once(tmp_path):
    """Twenty threads on a folder that comes and goes: never two of them inside."""
    inside, most, refused = [], [], []

    def work():
        for _ in range(10):
            try:
                with held(tmp_path / "a" / "b", "run"):
                    inside.append(None)
                    most.append(len(inside))
                    time.sleep(0.001)
                    inside.pop()
            except FolderBusyError as error:
                refused.append(error)

    threads = [threading.Thread(target=work) for _ in range(20)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert max(most) == 1 and len(most) + len(refused) == 200
    assert not list(tmp_path.glob("a/*"))


def test_file_and_link_in_its_place(tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(SpecError, match="is a file"), held(tmp_path / "file", "run"):
        pass
    (tmp_path / "mine.txt").write_text("mine")
    (tmp_path / LOCK).symlink_to(tmp_path / "mine.txt")
    with pytest.raises(CannotWriteError), held(tmp_path, "run"):
        pass
    assert (tmp_path / "mine.txt").read_text() == "mine"


CUBE = """
name: cube
geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 2 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps: [{name: pull, traction: {surface: x_max, value: [20 kPa, 0 kPa, 0 kPa]}}]
"""


@pytest.mark.parametrize(
    "command",
    [
        ["run", "{spec}", "-o", "{folder}"],
        ["run", "{spec}", "-o", "{folder}", "--resume"],
        ["report", "{folder}"],
        ["converge", "{spec}", "--into", "{folder}", "--cache", "{tmp}/runs", "-o", "{tmp}/page"],
    ],
    ids=lambda words: " ".join(words[:1] + words[4:5]),
)
def test_command_on_a_folder_that_is_written(tmp_path, capsys, monkeypatch, command):
    """One line, and nothing is changed, also while a run goes on there."""
    monkeypatch.setattr(carry, "check_folder", lambda *given: None)
    folder = tmp_path / "beam"
    bent_beam.write(folder, 20.0, 1)
    (tmp_path / "cube.yaml").write_text(CUBE)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    words = [
        word.format(spec=tmp_path / "cube.yaml", folder=folder, tmp=tmp_path) for word in command
    ]
    with held(folder, "run"):
        code = cli._run(words, debug=False)
    (line,) = capsys.readouterr().err.splitlines()
    assert code == 2 and line.startswith(f"{folder}: softact run (process ")
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    assert not (tmp_path / "page").exists()


def test_a_lock_of_another_program_is_left_alone(tmp_path):
    (tmp_path / LOCK).write_text("pid 12")
    with pytest.raises(CannotWriteError, match="lock is not of softact"), held(tmp_path, "run"):
        pass
    assert (tmp_path / LOCK).read_text() == "pid 12"

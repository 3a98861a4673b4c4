"""What commands may write: folders and files of softact's own; never a file of the user's or one
that they read, and nothing at all where they refuse."""

import csv
import json
import os
import stat
import threading

import numpy as np
import pytest

from softact.cli import main as cli
from softact.errors import SpecError
from softact.files.lock import LOCK
from softact.files.text import csv_text, is_temporary, replacing, write_atomic
from softact.results.folder import read
from softact.results.own_folder import MARKER, Output, check_results
from softact.sweep import compute as computing
from tests import bent_beam

SPEC = """
geometry: {type: block, length: 10 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
steps: [{name: hang, gravity: [0, 0, -1]}]
"""
BASE = "base:" + SPEC.replace("\n", "\n  ")
FILES = {
    "spec.yaml": SPEC,
    "sweep.yaml": BASE + "\naxes: [{path: geometry.length, values: [5 mm, 6 mm]}]\n",
    "opt.yaml": BASE + "\nparameters: [{path: geometry.length, from: 5 mm, to: 9 mm}]\n"
    "objectives: [{measure: bending_angle_deg, goal: maximise}]\ntrials: 2\n",
    "angle.csv": "step_fraction,bending_angle_deg\n0.5,20\n1,40\n",
    "pull.csv": "stretch,nominal stress MPa\n"
    + "".join(f"{s:.2f},{0.2 * (s - s**-2):.5f}\n" for s in np.linspace(1.05, 1.8, 12)),
}
COMMANDS = {
    "sweep": ["sweep", "sweep.yaml"],
    "optimize": ["optimize", "opt.yaml"],
    "calibrate": ["calibrate", "spec.yaml", "--data", "angle.csv", "--vary", "geometry.length"],
    "converge": ["converge", "spec.yaml", "-m", "bending_angle_deg"],
    "compare": ["compare", "one", "two"],
    "fit": ["fit", "pull.csv", "--law", "neo_hookean", "--starts", "1"],
}
#: A file of each command that it writes, with what stands there when it is the user's.
MINE = {
    "sweep": "sweep.csv",
    "optimize": "best/notes.txt",
    "calibrate": "run/thesis.tex",
    "converge": "converge.csv",
    "compare": "curves.csv",
    "fit": "pull.yaml",
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Input files of all commands, two result folders, and a solver that is made up."""
    monkeypatch.chdir(tmp_path)
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    for number, name in enumerate(("one", "two")):
        bent_beam.write(tmp_path / name, 50.0 + number, 2, size={"nx": 6, "ny": 2, "nz": 7})

    def run(spec, directory, **options):
        angle = 4 * spec.geometry.length + 0.1 * spec.geometry.mesh_size**2
        size = {"nx": round(24 / spec.geometry.mesh_size), "ny": 2, "nz": 7}
        bent_beam.write(directory, angle, 2, size=size)

    monkeypatch.setattr(computing, "run", run)
    monkeypatch.setattr("softact.optimise.optimise_page.write_report",
                        lambda folder: (folder / "report.html").touch())  # fmt: skip
    return tmp_path


def softact(capsys, *arguments):
    with pytest.raises(SystemExit) as stop:
        cli.main(arguments)
    out = capsys.readouterr()
    return stop.value.code, out.out, out.err


def everything(folder):
    """Path -> content of every file below a folder, and of every link its target."""
    return {
        str(path.relative_to(folder)): os.readlink(path) if path.is_symlink() else path.read_bytes()
        for path in folder.rglob("*")
        if path.is_symlink() or path.is_file()
    }


def ended(code):
    return code in (0, 1)  # 1: a study that has not converged


@pytest.mark.parametrize("command", COMMANDS)
def test_a_folder_of_the_users_is_not_touched(folder, capsys, command):
    """Also not the current one, where the input is; with --force it is, but for what is read."""
    (folder / "mine").mkdir()
    (folder / "mine" / MINE[command]).parent.mkdir(exist_ok=True)
    (folder / "mine" / MINE[command]).write_text("years of work")
    before = everything(folder)
    for where in ("mine", "."):
        code, _, err = softact(capsys, *COMMANDS[command], "-o", where)
        assert (code, len(err.splitlines())) == (2, 1), err
        assert err.startswith(f"{where}: the folder holds other files") and "--force" in err
        assert everything(folder) == before
    code, _, err = softact(capsys, *COMMANDS[command], "-o", "mine", "--force")
    assert ended(code), err
    mine = (folder / "mine" / MINE[command]).read_text()
    own = json.loads((folder / "mine" / MARKER).read_text())["files"]
    assert (mine == "years of work") == (MINE[command] not in own)


@pytest.mark.parametrize("command", COMMANDS)
def test_its_own_folder_may_be_written_again_and_what_else_is_there_stays(folder, capsys, command):
    (folder / "out").mkdir()
    assert ended(softact(capsys, *COMMANDS[command], "-o", "out")[0])
    names = {path.name for path in (folder / "out").iterdir()}
    own = json.loads((folder / "out" / MARKER).read_text())
    assert own == {"softact": command, "files": sorted(names - {MARKER})}
    notes = [folder / "out/notes.txt"]
    notes += [path / "notes.txt" for path in (folder / "out").iterdir() if path.is_dir()]
    for path in notes:
        path.write_text("mine")
    left = folder / "out" / f".{sorted(names - {MARKER})[-1]}.0123456789abcdef.tmp"
    left.write_text("of a kill")
    code, _, err = softact(capsys, *COMMANDS[command], "-o", "out")
    assert ended(code), err
    assert [path.read_text() for path in notes] == ["mine"] * len(notes)
    assert not left.exists()
    for path in (folder / "out").rglob("run.json"):
        assert read(path.parent).status == "complete"


@pytest.mark.parametrize("command", COMMANDS)
def test_a_file_of_the_users_in_its_own_folder_is_not_replaced(folder, capsys, command):
    """A file that came into the folder afterwards, of a name that softact wants to write."""
    marker = {"softact": command, "files": ["earlier.html"]}
    (folder / "out").mkdir()
    (folder / "out" / MARKER).write_text(json.dumps(marker))
    (folder / "out" / MINE[command]).parent.mkdir(exist_ok=True)
    (folder / "out" / MINE[command]).write_text("mine")
    before = everything(folder)
    code, _, err = softact(capsys, *COMMANDS[command], "-o", "out")
    assert (code, len(err.splitlines())) == (2, 1), err
    assert f"out/{MINE[command].split('/')[0]}: is there already; add --force" in err
    assert everything(folder) == before


@pytest.mark.parametrize("command", COMMANDS)
def test_a_folder_of_another_command_is_not_written(folder, capsys, command):
    for other, files in ((f"not {command}", []), ("run", None)):
        if files is None:
            where = "one"
        else:
            where = "other"
            Output(folder / where, other).directory.mkdir()
            (folder / where / MARKER).write_text(json.dumps({"softact": other, "files": files}))
        before = everything(folder)
        code, _, err = softact(capsys, *COMMANDS[command], "-o", where)
        assert code == 2 and err.startswith(f"{where}: the folder holds other files"), err
        assert everything(folder) == before


WRONG = {
    "sweep": ("sweep.yaml", "axes:", "axis:"),
    "optimize": ("opt.yaml", "bending_angle_deg", "bending_angel_deg"),
    "calibrate": ("angle.csv", "bending_angle_deg", "bending_angel_deg"),
    "converge": ("spec.yaml", "0.1 MPa", "0.1 mm"),
    "compare": ("two/run.json", '"status"', "status"),
    "fit": ("pull.csv", "stretch", "strech"),
}


@pytest.mark.parametrize("command", COMMANDS)
def test_nothing_is_written_on_refusal(folder, capsys, command):
    """A wrong input, a folder that is a file or below one: no folder, no lock, no cache."""
    name, old, new = WRONG[command]
    text = (folder / name).read_text()
    (folder / name).write_text(text.replace(old, new))
    before = everything(folder), sorted(folder.rglob("*"))
    assert softact(capsys, *COMMANDS[command])[0] == 2
    assert (everything(folder), sorted(folder.rglob("*"))) == before
    (folder / name).write_text(text)
    (folder / "file").write_text("mine")
    before = everything(folder), sorted(folder.rglob("*"))
    for where in ("file", "file/out"):
        code, _, err = softact(capsys, *COMMANDS[command], "-o", where)
        assert code == 2 and err.startswith(f"{where}: ") and len(err.splitlines()) == 1
    assert (everything(folder), sorted(folder.rglob("*"))) == before


@pytest.mark.parametrize("command", ["sweep", "optimize", "calibrate", "converge"])
def test_a_cache_is_no_place_for_other_files(folder, capsys, command):
    before = everything(folder)
    code, _, err = softact(capsys, *COMMANDS[command], "--cache", ".")
    assert (code, len(err.splitlines())) == (2, 1)
    assert err.startswith(".: the folder holds other files than runs of softact; name another")
    assert everything(folder) == before


@pytest.mark.parametrize("force", [(), ("--force",)])
def test_an_input_is_never_replaced(folder, capsys, force):
    """``calibrate -o .`` wrote its own spec; ``fit -o .`` a card that it compares with."""
    (folder / "spec.yaml").write_text("name: spec\n" + SPEC)
    (folder / "pull.yaml").write_text("law: neo_hookean\nc10: 0.1 MPa\n")
    before = everything(folder)
    for arguments in (COMMANDS["calibrate"], [*COMMANDS["fit"], "--compare", "pull.yaml"]):
        code, _, err = softact(capsys, *arguments, "-o", ".", *force)
        assert code == 2 and (not force or "this file is read by the command" in err)
        assert everything(folder) == before


def test_mesh_replaces_no_file_by_itself_and_never_its_own_input(folder, capsys):
    assert softact(capsys, "mesh", "spec.yaml", "-o", "part.msh")[0] == 0
    before = everything(folder)
    code, _, err = softact(capsys, "mesh", "spec.yaml", "-o", "part.msh")
    assert code == 2 and err == (
        "part.msh: is there already; add --force to replace it, or name another with -o FILE\n"
    )
    assert everything(folder) == before
    assert softact(capsys, "mesh", "spec.yaml", "-o", "part.msh", "--force",
                   "--set", "geometry.length=11 mm")[0] == 0  # fmt: skip
    assert everything(folder)["part.msh"] != before["part.msh"]
    (folder / "again.yaml").write_text(SPEC.replace(
        "type: block, length: 10 mm, width: 4 mm, height: 4 mm",
        "type: from_script, file: part.msh, cavities: {}, clamp: x_min, tip: ''"))  # fmt: skip
    before = everything(folder)
    for force in ((), ("--force",)):
        code, _, err = softact(capsys, "mesh", "again.yaml", "-o", "./part.msh", *force)
        assert code == 2 and "part.msh: this file is read by the command" in err
    assert everything(folder) == before


def test_schema_and_junit_replace_no_file_of_the_users(folder, capsys):
    (folder / "mine.json").write_text("mine")
    assert softact(capsys, "schema", "-o", "mine.json")[0] == 2
    case = {"description": "a beam", "spec": "spec.yaml", "values": [
        {"measure": "bending_angle_deg", "value": 1, "tolerance": 1e9, "kind": "computed",
         "source": "none"}]}  # fmt: skip
    (folder / "case.yaml").write_text(json.dumps(case))
    code, _, err = softact(capsys, "check", "case.yaml", "--junit", "mine.json")
    assert code == 2 and err.startswith("mine.json: is there already")
    assert (folder / "mine.json").read_text() == "mine"


def test_a_run_replaces_results_but_not_the_spec_that_it_reads(folder, tmp_path):
    check_results(folder / "one", force=False)
    spec = folder / "one" / "spec.yaml"
    for reads in ([spec], [folder / "one/curve.csv"]):
        for force in (False, True):
            with pytest.raises(SpecError, match="this file is read by the command"):
                check_results(folder / "one", force, reads)
    (folder / "mine").mkdir()
    (folder / "mine/run.json").write_text('{"status": "of another program"}')
    with pytest.raises(SpecError, match="holds other files than results of softact"):
        check_results(folder / "mine", force=False)


def test_a_run_of_the_spec_that_softact_has_stored_is_no_danger_to_it(folder, capsys, monkeypatch):
    """softact run results/one/spec.yaml, as it was written; not once somebody has edited it."""
    solved = []
    monkeypatch.setattr("softact.run.start.run", lambda *a, **o: solved.append(a) or pytest.skip())
    from softact.spec import load

    (folder / "one/spec.yaml").write_text(load("spec.yaml").to_yaml())
    with pytest.raises(pytest.skip.Exception):
        cli.main(["run", "one/spec.yaml", "-o", "one"])
    (folder / "one/spec.yaml").write_text("# my notes\n" + load("spec.yaml").to_yaml())
    code, _, err = softact(capsys, "run", "one/spec.yaml", "-o", "one")
    assert code == 2 and "one/spec.yaml: this file is read by the command" in err
    assert len(solved) == 1


def test_report_writes_into_result_folders_of_softact_only(folder, capsys):
    (folder / "mine").mkdir()
    (folder / "mine/run.json").write_text('{"laps": 3}')
    (folder / "mine/curve.png").write_text("mine")
    before = everything(folder)
    code, _, err = softact(capsys, "report", "mine")
    assert code == 2 and err.startswith("mine/run.json: ")
    assert everything(folder) == before


def test_no_link_is_followed_and_no_name_foreseen(tmp_path):
    """``report`` wrote through a link named .report.html.tmp to wherever it pointed."""
    mine, link = tmp_path / "thesis.tex", tmp_path / ".report.html.tmp"
    mine.write_text("years of work")
    link.symlink_to(mine)
    (tmp_path / "report.html").symlink_to(mine)
    write_atomic(tmp_path / "report.html", "<html>")
    assert mine.read_text() == "years of work" and link.is_symlink()
    assert (tmp_path / "report.html").read_text() == "<html>"
    assert not (tmp_path / "report.html").is_symlink()
    names = set()
    for _ in range(20):
        with replacing(tmp_path / "report.html") as temporary:
            names.add(temporary.name)
            assert is_temporary(temporary.name)
            assert stat.S_ISREG(os.lstat(temporary).st_mode)
    assert len(names) == 20


def test_a_file_that_is_replaced_keeps_its_permissions(tmp_path):
    path = tmp_path / "curve.csv"
    write_atomic(path, "new")
    usual = path.stat().st_mode
    path.chmod(0o600)
    write_atomic(path, "newer")
    assert (path.stat().st_mode & 0o777, usual & 0o600) == (0o600, 0o600)


def test_a_block_that_fails_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "curve.csv"
    path.write_text("old")
    with pytest.raises(KeyboardInterrupt), replacing(path) as temporary:
        temporary.write_text("half")
        raise KeyboardInterrupt
    assert everything(tmp_path) == {"curve.csv": b"old"}


def test_names_with_dots_do_not_replace_each_other(folder, capsys):
    for name in ("soft.1", "soft.2"):
        assert softact(capsys, *COMMANDS["fit"], "--name", name, "-o", "out")[0] == 0
    cards = {path.name for path in (folder / "out").glob("*.yaml")}
    assert cards == {"soft.1.yaml", "soft.2.yaml"}


def test_a_copied_result_folder_says_incomplete_until_it_is_whole(folder, monkeypatch):
    """A kill in the middle of a copy, after every file in turn."""
    import softact.results.own_folder

    copied = softact.results.own_folder.shutil.copyfile
    for last in range(1, 1 + len(list((folder / "one").iterdir()))):
        count = []

        def copy(source, target, last=last, count=count):
            count.append(source)
            if len(count) == last:
                raise KeyboardInterrupt
            copied(source, target)

        output = Output(folder / "out", "optimize")
        with output.opened(["best"]):
            monkeypatch.setattr(softact.results.own_folder.shutil, "copyfile", copy)
            with pytest.raises(KeyboardInterrupt):
                output.results("best", folder / "one")
            assert read(folder / "out/best").status == "incomplete"
    monkeypatch.setattr(softact.results.own_folder.shutil, "copyfile", copied)
    with output.opened(["best"]):
        output.results("best", folder / "one")
    names = {path.name for path in (folder / "one").iterdir()}
    assert {path.name for path in (folder / "out/best").iterdir()} == names
    with open(folder / "out/best/curve.csv") as file:
        assert len(list(csv.DictReader(file))) == 3
    assert csv_text([]) == "\n"


@pytest.mark.parametrize("command", COMMANDS)
def test_a_second_one_at_once_in_one_folder_is_refused(folder, capsys, monkeypatch, command):
    """While the first writes; the second says so in one line and leaves everything as it is."""
    inside, leave, codes = threading.Event(), threading.Event(), []
    claim = Output.file

    def waits(self, name):
        inside.set()
        assert leave.wait(60)
        return claim(self, name)

    def first():
        try:
            codes.append(cli._run([*COMMANDS[command], "-o", "out"], debug=False))
        except SystemExit as left:
            codes.append(left.code)

    monkeypatch.setattr(Output, "file", waits)
    thread = threading.Thread(target=first)
    thread.start()
    assert inside.wait(60)
    before = everything(folder)
    code, _, err = softact(capsys, *COMMANDS[command], "-o", "out")
    assert (code, len(err.splitlines())) == (2, 1)
    assert err.startswith(f"out: softact {command} (process {os.getpid()} on ")
    assert everything(folder) == before
    leave.set()
    thread.join()
    assert ended(codes[0])
    assert not (folder / "out" / LOCK).exists()

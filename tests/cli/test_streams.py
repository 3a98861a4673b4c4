"""What the terminal and the system stand for: other locales, closed and full streams, readers that
leave, a home that cannot be written."""

import ast
import errno
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

import softact
from softact.errors import SoftactError
from softact.run.start import CannotWriteError, run
from softact.spec import loads

SOFTACT = [sys.executable, "-m", "softact.cli.main"]
ROOT = Path(__file__).resolve().parents[2]

# The description needs more than Latin-1, and so does the name of the part.
UMLAUTS = """\
name: cube
description: "Würfel aus Silikon — ε ≤ 3, λ̄"
geometry: {type: from_script, file: würfel.py, regions: [Körper λ], cavities: {}, mesh_size: 10 mm}
materials: {Körper λ: {law: neo_hookean, c10: 0.1 MPa}}
steps:
  - {traction: {surface: tip, value: [10 kPa, 0 kPa, 0 kPa]}, max_increment: 1}
measures: [elongation]
"""
SCRIPT = """\
def build(gmsh):
    gmsh.model.occ.addBox(0, 0, 0, 10, 10, 10)
    gmsh.model.occ.synchronize()
    for dimension, tag, name in ((3, 1, "Körper λ"), (2, 1, "clamp"), (2, 2, "tip")):
        group = gmsh.model.addPhysicalGroup(dimension, [tag])
        gmsh.model.setPhysicalName(dimension, group, name)
"""
# Python's own remedies for the locale C are switched off: so a locale of Latin-1 or of KOI8 is.
LOCALES = {
    "C": {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    "latin-1": {"PYTHONIOENCODING": "latin-1", "LC_ALL": "C.UTF-8"},
}


def call(*arguments, folder=None, environment=(), **more):
    return subprocess.run(
        [*SOFTACT, *arguments], cwd=folder, env={**os.environ, **dict(environment)},
        capture_output=True, **more,
    )  # fmt: skip


@pytest.mark.parametrize("locale", LOCALES)
@pytest.mark.parametrize("arguments", [["list", "laws"], ["schema"]], ids=" ".join)
def test_what_a_locale_cannot_show_is_no_fault(locale, arguments):
    done = call(*arguments, environment=LOCALES[locale])
    assert (done.returncode, done.stderr) == (0, b"")
    assert len(done.stdout) > 400


def test_a_spec_in_any_letters_is_solved_in_any_locale(tmp_path):
    (tmp_path / "cube.yaml").write_text(UMLAUTS.replace("würfel.py", "box.py"), encoding="utf-8")
    (tmp_path / "box.py").write_text(SCRIPT, encoding="utf-8")
    done = call("run", "cube.yaml", "-o", "out", folder=tmp_path, environment=LOCALES["C"])
    assert (done.returncode, done.stderr) == (0, b"")
    stored = yaml.safe_load((tmp_path / "out/spec.yaml").read_text(encoding="utf-8"))
    assert stored["description"] == "Würfel aus Silikon — ε ≤ 3, λ̄"
    assert list(stored["materials"]) == ["Körper λ"]
    assert "Würfel aus Silikon — ε ≤ 3, λ̄" in (tmp_path / "out/report.html").read_text("utf-8")


def test_a_fault_is_told_in_any_locale(tmp_path):
    (tmp_path / "cube.yaml").write_text("größe: 3\n", encoding="utf-8")
    done = call("validate", "cube.yaml", "wörld.yaml", folder=tmp_path, environment=LOCALES["C"])
    assert done.returncode == 2
    assert b"unknown key; known: name, description" in done.stderr
    assert b"there is no such file" in done.stderr


def test_a_file_that_a_locale_cannot_name_is_refused_in_a_line(tmp_path):
    (tmp_path / "box.py").write_text(SCRIPT, encoding="utf-8")
    (tmp_path / "cube.yaml").write_text(
        UMLAUTS.replace("file: würfel.py", "file: box.py").replace(
            "{law: neo_hookean, c10: 0.1 MPa}", "./würfel.yaml"
        ),
        encoding="utf-8",
    )
    done = call("validate", "cube.yaml", folder=tmp_path, environment=LOCALES["C"])
    assert done.returncode == 2
    assert b"run softact with LC_ALL=C.UTF-8" in done.stderr
    assert b"Traceback" not in done.stderr


def unnamed(path):
    """Lines of a module that open a text in the encoding of whatever locale there is."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.Call):
            continue
        keys = {key.arg: key.value for key in node.keywords}
        name = getattr(node.func, "attr", getattr(node.func, "id", ""))
        owner = getattr(getattr(node.func, "value", None), "id", "")
        texts = [a.value for a in node.args if isinstance(a, ast.Constant)]
        if name == "open" and owner not in ("os", "Image", "h5py"):
            binary = any("b" in text for text in texts if isinstance(text, str) and len(text) < 4)
            named = binary or "encoding" in keys
        elif name in ("read_text", "write_text"):
            named = "encoding" in keys or len(node.args) > (name == "write_text")
        else:
            named = "text" not in keys or name not in ("run", "Popen", "check_output")
        if not named:
            yield f"{path.name}:{node.lineno}"


def test_every_text_file_is_opened_in_utf8():
    own = Path(softact.__file__).resolve().parent
    files = [*own.rglob("*.py"), *ROOT.glob("cli/*.py"), *ROOT.glob("geometries/*.py")]
    assert len(files) > 150
    # fit.card.write_text is a function of softact's that names the encoding inside.
    found = [
        place for path in files if path.parts[-2:] != ("fit", "run.py") for place in unnamed(path)
    ]
    assert found == []


@pytest.mark.parametrize(
    "arguments", [["list", "laws"], ["schema"], ["validate", "--help"], ["--version"]], ids=" ".join
)  # fmt: skip
def test_a_reader_that_has_left_ends_softact_quietly(arguments):
    """141 is 128 + SIGPIPE, as of every other program in a pipe."""
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run([*SOFTACT, *arguments], stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    assert (done.returncode, done.stderr) == (141, b"")


def test_a_reader_of_the_errors_that_has_left_is_no_fault_either():
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run([*SOFTACT, "validate", "none.yaml"], stdout=writer, stderr=writer)
    os.close(writer)
    assert done.returncode == 141


def test_a_closed_stdout_is_none():
    words = " ".join([*SOFTACT, "list", "laws"])
    done = subprocess.run(["bash", "-c", f"{words} >&-"], capture_output=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")


def test_a_run_without_any_stream_writes_its_files_and_nothing_into_them(tmp_path):
    """A file that is opened as number 1 would be what the solver prints into."""
    (tmp_path / "cube.yaml").write_text(UMLAUTS.replace("würfel.py", "box.py"), encoding="utf-8")
    (tmp_path / "box.py").write_text(SCRIPT, encoding="utf-8")
    words = " ".join([*SOFTACT, "run", "cube.yaml", "-o", "out"])
    done = subprocess.run(["bash", "-c", f"{words} <&- >&- 2>&-"], cwd=tmp_path)
    assert done.returncode == 0
    assert json.loads((tmp_path / "out/run.json").read_text())["status"] == "complete"


@pytest.mark.parametrize("arguments", [["list", "laws"], ["schema"]], ids=" ".join)
def test_a_full_disk_behind_stdout_is_told_in_a_line(arguments):
    with open("/dev/full", "w") as full:
        done = subprocess.run([*SOFTACT, *arguments], stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 2
    assert done.stderr == b"softact: cannot write: No space left on device\n"


CUBE = """\
geometry: {type: block, mesh_size: 10 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
steps: [{traction: {surface: x_max, value: [10 kPa, 0 kPa, 0 kPa]}}]
"""


@pytest.mark.parametrize(
    ("environment", "variable"),
    [
        ({"HOME": "/dev/null", "XDG_CACHE_HOME": ""}, "HOME"),
        ({"XDG_CACHE_HOME": "/proc/none"}, "XDG_CACHE_HOME"),
        ({"XDG_CACHE_HOME": "/dev/null"}, "XDG_CACHE_HOME"),
    ],
)
def test_a_home_that_cannot_be_written_is_told_with_the_remedy(tmp_path, environment, variable):
    (tmp_path / "cube.yaml").write_text(CUBE)
    done = call("run", "cube.yaml", folder=tmp_path, environment=environment, text=True)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "softact keeps compiled code there" in line
    assert line.endswith(f"for example export {variable}=$(mktemp -d)")
    assert [path.name for path in tmp_path.iterdir()] == ["cube.yaml"]


def test_shell_completion_still_works():
    words = {"_SOFTACT_COMPLETE": "bash_complete", "COMP_WORDS": "softact val", "COMP_CWORD": "1"}
    assert call(environment=words).stdout == b"plain,validate\n"


def test_a_folder_for_temporary_files_that_is_none_is_not_taken(tmp_path):
    """Python falls back to another one; Open MPI would end the solver without a word."""
    (tmp_path / "cube.yaml").write_text(CUBE)
    done = call("run", "cube.yaml", folder=tmp_path, environment={"TMPDIR": "/proc/none"})
    assert (done.returncode, done.stderr) == (0, b"")


def test_no_folder_for_temporary_files_is_told_with_the_remedy(tmp_path, monkeypatch):
    def none_usable(**options):
        raise FileNotFoundError(errno.ENOENT, "No usable temporary directory found in ['/tmp']")

    monkeypatch.setattr("tempfile.mkdtemp", none_usable)
    with pytest.raises(CannotWriteError, match=r"No usable temporary .*; export TMPDIR=DIR names"):
        run(loads(CUBE), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_user_without_a_home_is_told_with_the_remedy(monkeypatch):
    """As in a container whose user is a number: Python knows no home then."""
    from softact.doctor.looks import look_at_cache
    from softact.report.base.layout import plotly
    from softact.system import jit

    def homeless():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", homeless)
    with pytest.raises(SoftactError, match=r"home directory.*export HOME=\$\(mktemp -d\)"):
        jit.cache_folder()
    (finding,) = look_at_cache()
    assert (finding.state, finding.mend) == ("broken", "export XDG_CACHE_HOME=$(mktemp -d)")
    plotly.cache_clear()
    assert len(plotly()) > 1_000_000

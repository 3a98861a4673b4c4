"""Scripts of the user's are code by intent: who runs them says so, and who need not does not."""

import contextlib
import shutil
from pathlib import Path

import gmsh
import pytest
from click.testing import CliRunner

from softact.cli import main as cli
from softact.errors import MeshError
from softact.geometries.from_script import FromScript
from softact.geometry.base import make_mesh
from softact.geometry.scripts import scripts_as_code

# A block of 20 x 4 x 4 mm; whoever runs it leaves a mark beside it.
SCRIPT = """
from pathlib import Path
(Path(__file__).parent / "mark").touch()

def build(gmsh):
    gmsh.model.occ.addBox(0, 0, 0, 20, 4, 4)
    gmsh.model.occ.synchronize()
    groups = {"clamp": 1, "tip": 2}
    for name, tag in groups.items():
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, [tag]), name)
    gmsh.model.setPhysicalName(3, gmsh.model.addPhysicalGroup(3, [1]), "body")
"""
SPEC = """
name: arm
geometry: {type: from_script, file: arm.py, cavities: {}, mesh_size: 4 mm}
materials: {body: ecoflex-00-30}
steps: [{name: weight, gravity: [0, 0, -1]}]
measures: [elongation]
"""
SWEEP = """
base: arm.yaml
axes: [{path: geometry.mesh_size, values: [4 mm, 5 mm]}]
"""
AS_CODE = "arm.py as code"


@pytest.fixture
def arm(tmp_path, monkeypatch):
    """A folder with a spec, its script and a sweep; function that tells whether the script ran."""
    for name, text in (("arm.py", SCRIPT), ("arm.yaml", SPEC), ("sweep.yaml", SWEEP)):
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)

    def ran() -> bool:
        mark = tmp_path / "mark"
        there = mark.exists()
        mark.unlink(missing_ok=True)
        return there

    return ran


def called(*arguments: str) -> str:
    """What a command says, on both streams."""
    outcome = CliRunner().invoke(cli.softact, arguments, catch_exceptions=False)
    assert outcome.exit_code == 0, outcome.output
    return outcome.output


def test_run_says_so_and_validate_report_and_compare_do_not_run_it(arm):
    assert AS_CODE in called("validate", "arm.yaml") and not arm()
    assert AS_CODE in called("run", "arm.yaml", "-o", "one") and arm()
    assert AS_CODE in Path("one/log.txt").read_text()
    shutil.copytree("one", "two")
    called("report", "one")
    called("compare", "one", "two")
    assert AS_CODE in called("validate", "one/spec.yaml")
    assert not arm()
    # A result's spec from elsewhere is a spec that runs a script.
    assert AS_CODE in called("mesh", "one/spec.yaml", "-o", "x.msh") and arm()


def test_a_sweep_says_so_before_its_first_run(arm):
    said = called("sweep", "sweep.yaml", "--list", "--cache", "cache")
    assert said.index(AS_CODE) < said.index("2 points")


def test_only_scripts_are_named():
    geometry = {"type": "from_script", "file": "a.py"}
    assert scripts_as_code({"geometry": geometry}, ["b.geo", "c.msh", 3]) == [
        "runs the script a.py as code", "runs the script b.geo as code"
    ]  # fmt: skip
    assert scripts_as_code({"geometry": geometry | {"type": "from_step"}}) == []
    assert scripts_as_code({"geometry": "x"}) == scripts_as_code(None) == []


def test_files_and_modules_count_from_the_script_and_not_from_the_caller(tmp_path, monkeypatch):
    """A script that merges box.step and imports sizes, both beside it, called from elsewhere."""
    folder, elsewhere = tmp_path / "mine", tmp_path / "elsewhere"
    for made in (folder, elsewhere):
        made.mkdir()
    (folder / "sizes.py").write_text("LENGTH = 20\n")
    (elsewhere / "sizes.py").write_text("LENGTH = 1 / 0\n")
    gmsh.initialize(readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.occ.addBox(0, 0, 0, 20, 4, 4)
    gmsh.model.occ.synchronize()
    gmsh.write(str(folder / "box.step"))
    gmsh.finalize()
    text = SCRIPT.replace("    gmsh.model.occ.addBox(0, 0, 0, 20, 4, 4)\n", """
    import sizes
    gmsh.merge("box.step")
    assert sizes.LENGTH == 20
""")  # fmt: skip
    (folder / "arm.py").write_text(text)
    monkeypatch.chdir(elsewhere)
    make_mesh(script("../mine/arm.py"), tmp_path / "x.msh")
    assert {path.name for path in folder.iterdir()} == {"arm.py", "box.step", "mark", "sizes.py"}
    assert [path.name for path in elsewhere.iterdir()] == ["sizes.py"]


def script(file) -> FromScript:
    given = {"file": str(file), "cavities": {}, "mesh_size": "4 mm"}
    return FromScript.model_validate(given)


def refused(file, tmp_path) -> str:
    with pytest.raises(MeshError) as caught:
        make_mesh(script(file), tmp_path / "x.msh")
    (line,) = caught.value.lines
    return line


SUFFIXES = "step stp brep iges igs stl unv vtk mesh bdf msh off ply inp cgns med xao txt Stl gz"


def test_a_script_that_merges_data_does_not_run_them(tmp_path):
    """A script of gmsh's under each suffix, and one beside it as .opt."""
    for suffix in SUFFIXES.split():
        for name in (f"data.{suffix}", f"data.{suffix}.opt"):
            planted = f'SystemCall "touch {tmp_path}/planted.{name}";\n'
            (tmp_path / name).write_text(planted)
    merging = SCRIPT.replace("    gmsh.model.occ.addBox", f"""
    for suffix in {SUFFIXES.split()}:
        for read in (gmsh.merge, gmsh.open):
            try:
                read("data." + suffix)
            except Exception:
                pass
    gmsh.model.occ.addBox""")  # fmt: skip
    (tmp_path / "arm.py").write_text(merging)
    # After a file that it cannot read, gmsh 4.8 says that it is busy, and makes nothing.
    with contextlib.suppress(MeshError):
        make_mesh(script(tmp_path / "arm.py"), tmp_path / "x.msh")
    assert (tmp_path / "mark").exists() and not list(tmp_path.glob("planted.*"))


def test_a_script_may_merge_scripts_of_gmsh(tmp_path):
    (tmp_path / "box.geo").write_text(
        'SetFactory("OpenCASCADE");\nInclude "size.geo";\nBox(1) = {0, 0, 0, L, 4, 4};\n'
        'Physical Volume("body") = {1};\nPhysical Surface("clamp") = {1};\n'
        'Physical Surface("tip") = {2};\n'
    )
    (tmp_path / "size.geo").write_text("L = 20;\n")
    (tmp_path / "arm.py").write_text('def build(gmsh):\n    gmsh.merge("box.geo")\n')
    for name in ("arm.py", "box.geo"):
        make_mesh(script(tmp_path / name), tmp_path / "x.msh")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("def build(gmsh):\n    1 / 0\n", "arm.py:2: ZeroDivisionError: division by zero"),
        ("def build(gmsh:\n    pass\n", "arm.py:1: SyntaxError"),
        ("import there_is_none\n", "arm.py:1: ModuleNotFoundError: No module named"),
        ("def build(gmsh):\n    raise SystemExit(0)\n", "arm.py:2: SystemExit: 0"),
        ("def build(gmsh):\n    gmsh.merge('none.stl')\n", "arm.py:2: "),
        ("def make(gmsh):\n    pass\n", "arm.py has no function build(gmsh)"),
    ],
)
def test_what_goes_wrong_in_a_script_is_told_with_its_line(text, words, tmp_path):
    (tmp_path / "arm.py").write_text(text)
    assert words in refused(tmp_path / "arm.py", tmp_path)


def test_a_script_in_another_unit_is_refused(tmp_path):
    (tmp_path / "arm.py").write_text(SCRIPT.replace("20, 4, 4", "20000, 4000, 4000"))
    line = refused(tmp_path / "arm.py", tmp_path)
    assert "the part is 20000 x 4000 x 4000 mm; mesh_size 4 mm would make about 3e+10" in line

"""Nothing that lies in the current folder, or beside the spec, is run or changes a result."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from softact.child_processes import environment

SOFTACT = Path(sys.executable).with_name("softact")
SPEC = """
name: cube
geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 2 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps: [{name: pull, traction: {surface: x_max, value: [20 kPa, 0 kPa, 0 kPa]}}]
solver: {initial_increment: 0.5, max_increment: 0.5}
"""
MODULES = ("h5py", "gmsh", "numpy", "scipy", "mpi4py", "petsc4py", "dolfinx", "meshio", "yaml",
           "matplotlib", "vtkmodules", "plotly", "json", "signal")  # fmt: skip


def plant(folder, modules):
    """A spec among modules that leave a mark when they are run."""
    folder.mkdir(exist_ok=True)
    (folder / "cube.yaml").write_text(SPEC)
    for name in modules:
        (folder / f"{name}.py").write_text(f"open({str(folder / 'ran')!r}, 'a').write('{name} ')\n")


def softact(folder, *arguments, **variables):
    done = subprocess.run(
        [SOFTACT, *arguments],
        cwd=folder,
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stderr) == (0, ""), done.stderr


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Modules and a clone of softact in the folder from which softact is started."""
    folder = tmp_path_factory.mktemp("planted") / "here"
    plant(folder, MODULES)
    (folder / "softact" / "softact").mkdir(parents=True)
    (folder / "softact" / "README.md").write_text("a clone\n")
    return folder


def test_modules_in_the_current_folder(folder):
    softact(folder, "run", "cube.yaml", "-o", "out")
    assert not (folder / "ran").exists()
    assert (folder / "out" / "states.png").exists()


def test_modules_beside_the_spec(folder, tmp_path):
    softact(tmp_path, "run", str(folder / "cube.yaml"), "-n", "2", "-o", "out")
    assert not (folder / "ran").exists()


def test_empty_and_relative_entries_of_pythonpath(tmp_path):
    """They put the current folder on the path of the processes that softact starts."""
    plant(tmp_path, ("h5py", "gmsh", "numpy"))
    softact(tmp_path, "run", "cube.yaml", "-o", "out", PYTHONPATH=":.:/nowhere")
    assert not (tmp_path / "ran").exists()


def test_absolute_entries_of_pythonpath_stay(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", ":/opt/one:.:two:/opt/three")
    assert environment()["PYTHONPATH"] == "/opt/one:/opt/three"
    monkeypatch.setenv("PYTHONPATH", ":.")
    assert "PYTHONPATH" not in environment()


def test_options_in_the_current_folder(tmp_path):
    """PETSc's could load any library, and FFCx's empty its kernels: for good, as they are kept."""
    plant(tmp_path, ())
    (tmp_path / ".petscrc").write_text("-dll_prepend ./mine.so\n-snes_view\n-mat_mumps_icntl_4 3\n")
    (tmp_path / "ffcx_parameters.json").write_text('{"tabulate_tensor_void": true}')
    (tmp_path / "ffcx_options.json").write_text('{"scalar_type": "float32"}')
    source = tmp_path / "mine.c"
    source.write_text(
        "#include <stdio.h>\\n__attribute__((constructor)) void f(void)"
        f'{{FILE *f = fopen("{tmp_path}/ran", "w"); if (f) fclose(f);}}'.replace("\\n", "\n")
    )
    compiler = shutil.which("cc")
    subprocess.run([compiler, "-shared", "-fPIC", "-o", tmp_path / "mine.so", source], check=True)
    softact(tmp_path, "run", "cube.yaml", "-o", "out", XDG_CACHE_HOME=str(tmp_path / "cache"))
    softact(tmp_path, "doctor")
    assert not (tmp_path / "ran").exists()
    last = (tmp_path / "out" / "curve.csv").read_text().splitlines()[-1]
    elongation = float(last.split(",")[_columns(tmp_path / "out").index("elongation_mm")])
    assert 0.05 < elongation < 0.2  # 4 mm times 20 kPa over 600 kPa


def _columns(folder):
    return (folder / "curve.csv").read_text().splitlines()[0].split(",")


SCRIPT = """
from sides import SIDE

def build(gmsh):
    box = gmsh.model.occ.addBox(0, 0, 0, SIDE, SIDE, SIDE)
    gmsh.model.occ.synchronize()
    for dimension, tags, name in ((3, [box], "body"), (2, [1], "clamp"), (2, [2], "tip")):
        gmsh.model.setPhysicalName(
            dimension, gmsh.model.addPhysicalGroup(dimension, tags), name
        )
"""


def test_a_script_imports_what_lies_beside_it(tmp_path):
    """For itself alone: the processes that solve and draw do not."""
    folder = tmp_path / "mine"
    plant(folder, ("h5py", "meshio", "scipy"))
    (folder / "part.py").write_text(SCRIPT)
    (folder / "sides.py").write_text("SIDE = 4.0\n")
    spec = SPEC.replace(
        "{type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 2 mm}",
        "{type: from_script, file: part.py, cavities: {}, mesh_size: 2 mm}",
    ).replace("x_min", "clamp").replace("x_max", "tip")  # fmt: skip
    (folder / "cube.yaml").write_text(spec)
    softact(tmp_path, "run", "mine/cube.yaml", "-o", "out")
    assert not (folder / "ran").exists()

"""Meshing in a process of its own: what comes out, and that nothing that gmsh does hurts us.

The geometries here that hang, crash or lie are read by the child from this very file.
"""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Literal

import gmsh
import meshio
import numpy as np
import pytest

from softact.errors import MeshError, SpecError
from softact.geometries import GEOMETRIES
from softact.geometries.block import Block
from softact.geometry.base import export, make_mesh
from softact.geometry.imported import Imported

ROOT = Path(__file__).parents[2]


class Hanging(Block):
    """Does what gmsh does on some solids."""

    type: Literal["hanging"] = "hanging"

    def mesh(self, gmsh):
        print("Info    : Meshing 3D forever", flush=True)
        time.sleep(600)


class Crashing(Block):
    """Does what gmsh does on other solids."""

    type: Literal["crashing"] = "crashing"

    def mesh(self, gmsh):
        print("Info    : Meshing surface 17", flush=True)
        os.kill(os.getpid(), signal.SIGSEGV)


class Killed(Block):
    """Is what the kernel ends where memory is short."""

    type: Literal["killed"] = "killed"

    def mesh(self, gmsh):
        os.kill(os.getpid(), signal.SIGKILL)


class Failing(Block):
    """Asks gmsh for a volume that is not there."""

    type: Literal["failing"] = "failing"

    def mesh(self, gmsh):
        gmsh.model.occ.cut([(3, 1)], [(3, 2)])


class Lying(Block):
    """Promises another volume than it has."""

    type: Literal["lying"] = "lying"

    def volumes(self):
        return {"body": 1.001 * super().volumes()["body"]}


class Nameless(Block):
    """Forgets to name a face."""

    type: Literal["nameless"] = "nameless"

    def solid(self):
        boxes = super().solid()
        return type(boxes)(boxes.boxes, boxes.regions, planes=boxes.planes[1:])


class Flat(Block):
    """Has walls much thinner than its cells."""

    type: Literal["flat"] = "flat"


class Leaking(Block):
    """Takes one face of a solid for the walls of a cavity."""

    type: Literal["leaking"] = "leaking"

    def layout(self):
        layout = super().layout()
        return type(layout)(
            regions=layout.regions, surfaces=layout.surfaces, cavities={"air": ("z_max",)}
        )


class Nosy(Block):
    """Tells which variables of MPI its process sees."""

    type: Literal["nosy"] = "nosy"

    def mesh(self, gmsh):
        seen = [name for name in os.environ if name.startswith(("OMPI_", "PMIX_", "PMI_"))]
        raise RuntimeError(f"seen: {sorted(seen)}, threads: {os.environ['OMP_NUM_THREADS']}")


def refused(geometry, folder: Path, timeout: float = 60.0) -> str:
    """The one line of the MeshError of a geometry; no file may be left."""
    with pytest.raises(MeshError) as caught:
        make_mesh(geometry, folder / "bad.msh", timeout)
    assert os.listdir(folder) == []
    assert caught.value.exit_code == 3
    assert len(caught.value.lines) == 1 and "\n" not in caught.value.lines[0]
    return caught.value.lines[0]


def test_hanging_gmsh_is_stopped(tmp_path):
    start = time.monotonic()
    line = refused(Hanging(), tmp_path, timeout=5.0)
    assert time.monotonic() - start < 10
    assert line.startswith("hanging: gmsh did not finish within 5 s")
    assert line.endswith("Info    : Meshing 3D forever")


def test_crash_of_gmsh_is_told(tmp_path):
    line = refused(Crashing(), tmp_path)
    assert (
        line == "crashing: gmsh crashed (SIGSEGV); gmsh's last words: Info    : Meshing surface 17"
    )


def test_kill_of_gmsh_is_told(tmp_path):
    assert refused(Killed(), tmp_path) == "killed: gmsh was killed by signal 9 (out of memory?)"


def test_full_disk_leaves_no_part_of_a_mesh(tmp_path):
    disk = ["mount", "-t", "tmpfs", "-o", "size=40k", "tmpfs", tmp_path]
    done = subprocess.run(disk, capture_output=True, text=True)
    if done.returncode:
        pytest.skip(f"may not mount a disk here: {done.stderr.strip()}")
    fine = Block.model_validate({"mesh_size": "1 mm"})  # gmsh itself ends well, with a part
    try:
        with pytest.raises(OSError, match="No space left on device"):
            make_mesh(fine, tmp_path / "fine.msh")
        assert os.listdir(tmp_path) == []
    finally:
        subprocess.run(["umount", tmp_path], check=True)


def test_error_of_gmsh_is_told(tmp_path):
    line = refused(Failing(), tmp_path)
    assert line.startswith("failing: ") and "OpenCASCADE" in line


def test_wrong_volume_is_noticed(tmp_path):
    line = refused(Lying(), tmp_path)
    assert line == "lying: the mesh gives 1000 for the measure of 'body', the closed form 1001"


def test_missing_group_is_noticed(tmp_path):
    assert "nothing in the surface group 'x_min'" in refused(Nameless(), tmp_path)


def test_flat_cells_are_noticed(tmp_path):
    line = refused(Flat.model_validate({"height": "0.001 mm"}), tmp_path)
    assert "20 of 20 tetrahedra are flat" in line


def test_leaking_cavity_is_noticed(tmp_path):
    assert "walls of the cavity 'air' do not close" in refused(Leaking(), tmp_path)


def test_child_is_no_part_of_an_mpi_job(tmp_path, monkeypatch):
    for name in ("OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK"):
        monkeypatch.setenv(name, "1")
    assert refused(Nosy(), tmp_path) == "nosy: RuntimeError: seen: [], threads: 1"


@pytest.mark.skipif(not shutil.which("mpirun"), reason="needs mpirun")
def test_meshes_under_mpirun(tmp_path):
    program = (
        "from mpi4py import MPI; from pathlib import Path\n"
        "from softact.geometries import GEOMETRIES\n"
        "from softact.geometry.base import make_mesh\n"
        "rank = MPI.COMM_WORLD.rank\n"
        "make_mesh(GEOMETRIES['tube'](), Path(f'{rank}.msh'), 60)\n"
    )
    command = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", "2"]
    run = subprocess.run(
        [*command, sys.executable, "-c", program],
        cwd=tmp_path,
        env=dict(os.environ),  # else what an MPI in this process has put into its environment
        capture_output=True,
        timeout=120,
    )
    assert run.returncode == 0, run.stderr
    assert (tmp_path / "0.msh").read_bytes() == (tmp_path / "1.msh").read_bytes()


def test_failure_leaves_the_old_file(tmp_path):
    path = tmp_path / "old.msh"
    path.write_text("old")
    with pytest.raises(MeshError):
        make_mesh(Crashing(), path, 60.0)
    assert path.read_text() == "old" and os.listdir(tmp_path) == ["old.msh"]


# The others need a file: tests/geometries/test_imported.py.
PARAMETRIC = [name for name, kind in GEOMETRIES.items() if not issubclass(kind, Imported)]


@pytest.mark.parametrize("name", PARAMETRIC)
def test_same_input_gives_the_same_file(name, tmp_path):
    paths = [tmp_path / "a.msh", tmp_path / "b.msh"]
    for path in paths:
        make_mesh(GEOMETRIES[name](), path, 60.0)
    assert paths[0].read_bytes() == paths[1].read_bytes()


@pytest.mark.parametrize("name", PARAMETRIC)
def test_registry_names_are_the_types(name):
    geometry = GEOMETRIES[name]()
    assert geometry.type == name
    assert set(geometry.volumes()) <= {
        *geometry.layout().regions, *geometry.layout().surfaces, *geometry.layout().cavities,
        *geometry.layout().sheets,
    }  # fmt: skip


HALF = GEOMETRIES["pneunet"].model_validate({"chambers": 2, "mesh_size": "4 mm"})


# What is exported -> the name of its volume.
PARTS = {"solid": "body", "core": "cavity"}


@pytest.mark.parametrize("part", PARTS)
def test_stl_is_the_closed_skin_of_the_whole(part, tmp_path):
    """Each edge of the skin runs once each way, and the skin holds twice the half's volume."""
    export(HALF, tmp_path / "skin.stl", 60.0, part)
    skin = meshio.read(tmp_path / "skin.stl")
    points, number = np.unique(np.round(skin.points, 4), axis=0, return_inverse=True)
    triangles = number.reshape(-1)[skin.cells_dict["triangle"]]
    edges = np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    there, count = np.unique(edges, axis=0, return_counts=True)
    back = np.unique(edges[:, ::-1], axis=0)
    assert count.max() == 1 and np.array_equal(there, back)
    a, b, c = (points[triangles[:, i]] for i in range(3))
    volume = np.einsum("ij,ij->", np.cross(a, b), c) / 6
    assert volume == pytest.approx(2 * HALF.volumes()[PARTS[part]], rel=1e-5)


@pytest.mark.parametrize("part", PARTS)
def test_step_is_the_whole_solid(part, tmp_path):
    export(HALF, tmp_path / "solid.step", 60.0, part)
    gmsh.initialize(readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.occ.importShapes(str(tmp_path / "solid.step"))
        gmsh.model.occ.synchronize()
        solids = gmsh.model.getEntities(3)
        volume = sum(gmsh.model.occ.getMass(*solid) for solid in solids)
    finally:
        gmsh.finalize()
    assert len(solids) == 1
    assert volume == pytest.approx(2 * HALF.volumes()[PARTS[part]], rel=1e-6)


def test_a_core_needs_a_cavity_and_a_format_for_surfaces(tmp_path):
    with pytest.raises(SpecError, match=r"a core is written to \.stl or \.step only"):
        export(HALF, tmp_path / "core.vtu", part="core")
    with pytest.raises(SpecError, match="block has no closed cavity"):
        export(Block(), tmp_path / "core.stl", part="core")
    assert not os.listdir(tmp_path)


def test_vtu_holds_the_mesh_and_its_surfaces(tmp_path):
    export(HALF, tmp_path / "mesh.vtu", 60.0)
    make_mesh(HALF, tmp_path / "mesh.msh", 60.0)
    mesh, raw = meshio.read(tmp_path / "mesh.vtu"), meshio.read(tmp_path / "mesh.msh")
    tets, triangles = mesh.cells_dict["tetra"], mesh.cells_dict["triangle"]
    assert len(tets) == len(raw.cells_dict["tetra"])
    assert not mesh.cell_data_dict["region"]["tetra"].any()
    for name, at in (("clamp", 0.0), ("tip", HALF.row.length)):
        members = triangles[mesh.cell_data_dict[name]["triangle"] == 1]
        assert len(members) and mesh.points[members][..., 0] == pytest.approx(at, abs=1e-12)


@pytest.mark.parametrize("name", ["mesh.obj", "mesh", "no/folder/mesh.msh"])
def test_wrong_paths_are_the_users_fault(name, tmp_path):
    with pytest.raises(SpecError, match=r"no format for|there is no folder"):
        export(Block(), tmp_path / name)


def script(*options: str, folder: Path) -> subprocess.CompletedProcess:
    command = [sys.executable, str(ROOT / "geometries" / "pneunet.py"), *options]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)


def test_geometry_file_runs_by_itself(tmp_path):
    run = script("--chambers", "2", "--roof", "1.5 mm", "-o", "x.msh", folder=tmp_path)
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
    make_mesh(
        GEOMETRIES["pneunet"].model_validate({"chambers": 2, "roof": "1.5 mm"}),
        tmp_path / "y.msh", 60.0,
    )  # fmt: skip
    assert (tmp_path / "x.msh").read_bytes() == (tmp_path / "y.msh").read_bytes()


def test_geometry_file_refuses_wrong_options(tmp_path):
    run = script(
        "--roof", "0 mm", "--chambers", "2.5", "--gap", "[", "-o", "x.msh", folder=tmp_path
    )
    assert run.returncode == 2 and os.listdir(tmp_path) == []
    assert "Traceback" not in run.stderr
    assert "chambers" in run.stderr and "gap" in run.stderr

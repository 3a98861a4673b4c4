"""The same mesh and load in CalculiX, an independent code (skipped where ccx is missing).

CalculiX's C3D10 is a displacement element of ten nodes with four quadrature points, the same
formulation as softact's element P2 alone. Between these two only the tolerances are left, and the
quadrature of the pressure (three points per face in CalculiX, exact in softact): a part in 10,000.

P2/P1 has a pressure unknown and differs from C3D10 by what C3D10 locks: near incompressibility
(here K/mu = 100) displacement elements are too stiff, the more so the coarser the mesh. One element
through a wall of 1 mm is coarse. So P2/P1 must yield more than C3D10, and the gap must close as
elements become smaller.
"""

import pytest
from mpi4py import MPI

from benchmarks import calculix, ccx
from softact.errors import SpecError
from softact.geometry.base import make_mesh
from softact.mesh.msh_file import read_msh
from softact.run.worker import solve
from softact.spec import load

pytestmark = pytest.mark.skipif(ccx.executable() is None, reason="ccx (calculix-ccx) is missing")

ONE_CHAMBER = (
    "geometry.chambers=1",
    "steps.0.pressure=10 kPa",
    "solver.initial_increment=0.25",
    "solver.max_increment=0.25",
)
MESHES = {"coarse": "4 mm", "fine": "2 mm"}


def spec_of(size: str, element: str = "P2", more: tuple[str, ...] = ONE_CHAMBER):
    sizes = (f"geometry.mesh_size={size}", f"geometry.cavity_mesh_size={size}")
    return load(str(calculix.SPEC), (*more, *sizes, f"solver.element={element}"))


def mesh_of(spec, folder):
    file = folder / "mesh.msh"
    make_mesh(spec.geometry, file)
    return file, ccx.quadratic(read_msh(file, spec.geometry.layout()))


def by_ccx(spec, folder):
    """Tip displacement and volume change, converged far below what is asserted."""
    _, mesh = mesh_of(spec, folder)
    ccx.write_input(folder / "job.inp", mesh, spec, tolerance=1e-6)
    found = ccx.run(folder / "job.inp", len(mesh.points), threads=1)
    tip, volume = calculix.measures(spec, mesh, found.displacement[-1])
    return calculix.Measured(0, 0, found.increments, found.iterations, tip, volume)


def by_softact(spec, folder):
    file, _ = mesh_of(spec, folder)
    solve(MPI.COMM_SELF, spec, file, folder / "results", {}, lambda event: None)
    return calculix.Measured(0, 0, 0, 0, *calculix.read_curve(folder / "results"))


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """(mesh, who) -> measures; ccx and softact with both elements on both meshes."""
    results = {}
    for name, size in MESHES.items():
        for element in ("P2", "P2/P1"):
            folder = tmp_path_factory.mktemp("softact")
            results[name, element] = by_softact(spec_of(size, element), folder)
        results[name, "ccx"] = by_ccx(spec_of(size), tmp_path_factory.mktemp("ccx"))
    return results


@pytest.mark.parametrize("mesh", MESHES)
def test_same_element_gives_the_same_deformation(found, mesh):
    one, other = found[mesh, "P2"], found[mesh, "ccx"]
    assert other.volume > 100  # mm³, of 1152: the cavity does grow
    tip, volume = calculix.deviation(one, other)
    assert tip < 1e-4
    assert volume < 1e-4


@pytest.mark.parametrize("mesh", MESHES)
def test_displacement_element_is_too_stiff(found, mesh):
    assert found[mesh, "P2/P1"].volume > 1.02 * found[mesh, "ccx"].volume


def test_gap_to_the_mixed_element_closes_with_refinement(found):
    coarse, fine = (calculix.deviation(found[mesh, "P2/P1"], found[mesh, "ccx"]) for mesh in MESHES)
    assert fine[0] < 0.6 * coarse[0]
    assert fine[1] < 0.6 * coarse[1]


def test_mixed_element_changes_less_with_refinement(found):
    def change(who):
        return abs(found["fine", who].volume / found["coarse", who].volume - 1)

    assert change("P2/P1") < 0.5 * change("ccx")


def test_volume_and_areas_of_the_undeformed_mesh(tmp_path):
    """The quadratic mesh is softact's: closed-form volume of the half, faces out of the solid."""
    spec = spec_of("4 mm")
    _, mesh = mesh_of(spec, tmp_path)
    zero = 0 * mesh.points
    expected = spec.geometry.volumes()["cavity"]
    assert ccx.cavity_volume(mesh, zero, ["cavity"]) == pytest.approx(expected, rel=1e-12)
    # A uniform stretch by 1.5, 1.2 and 2 about the origin.
    stretch = mesh.points * [0.5, 0.2, 1.0]
    assert ccx.cavity_volume(mesh, stretch, ["cavity"]) == pytest.approx(3.6 * expected, rel=1e-12)
    length = spec.geometry.row.length
    height = spec.geometry.base + spec.geometry.chamber_height + spec.geometry.roof
    assert ccx.surface_mean(mesh, mesh.points, "tip") == pytest.approx(
        [length, 3.5, height / 2], rel=1e-12
    )


def test_what_is_not_translated_is_refused(tmp_path):
    spec = spec_of("4 mm", more=("materials.body={law: neo_hookean, c10: 0.1 MPa}",))
    _, mesh = mesh_of(spec, tmp_path)
    with pytest.raises(SpecError, match="materials"):
        ccx.write_input(tmp_path / "job.inp", mesh, spec)

"""Orders of convergence with walls that are curved in the mesh: thick sphere and thick tube.

The closed forms are those of an incompressible neo-Hookean wall; a mesh with straight edges is
measured beside them, so that what the curved ones give is seen.
"""

import csv
import functools
from dataclasses import dataclass

import gmsh
import numpy as np
import pytest
import scipy.integrate
import scipy.optimize
from mpi4py import MPI

from softact.contact.facets import ContactFacets
from softact.geometries.bellows import Bellows
from softact.geometries.bending_tube import BendingTube
from softact.geometries.braided_muscle import BraidedMuscle
from softact.geometries.fiber_reinforced import FiberReinforced
from softact.geometries.from_mesh import FromMesh
from softact.geometries.from_script import FromScript
from softact.geometries.omnidirectional import Omnidirectional
from softact.geometries.shell_reinforced import ShellReinforced
from softact.geometries.thick_sphere import ThickSphere
from softact.geometries.tube import Tube
from softact.geometry.base import make_mesh
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.measures.snapshot import Snapshot
from softact.mesh.curves import bent, volumes
from softact.mesh.msh_file import read_msh
from softact.mesh.tetrahedra import distribute
from softact.mesh.triangles import VOLUME_RULE, shape_functions, tangents
from softact.model import Model, Support
from softact.results.folder import read
from softact.run.start import run
from softact.spec import loads
from tests.analytic.meshes import block
from tests.analytic.solving import build, solve

INNER, C10, STRETCH = 10.0, 0.14, 1.3  # mm, MPa, of the inner surface


@dataclass(frozen=True)
class Wall:
    """A neo-Hookean wall under internal pressure, INNER to ``outer`` mm; a sphere, or a tube whose
    length stays."""

    sphere: bool
    outer: float

    @property
    def outer_stretch(self):
        """Of the circles of the outer surface: the wall keeps its volume."""
        power = 3 if self.sphere else 2
        return (1 + (STRETCH**power - 1) * (INNER / self.outer) ** power) ** (1 / power)

    @property
    def pressure(self):
        """MPa; Ogden 1984, 5.3.2 (sphere) and 5.3.3 (tube)."""

        def slope(s):
            if self.sphere:
                return 4 * C10 * (s - s**-5) / (s**3 - 1)
            return 2 * C10 * (s - s**-3) / (s**2 - 1)

        return scipy.integrate.quad(slope, self.outer_stretch, STRETCH, epsabs=1e-14)[0]

    @property
    def hoop(self):
        """Largest Cauchy stress, around the inner surface, MPa: the radial one is −p there."""
        radial = STRETCH**-4 if self.sphere else STRETCH**-2
        return 2 * C10 * (STRETCH**2 - radial) - self.pressure

    def volume(self, part):
        """Of the inflated cavity of the meshed part, mm³; part: of a sphere, or mm of a tube."""
        if self.sphere:
            return part * 4 / 3 * np.pi * (INNER * STRETCH) ** 3
        return part / 4 * np.pi * (INNER * STRETCH) ** 2


# The sphere's meshes are alike at all sizes, the tube's are not.
SPHERE, TUBE = Wall(True, INNER / (1 - np.pi / 8)), Wall(False, INNER / (1 - np.pi / 8))


def geometry_of(wall, divisions):
    size = wall.outer * np.pi / 2 / divisions * (1 + 1e-9)
    kind, sizes = (ThickSphere, {}) if wall.sphere else (Tube, {"length": size})
    sizes |= {"inner_radius": INNER, "outer_radius": wall.outer, "mesh_size": size}
    return kind(**{name: f"{length:.12g} mm" for name, length in sizes.items()})


@pytest.fixture(scope="module")
def errors(tmp_path_factory):
    """Wall, edges of a quarter, whether they are curved -> errors (meshes, 3) of displacement,
    volume and stress."""
    folder = tmp_path_factory.mktemp("walls")

    @functools.cache
    def solved(wall, divisions, curved):
        return np.array([error(wall, n, curved, folder) for n in divisions])

    return solved


def error(wall, divisions, curved, folder):
    """Relative errors of one mesh: the largest of the inner surface's stretch, in its nodes; the
    inflated cavity's volume; the largest stress."""
    geometry = geometry_of(wall, divisions)
    path, layout = folder / f"{wall.sphere}-{divisions}.msh", geometry.layout()
    make_mesh(geometry, path, curved=curved)
    mesh = distribute(MPI.COMM_SELF, lambda: read_msh(path, layout), layout)
    law = LAWS["neo_hookean"].of(c10=C10, bulk_modulus=1e6)
    model = Model(mesh, {"body": law.material()}, wall_normal=geometry.wall_normal)
    ends = [] if wall.sphere else [Support("clamp", {0: 0.0}), Support("tip", {0: 0.0})]
    loads = {"pressure": {"cavity": wall.pressure}} if wall.sphere else {}
    loads = loads or {"surface_pressure": {"bore": wall.pressure}}
    state = solve(model, LoadStep("inflate", **loads), ends, 0.25).state
    inner = model.surfaces.nodes("cavity" if wall.sphere else "bore")
    moved = model.nodes.places[inner] + state.x[model.displacement_dofs[inner]]
    if not wall.sphere:
        moved = moved[:, 1:]
    stretch = np.linalg.norm(moved, axis=1) / INNER
    volume = model.cavity_volume(state, "cavity") / wall.volume(1 / 8) if wall.sphere else 1.0
    stress = Snapshot(model, state).max_principal_stress.max()
    return np.abs(stretch / STRETCH - 1).max(), abs(volume - 1), abs(stress / wall.hoop - 1)


def orders(found):
    return np.log2(found[:-1] / found[1:])


def test_sphere(errors):
    """Third order of the displacement, fourth of the volume and of the stress at least third; with
    straight edges second and hardly one. Finer meshes: ``python -m benchmarks.curved``."""
    curved, straight = (errors(SPHERE, (4, 8), c) for c in (True, False))
    assert (orders(curved) > [2.7, 3.7, 3]).all(), curved
    assert (curved[-1] < [8e-4, 5e-4, 5e-3]).all(), curved
    assert (orders(straight)[:, :2] < 2.2).all(), straight
    assert (straight[-1] / curved[-1] > [10, 40, 6]).all(), straight


def test_tube(errors):
    """The same in a mesh without order; a tube has no cavity of its own."""
    curved, straight = (errors(TUBE, (8, 16), c)[:, ::2] for c in (True, False))
    assert (orders(curved) > 2.2).all(), curved
    assert (curved[-1] < [1e-4, 3e-3]).all(), curved
    assert (straight[-1] / curved[-1] > [30, 5]).all(), straight


def bellows(divisions, curved):
    """Movement of a crest outward, mm, volume of the air, mm³, and largest stress, MPa, of half a
    convolution of round bellows from crest to root, whose ends do not move along them.

    divisions: elements through the wall, of four along it and two around a quarter each.
    """

    def places(points):
        radius = 11 + 2 * np.cos(np.pi * points[:, 0])
        slope = np.arctan(-2 * np.pi / 8 * np.sin(np.pi * points[:, 0]))
        off, angle = points[:, 2] - 0.5, np.pi / 2 * points[:, 1]
        along, out = 8 * points[:, 0] - 2 * off * np.sin(slope), radius + 2 * off * np.cos(slope)
        return np.column_stack([along, out * np.sin(angle), out * np.cos(angle)])

    tets = block((4 * divisions, 2 * divisions, divisions), mapping=places, curved=curved)
    law = LAWS["neo_hookean"].of(c10=0.1, bulk_modulus=100.0)
    model = build(tets, law, symmetry={"y_min": 1, "y_max": 2})
    ends = [Support("x_min", {0: 0.0}), Support("x_max", {0: 0.0})]
    step = LoadStep("inflate", surface_pressure={"z_min": 8e-3})
    solution = solve(model, step, ends, 0.5)
    crest = solution.displacement((0.0, 0.0, 14.0))[2]
    points, weights = VOLUME_RULE
    x = ContactFacets(model, ("z_min",)).node_places(solution.state.x)
    inward = np.cross(*np.moveaxis(tangents(x, points), -1, 0))
    at = np.einsum("qn,knc->kqc", shape_functions(points, 6), x)
    volume = abs(np.einsum("kqc,kqc,q->", inward[..., 1:], at[..., 1:], weights)) / 4
    return crest, volume, Snapshot(model, solution.state).max_principal_stress.max()


def test_bellows():
    """Round bellows, which have no closed form, against the mesh of twice as many edges: orders of
    displacement and volume as of the sphere, of the largest stress about second."""
    finest = np.array(bellows(4, True))
    curved, straight = (
        np.array([np.abs(np.array(bellows(n, edges)) / finest - 1) for n in (1, 2)])
        for edges in (True, False)
    )
    assert (orders(curved) > [2.7, 3.5, 1.8]).all(), curved
    assert (curved[-1] < [1e-4, 1e-4, 0.03]).all(), curved
    assert (orders(straight)[:, :2] < 2.2).all() and (straight[-1, :2] > 0.02).all(), straight


@pytest.mark.parametrize("divisions", [2, 4, 8])
def test_volume_of_the_mesh(divisions, tmp_path):
    """Of the undeformed cavity: 1.5 % at two edges of a quarter, where straight ones lack 30 %."""
    geometry = geometry_of(SPHERE, divisions)
    path = tmp_path / "sphere.msh"
    make_mesh(geometry, path, curved=True)
    mesh = distribute(MPI.COMM_SELF, lambda: read_msh(path, geometry.layout()), geometry.layout())
    law = LAWS["neo_hookean"].of(c10=C10, bulk_modulus=1e6)
    model = Model(mesh, {"body": law.material()}, wall_normal=geometry.wall_normal)
    found = model.cavity_volume(model.initial_state(), "cavity")
    assert abs(found / geometry.volumes()["cavity"] - 1) < 0.016 * (2 / divisions) ** 3.8
    assert model.solids["body"].volumes.sum() == pytest.approx(geometry.volumes()["body"], rel=2e-2)


ROUND = [
    Bellows(through_wall=1),
    BraidedMuscle(),
    FiberReinforced(),
    ShellReinforced(),
    Omnidirectional(),
    Tube(),
    BendingTube(),
]


@pytest.mark.parametrize("geometry", ROUND, ids=lambda g: g.type)
def test_meshes_have_the_volumes_of_the_round_bodies(geometry, tmp_path):
    """To 2e-4, with the mesh sizes that they have by default; straight edges lack up to 3 %."""
    path, layout = tmp_path / "round.msh", geometry.layout()
    make_mesh(geometry, path, curved=True)
    tets = read_msh(path, layout)
    found = np.abs(volumes(tets.curves.nodes(tets.cells, tets.points)))
    for number, name in enumerate(layout.regions):
        if name in geometry.volumes():
            volume = found[tets.region == number].sum()
            assert volume == pytest.approx(geometry.volumes()[name], rel=2e-4), name


BALL = """
geometry: {type: thick_sphere, inner_radius: 10 mm, outer_radius: 11 mm, mesh_size: 6 mm}
materials: {body: {law: neo_hookean, c10: 0.14 MPa}}
solver: {initial_increment: 1, max_increment: 1}
steps: [{pressure: 1 kPa}]
"""


def test_walls_are_curved_unless_a_spec_says_otherwise(tmp_path):
    """The air at rest and the mesh's remark, of a ball with three edges to a quarter."""
    exact = 4 / 3 * np.pi * 10**3
    volume = {}
    for name, changes in (("curved", {}), ("flat", {"solver.curved": False})):
        outcome = run(loads(BALL).with_(changes), tmp_path / name, report=False)
        assert outcome.status == "complete", outcome.message
        volume[name] = read(tmp_path / name).curve["cavity_volume_mm3"][0]
        remarks = (tmp_path / name / "log.txt").read_text(encoding="utf-8")
        assert ("-14.6% of the closed form" in remarks) == (name == "flat")
    assert volume["curved"] == pytest.approx(exact, rel=4e-3)
    assert volume["flat"] == pytest.approx(0.854 * exact, rel=1e-3)


RUN = """
geometry: {type: tube, inner_radius: 5 mm, outer_radius: 7 mm, length: 4 mm, mesh_size: 3 mm}
materials: {body: {law: neo_hookean, c10: 0.14 MPa, density: 1000 kg/m^3}}
supports: [{surface: clamp, fix: [x]}, {surface: tip, fix: [x]}]
solver: {curved: true, max_increment: 0.5}
contact: none
steps: [{name: inflate, surface_pressure: {bore: 20 kPa}}]
probes: {inside: [2 mm, -5 mm, 0 mm]}
"""


def test_a_run_on_two_processes_goes_on_as_on_one(tmp_path):
    """A probe on the curved bore, beside each other and beside the closed form."""
    curves = []
    for processes in (1, 2):
        outcome = run(loads(RUN), tmp_path / str(processes), processes=processes, report=False)
        assert outcome.status == "complete", outcome.message
        curves.append(read(tmp_path / str(processes)).curve["probe_inside_y_mm"])
    assert curves[1] == pytest.approx(curves[0], rel=1e-9)
    inner, outer = 25.0, 49.0  # squares of the radii
    squared = curves[0][-1] ** 2

    def pressure(grown):
        b = np.sqrt((outer + grown) / outer)
        a = np.sqrt((inner + grown) / inner)
        return 0.14 * (np.log(a / b) + (a**2 - b**2) / (2 * a**2 * b**2)) * 2

    grown = scipy.optimize.brentq(lambda g: pressure(g) - 0.02, 0.0, 30.0)
    assert squared == pytest.approx(inner + grown, rel=2e-3)


def test_derivatives_on_curved_walls(tmp_path):
    """With respect to the material: that of two runs beside."""
    run(loads(RUN), tmp_path / "run", sensitivities=["materials.body.c10"], report=False)
    with (tmp_path / "run" / "sensitivities.csv").open(encoding="utf-8") as file:
        lines = [line for line in csv.DictReader(file) if line["measure"] == "probe_inside_y_mm"]
    assert lines[-1]["unit"] == "mm/kPa"
    places = []
    for c10 in (0.1399, 0.1401):
        spec = loads(RUN.replace("c10: 0.14 MPa", f"c10: {c10} MPa"))
        run(spec, tmp_path / str(c10), report=False)
        places.append(read(tmp_path / str(c10)).curve["probe_inside_y_mm"][-1])
    slope = (places[1] - places[0]) / 0.2  # mm/kPa
    assert float(lines[-1]["derivative"]) == pytest.approx(slope, rel=1e-4)


def test_a_tetrahedron_that_would_fold_keeps_straight_edges():
    """Of two with a common face, the middle of the edge at the corner of the first is moved beyond
    the opposite face; a small bulge stays."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], float)
    cells = np.array([[0, 1, 2, 3], [1, 2, 3, 4]])
    far = bent(np.array([[0, 1]]), points, np.array([[0.5, 0.6, 0.6]]))
    assert len(far) == 1
    kept, folded = far.sound(cells[:1], points)
    assert (len(kept), folded) == (0, 1)
    near = bent(
        np.array([[0, 1], [1, 4]]), points, np.array([[0.5, -0.05, -0.05], [1.05, 0.5, 0.5]])
    )
    kept, folded = near.sound(cells, points)
    assert (len(kept), folded) == (2, 0)


@pytest.mark.parametrize("kind", [FromMesh, FromScript])
def test_a_file_of_the_second_order_keeps_its_curves(kind, tmp_path):
    """With edges of 4 mm on a ball of 10 mm straight ones lack 3.6 % of its volume, curved
    ones less than 5e-4."""
    file = tmp_path / "ball.msh"
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.occ.addSphere(0, 0, 0, 10)
        gmsh.model.occ.synchronize()
        for dimension, name in ((3, "body"), (2, "skin")):
            tags = [tag for _, tag in gmsh.model.getEntities(dimension)]
            gmsh.model.addPhysicalGroup(dimension, tags, 1)
            gmsh.model.setPhysicalName(dimension, 1, name)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 4)
        gmsh.option.setNumber("Mesh.ElementOrder", 2)
        gmsh.model.mesh.generate(3)
        gmsh.write(str(file))
    finally:
        gmsh.finalize()
    given = {"file": str(file), "cavities": {}, "clamp": "skin", "tip": "skin", "mesh_size": "4 mm"}
    geometry = kind.model_validate(given)
    found = {}
    for curved in (False, True):
        make_mesh(geometry, tmp_path / "part.msh", curved=curved)
        tets = read_msh(tmp_path / "part.msh", geometry.layout())
        found[curved] = np.abs(volumes(tets.curves.nodes(tets.cells, tets.points))).sum()
    whole = 4 / 3 * np.pi * 10**3
    assert found[False] == pytest.approx(0.964 * whole, rel=5e-3)
    assert found[True] == pytest.approx(whole, rel=5e-4)


STIFFENED = """
geometry: {type: tube, inner_radius: 5 mm, outer_radius: 7 mm, length: 3 mm, mesh_size: 2 mm}
materials: {body: {law: neo_hookean, c10: 0.14 MPa, poissons_ratio: 0.4999999}}
layers:
  - surface: outer
    thickness: 0.02 mm
    wrinkling: WRINKLING
    material: {law: linear, youngs_modulus: 50 MPa, poissons_ratio: 0.3}
supports: [{surface: clamp, fix: [x]}, {surface: tip, fix: [x]}]
solver: {curved: true, initial_increment: 1, max_increment: 1}
contact: none
steps: [{name: inflate, surface_pressure: {bore: 0.001 kPa}}]
probes: {inside: [1.5 mm, -5 mm, 0 mm]}
"""


@pytest.mark.parametrize("wrinkling", ["tension_field", "resolved"])
def test_a_layer_on_a_curved_wall(wrinkling, tmp_path):
    """A ring of hoop stiffness E t/(1 - ν²) around an incompressible tube (Lamé): with u = A/r,
    p = 2 μ A (1/a² - 1/b²) + E t/(1 - ν²) A/b³."""
    text = STIFFENED.replace("WRINKLING", wrinkling)
    outcome = run(loads(text), tmp_path / "run", report=False)
    assert outcome.status == "complete", outcome.message
    moved = -5 - read(tmp_path / "run").curve["probe_inside_y_mm"][-1]
    hoop = 50 * 0.02 / (1 - 0.3**2)
    exact = 1e-6 / (4 * 0.14 * (1 / 25 - 1 / 49) + hoop / 343) / 5
    assert moved == pytest.approx(exact, rel=5e-3)

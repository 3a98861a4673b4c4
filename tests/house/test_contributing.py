"""The walk-throughs of CONTRIBUTING.md, carried out in a copy of softact."""

import csv
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parents[2]
REGISTRY = {
    "geometries/__init__.py": "from softact.geometries.pouch import Pouch\n"
    'GEOMETRIES["pouch"] = Pouch\n',
    "softact/materials/laws/__init__.py": "from softact.materials.laws.veronda_westmann import "
    'VerondaWestmann\nLAWS["veronda_westmann"] = VerondaWestmann\n',
    "softact/measures/__init__.py": "from softact.measures.chord import CHORD\n"
    'MEASURES["chord"] = CHORD\n',
    "softact/loads/__init__.py": "from softact.loads.spring_bed import SpringBed\n"
    "register(SpringBed())\n",
    "softact/contact/obstacles/__init__.py": "from softact.contact.obstacles.torus import "
    'TorusObstacle\nOBSTACLES["torus"] = TorusObstacle\n',
    "softact/bodies/__init__.py": "from softact.bodies.thread import Threads\n"
    'BODIES["threads"] = Threads()\n',
    "softact/solve/rungs/__init__.py": "from softact.solve.rungs.note import Note\n"
    "RUNGS = (Note(), *RUNGS)\n",
}
SPEC = """\
geometry: {type: pouch, mesh_size: 10 mm}
materials:
  body: {law: veronda_westmann, c1: 0.1 MPa, c2: 1.5}
steps:
  - {supports: [{surface: clamp, fix: [x, y, z]}, {surface: tip, fix: [y, z], move: {x: 2 mm}}]}
measures: [chord]
"""


def in_package(path: str) -> str:
    """Where a file of the repository is in an installed softact."""
    return re.sub(r"^(cli|geometries)/", r"softact/\1/", path)


@pytest.fixture(scope="module")
def extended(tmp_path_factory):
    """Folder of a softact to which everything on the page has been added."""
    folder = tmp_path_factory.mktemp("extended")
    without_caches = shutil.ignore_patterns("__pycache__")
    shutil.copytree(TREE / "softact", folder / "softact", ignore=without_caches)
    for part in ("cli", "geometries"):
        shutil.copytree(TREE / part, folder / "softact" / part, ignore=without_caches)
    page = (TREE / "CONTRIBUTING.md").read_text(encoding="utf-8")
    files = re.findall(r"^`(\S+\.py)`:\n\n```python\n(.*?)^```", page, re.M | re.S)
    assert len(files) >= len(REGISTRY)
    for path, code in files:
        assert not (TREE / path).exists(), f"{path} is there already: choose another example"
        (folder / in_package(path)).write_text(code, encoding="utf-8")
    for path, lines in REGISTRY.items():
        with (folder / in_package(path)).open("a", encoding="utf-8") as registry:
            registry.write(lines)
    return folder


def run(folder, *arguments, **options):
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
        **options,
    )


def test_the_geometry_runs_by_itself_and_refuses_what_cannot_be_built(extended):
    script = "softact/geometries/pouch.py"
    good = run(extended, script, "--wall", "1 mm", "-o", "pouch.msh")
    assert good.returncode == 0, good.stderr
    assert (extended / "pouch.msh").read_text().startswith("$MeshFormat\n4.1 ")
    bad = run(extended, script, "--wall", "5 mm", "-o", "bad.msh")
    assert bad.returncode == 2
    assert bad.stderr == "wall: 5 mm on both sides fills the height: no room is left\n"


def test_the_law_is_what_the_page_says(extended):
    # Uniaxial, incompressible: W = W(λ² + 2/λ, 2λ + 1/λ²), nominal stress dW/dλ, at λ = 1.2:
    # 0.1 · 1.5 · exp(1.5 · 0.106667) (2.4 − 1.388889) − 0.075 (2 − 1.157407) = 0.114788 MPa.
    code = (
        "from softact.materials import LAWS; import numpy as np;"
        "law = LAWS['veronda_westmann'].of(c1=0.1, c2=1.5); stretch = 1.2;"
        "C = np.diag([stretch**2, 1 / stretch, 1 / stretch])[None];"
        "S = law.material().stress_tangent(C)[0][0];"
        "print(law.shear_modulus, stretch * (S[0] - S[1] / stretch**3))"
    )
    done = run(extended, "-c", code)
    assert done.returncode == 0, done.stderr
    modulus, stress = map(float, done.stdout.split())
    assert modulus == pytest.approx(2 * (0.1 * 1.5 - 0.075), rel=1e-12)
    assert stress == pytest.approx(0.114788, rel=1e-5)


def test_the_measure_is_a_column_of_a_run_with_the_new_geometry_and_law(extended):
    (extended / "spec.yaml").write_text(SPEC)
    done = run(extended, "-m", "softact.cli.main", "run", "spec.yaml", "-o", "result")
    assert done.returncode == 0, done.stderr
    with (extended / "result/curve.csv").open() as file:
        rows = list(csv.DictReader(file))
    # The pouch is 40 mm long and its tip is moved by 2 mm.
    assert float(rows[0]["chord_length_mm"]) == pytest.approx(40.0, rel=1e-9)
    assert float(rows[-1]["chord_length_mm"]) == pytest.approx(42.0, rel=1e-9)


BLOCK = """\
geometry: {type: block, length: 4 mm, width: 2 mm, height: 2 mm, mesh_size: 2 mm}
materials: {body: {law: neo_hookean, c10: 0.14 MPa, bulk_modulus: 1000 MPa}}
supports:
  - {surface: x_min, fix: [x]}
  - {surface: y_min, fix: [y]}
  - {surface: z_min, fix: [z]}
solver: {initial_increment: 0.25, max_increment: 0.25}
"""
TORUS = """\
obstacles: {ring: {type: torus, center: [2 mm, 1 mm, 3.7 mm], axis: [0, 1, 0], ring: 1 mm,
  radius: 0.5 mm}}
"""
# Runs a spec, and once more with a kill after some increments and a resume: says the last rows.
KILLED = """
import sys, csv, pathlib
from mpi4py import MPI
from softact import spec as specs
from softact.geometry.base import make_mesh
from softact.run.worker import solve

spec = specs.loads(pathlib.Path(sys.argv[1]).read_text())
mesh = pathlib.Path("mesh.msh")
make_mesh(spec.geometry, mesh)


def run(folder, after=None, again=False):
    count = 0

    def tell(event):
        nonlocal count
        count += event["stage"] == "increment"
        if after is not None and count > after:
            raise KeyboardInterrupt

    try:
        solve(MPI.COMM_SELF, spec, mesh, pathlib.Path(folder), {}, tell, again)
    except KeyboardInterrupt:
        pass
    with open(folder + "/curve.csv") as file:
        return list(csv.DictReader(file))


whole = run(sys.argv[2])
run(sys.argv[2] + "_cut", after=int(sys.argv[3]))
resumed = run(sys.argv[2] + "_cut", again=True)
assert len(whole) == len(resumed)
for one, other in zip(whole, resumed):
    for key, value in one.items():
        try:
            assert abs(float(value) - float(other[key])) <= 1e-6 * max(abs(float(value)), 1e-3), key
        except ValueError:
            assert value == other[key], key
"""


def solved(folder, name, text, after):
    """Rows of the curve of a spec, of a run that was also killed and resumed to the same
    numbers."""
    (folder / f"{name}.yaml").write_text(text)
    done = run(folder, "-c", KILLED, f"{name}.yaml", name, str(after))
    assert done.returncode == 0, done.stderr[-2000:]
    with (folder / name / "curve.csv").open() as file:
        return list(csv.DictReader(file))


def listed(folder, kind):
    done = run(folder, "-m", "softact.cli.main", "list", kind)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_load_is_solved_resumed_and_listed(extended):
    """t = 2 c10 (λ − λ⁻²) + k L (λ − 1)/A: 4 mm long, 4 mm², 0.2 N/mm. The springs hold the face's
    sides a little, too."""
    pull = "traction: {surface: x_max, value: [400 kPa, 0 kPa, 0 kPa]}"
    text = (
        f"{BLOCK}steps: [{{name: bed, spring_bed: {{x_max: 0.2 N/mm}}}}, {{name: pull, {pull}}}]\n"
    )
    rows = solved(extended, "bed", text, after=7)
    stretch = 1 + float(rows[-1]["elongation_mm"]) / 4
    sides = 0.28 * (stretch - stretch**-2) + 0.2 * 4 * (stretch - 1) / 4
    assert sides == pytest.approx(0.4, rel=0.01)
    assert stretch > 1.3
    assert "spring_bed" in listed(extended, "loads")
    bad = text.replace("spring_bed: {x_max", "spring_bed: {x_maxx")
    (extended / "bad.yaml").write_text(bad)
    done = run(extended, "-m", "softact.cli.main", "validate", "bad.yaml")
    assert done.returncode == 2
    assert "did you mean 'x_max'" in done.stderr


def test_the_obstacle_is_solved_and_resumed(extended):
    code = (
        "import numpy as np; from softact.contact.obstacles.torus import Torus;"
        "t = Torus((1.0, 2.0, 3.0), (1.0, 2.0, -1.0), 3.0, 1.0);"
        "x = np.random.default_rng(0).uniform(-4, 8, (50, 3)); g, n, h = t.distance(x); s = 1e-5;"
        "np.testing.assert_allclose(t.gap(x), g, rtol=1e-13);"
        "d = [(t.distance(x + s * e), t.distance(x - s * e)) for e in np.eye(3)];"
        "N = np.stack([(a[0] - b[0]) / (2 * s) for a, b in d], -1);"
        "H = np.stack([(a[1] - b[1]) / (2 * s) for a, b in d], -1);"
        "assert (g < 0).any() and (g > 0).any();"
        "np.testing.assert_allclose(n, N, atol=1e-7); np.testing.assert_allclose(h, H, atol=1e-6)"
    )
    done = run(extended, "-c", code)
    assert done.returncode == 0, done.stderr
    press = "obstacles: {ring: {move: [0 mm, 0 mm, -0.4 mm]}}"
    text = f"{BLOCK}{TORUS}steps: [{{name: press, {press}}}]\n"
    rows = solved(extended, "torus", text, after=2)
    force = float(rows[-1]["contact_force_ring_z_N"])
    assert force < -1e-3
    assert float(rows[-1]["reaction_z_min_z_N"]) == pytest.approx(-force, rel=1e-4)


def test_the_body_is_solved_and_resumed(extended):
    """t A = 2 c10 (λ − λ⁻²) A + E A₀ λ (λ² − 1)/2 along four edges that stay straight."""
    edges = [("y_min", "z_min"), ("y_min", "z_max"), ("y_max", "z_min"), ("y_max", "z_max")]
    threads = ", ".join(f"{{between: [{a}, {b}], stiffness: 0.1 N}}" for a, b in edges)
    pull = "supports: [{surface: x_min, fix: [x]}, {surface: y_min, fix: [y]}, "
    pull += "{surface: z_min, fix: [z]}, {surface: x_max, move: {x: 1.2 mm}}]"
    text = f"{BLOCK}threads: [{threads}]\nsteps: [{{name: pull, {pull}}}]\n"
    rows = solved(extended, "thread", text, after=2)
    stretch = 1.3
    force = 0.28 * (stretch - stretch**-2) * 4 + 4 * 0.1 * stretch * (stretch**2 - 1) / 2
    assert float(rows[-1]["tip_force_x_N"]) == pytest.approx(-force, rel=1e-3)
    done = run(extended, "-m", "softact.cli.main", "schema")
    assert '"threads"' in done.stdout


def test_the_rung_is_asked(extended):
    """A load that jumps in one increment fails at first."""
    hard = "traction: {surface: x_max, value: [0 kPa, 0 kPa, 60 kPa]}"
    text = BLOCK.replace("0.25", "1.0").replace("fix: [x]", "fix: [x, y, z]", 1)
    text = text.replace("max_increment: 1.0", "max_increment: 1.0, max_iterations: 3")
    rows = solved(extended, "rung", f"{text}steps: [{{name: hard, {hard}}}]\n", after=1)
    assert float(rows[-1]["step_fraction"]) == 1.0
    assert "step 'hard' is hard beyond 0.0%" in (extended / "rung/run.json").read_text()

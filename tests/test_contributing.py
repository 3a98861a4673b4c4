"""The walk-throughs of CONTRIBUTING.md, carried out in a copy of softact."""

import csv
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parent.parent
REGISTRY = {
    "geometries/__init__.py": "from softact.geometries.pouch import Pouch\n"
    'GEOMETRIES["pouch"] = Pouch\n',
    "softact/materials/__init__.py": "from softact.materials.laws.veronda_westmann import "
    'VerondaWestmann\nLAWS["veronda_westmann"] = VerondaWestmann\n',
    "softact/measures/__init__.py": "from softact.measures.chord import CHORD\n"
    'MEASURES["chord"] = CHORD\n',
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

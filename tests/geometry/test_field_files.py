"""Files that people brought (``shared/field`` beside the repository) each end well.

Skipped where the folder is not there; files alike are made by OCC in ``tests/geometries``.
"""

import csv
import re
import shlex
from pathlib import Path

import pytest

from softact.cli.main import main
from softact.errors import MeshError
from softact.geometry.base import look, make_mesh
from softact.run.start import run
from softact.spec import Spec, load, loads

BESIDE = [folder / "shared" / "field" for folder in Path(__file__).resolve().parents[2:6]]
FIELD = next((folder for folder in BESIDE if folder.is_dir()), None)
pytestmark = pytest.mark.skipif(FIELD is None, reason="there is no shared/field beside the tree")


def of_bladder(file: str, more: str = "") -> Spec:
    """The spec of the bladder with another file in its place."""
    text = (FIELD / "bladder.yaml").read_text()
    assert "file: bladder.step" in text
    return loads(text.replace("file: bladder.step", f"file: {FIELD / file}{more}"))


def solved(spec: Spec, folder: Path) -> dict[str, float]:
    """The last row of curve.csv, on a coarse mesh in few increments."""
    coarse = spec.geometry.model_copy(update={"mesh_size": 8.0})
    solver = spec.solver.model_copy(update={"initial_increment": 0.5, "max_increment": 0.5})
    outcome = run(
        spec.model_copy(update={"geometry": coarse, "solver": solver}), folder, report=False
    )
    assert outcome.status == "complete"
    with (folder / "curve.csv").open() as file:
        return list(csv.DictReader(file))[-1]


def test_the_base_of_two_solids_takes_part(tmp_path):
    """It stayed at rest, since nothing joined it to the rubber above."""
    last = solved(load(FIELD / "two.yaml"), tmp_path / "two")
    assert float(last["principal_stress_peak_base_MPa"]) > 1e-4
    assert float(last["cavity_volume_mm3"]) > 32 * 8 * 6


def test_solids_that_share_a_whole_face(tmp_path):
    text = (FIELD / "two.yaml").read_text().replace("two.step", str(FIELD / "two_same.step"))
    last = solved(loads(text), tmp_path / "two")
    assert float(last["principal_stress_peak_base_MPa"]) > 1e-4


@pytest.mark.parametrize("file", ["bladder.step", "unnamed.step"])
def test_a_bladder_with_names_and_without(file, tmp_path):
    """One is the other without names: the faces that are found are those that were named."""
    spec = of_bladder(file)
    if file == "unnamed.step":
        spec = loads(spec.to_yaml().replace("skin", "outer"))
    last = solved(spec, tmp_path / "one")
    assert float(last["cavity_volume_mm3"]) > 32 * 8 * 8


def test_a_part_drawn_in_mm_and_said_to_be_in_m(tmp_path):
    with pytest.raises(MeshError, match="write unit: mm"):
        make_mesh(of_bladder("drawn_mm_said_m.step").geometry, tmp_path / "x.msh", 60.0)
    said: list[str] = []
    look(of_bladder("drawn_mm_said_m.step", ", unit: mm").geometry, said)
    assert "40 x 14 x 14 mm (in mm)" in said[0]


TABLES = {
    **{f"01-kgf_uni_{x}.csv": ("", "24 points, stretch 1.02 to 7.2") for x in "abcd"},
    **{f"01-kgf_equi_{x}.csv": (":equibiaxial", "24 points, stretch 1.02 to 4.4") for x in "abcd"},
    **{f"01-kgf_planar_{x}.csv": (":planar", "24 points, stretch 1.02 to 5") for x in "abcd"},
    "03-bluehill-locale_probe.csv": ("", "86 points, stretch 1 to 3.38, stress to 462 kPa"),
    "31-cauchy_strip.csv": ("", "120 points, stretch 1 to 2, stress to 399 kPa"),
    "33-strain500fit_soft.csv": ("", "397 points, stretch 1 to 9.734, stress to 198 kPa"),
}
SIZES = {"length": "12 mm", "width": "6 mm", "thickness": "2 mm", "area": "600 mm^2"}
REFUSED = {
    "02-mts-two-line-header_strip.csv": ("", "87 points"),
    "32-squisher_puck.csv": (":compression", "621 points"),
}


def fitted(capsys, folder: Path, *arguments: str) -> tuple[int, str]:
    """Exit code and both outputs of ``softact fit``."""
    with pytest.raises(SystemExit) as left:
        main(["fit", *arguments, "--law", "neo_hookean", "--starts", "1", "-o", str(folder)])
    return left.value.code, "".join(capsys.readouterr())


@pytest.mark.parametrize("file", TABLES)
def test_a_table_of_a_machine_is_read(file, tmp_path, capsys):
    mode, said = TABLES[file]
    code, told = fitted(capsys, tmp_path / "fit", f"{FIELD / file}{mode}")
    assert code == 0 and said in told, told


@pytest.mark.parametrize("file", REFUSED)
def test_a_table_is_refused_with_the_command_that_reads_it(file, tmp_path, capsys):
    """The command reads it once the specimen's sizes stand in place of the question marks."""
    mode, said = REFUSED[file]
    code, told = fitted(capsys, tmp_path / "fit", f"{FIELD / file}{mode}")
    (command,) = re.findall(r"read it with: softact fit (.*), with the specimen's sizes", told)
    assert code == 2 and not (tmp_path / "fit").exists()
    for size, value in SIZES.items():
        command = re.sub(rf"(--{size} )'[^']*'", rf"\1'{value}'", command)
    code, told = fitted(capsys, tmp_path / "fit", *shlex.split(command))
    assert code == 0 and said in told, told

"""The two commands of a fresh machine: what they set up, and what they leave alone."""

import importlib.metadata
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from softact.doctor.supply import CONDA

TREE = Path(__file__).resolve().parents[2]
PACKAGES = [
    line.split("#")[0].strip()
    for line in (TREE / ".ci/packages.txt").read_text().splitlines()
    if line.split("#")[0].strip()
]


def make(*arguments):
    done = subprocess.run(
        ["make", "--no-print-directory", *arguments], cwd=TREE, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_second_set_up_does_nothing_without_a_network():
    # A network namespace of its own has no interface that is up, not even the loopback.
    alone = ["unshare", *([] if os.geteuid() == 0 else ["-r"]), "--net"]
    if subprocess.run([*alone, "true"], capture_output=True).returncode:
        pytest.skip("the network cannot be taken away here")
    done = subprocess.run([*alone, TREE / ".ci/setup"], capture_output=True, text=True, timeout=20)
    assert (done.returncode, done.stdout) == (0, ""), "run `make setup` first"


@pytest.mark.parametrize("target", ["run", "test", "lint", "docs", "docs-site", "benchmark"])
def test_each_target_sets_up_before_it_works(target):
    first, *rest = make("--dry-run", target).splitlines()
    assert first.strip() == ".ci/setup"
    assert any(".venv/bin/" in line for line in rest)


def test_run_solves_the_glove_finger():
    assert ".venv/bin/softact run configs/pneunet_glove.yaml -n " in make("--dry-run", "run")


def test_help_lists_every_target():
    listed = {line.split()[0] for line in make().splitlines()}
    phony = re.search(r"^\.PHONY: (.*)$", (TREE / "Makefile").read_text(), re.M).group(1)
    assert listed == set(phony.split())


def test_the_packages_are_there_and_named_once():
    names = [name.removesuffix("?") for name in PACKAGES]
    assert len(set(names)) == len(names)
    for name, line in zip(names, PACKAGES, strict=True):
        query = ["dpkg-query", "-W", "-f=${db:Status-Status}", name]
        status = subprocess.run(query, capture_output=True, text=True).stdout
        assert status == "installed" or line.endswith("?"), name


def test_the_doctor_sends_nobody_to_a_package_that_the_set_up_does_not_know():
    assert set(CONDA) <= {name.removesuffix("?") for name in PACKAGES}
    source = "".join(path.read_text() for path in (TREE / "softact/doctor").glob("*.py"))
    calls = re.findall(r"\bpackages\(([\"'][^)]*[\"'])\)", source)
    named = {name.strip().strip("\"'") for call in calls for name in call.split(",")}
    assert "python3-dolfinx" in named
    assert named <= set(CONDA)


def test_numpy_suits_the_dolfinx_of_this_release():
    # Debian 12's dolfinx and petsc4py are compiled against numpy 1, Debian 13's against numpy 2.
    major = importlib.metadata.version("numpy").split(".")[0]
    assert major == ("1" if sys.version_info < (3, 12) else "2")


def test_an_installed_softact_has_every_package_and_data_file():
    # An editable install finds files that are not listed; a plain one does not.
    project = tomllib.loads((TREE / "pyproject.toml").read_text())["tool"]["setuptools"]
    folders = {name: TREE / folder for name, folder in project["package-dir"].items()}
    found = {
        ".".join((name, *init.parent.relative_to(folder).parts))
        for name, folder in folders.items()
        for init in folder.rglob("__init__.py")
    }
    assert set(project["packages"]) == found
    data = {p for p in folders["softact"].rglob("*") if p.is_file() and p.suffix != ".py"}
    data = {p for p in data if "__pycache__" not in p.parts}
    listed = {
        path
        for name, patterns in project["package-data"].items()
        for pattern in patterns
        for path in (TREE / name.replace(".", "/")).glob(pattern)
    }
    assert data - listed == set()


ROOT_NEEDED = pytest.mark.skipif(os.geteuid() != 0, reason="debootstrap needs root")


def build_root(tmp_path, debootstrap, release="13"):
    """`.ci/debian RELEASE build` into tmp_path with a stand-in for debootstrap."""
    tools = tmp_path / "tools"
    tools.mkdir()
    (tools / "debootstrap").write_text(f"#!/bin/sh\n{debootstrap}\n")
    (tools / "debootstrap").chmod(0o755)
    environment = {
        **os.environ,
        "SOFTACT_ROOTS": str(tmp_path),
        "PATH": f"{tools}:{os.environ['PATH']}",
    }
    return subprocess.run(
        [TREE / ".ci/debian", release, "build"], env=environment, capture_output=True, text=True
    )


@ROOT_NEEDED
@pytest.mark.parametrize(
    ("release", "name", "suite"), [("13", "debian13", "trixie"), ("sid", "sid", "sid")]
)
def test_a_half_made_root_is_built_anew(tmp_path, release, name, suite):
    root = tmp_path / name
    root.mkdir()
    (root / "half-made").touch()
    # Options come first, then the suite, the folder and, if there is one, the mirror.
    code = 'while [ "${1#--}" != "$1" ]; do shift; done; mkdir "$2"; echo "$1" > "$2/suite"'
    done = build_root(tmp_path, code, release)
    assert done.returncode == 0, done.stderr
    assert "half made" in done.stderr
    assert (root / "suite").read_text() == f"{suite}\n"
    assert not (root / "half-made").exists()


@ROOT_NEEDED
def test_a_failed_debootstrap_leaves_no_root_and_says_why(tmp_path):
    done = build_root(tmp_path, "echo 'E: no such mirror'; exit 1")
    assert done.returncode == 1
    assert "E: no such mirror" in done.stderr
    assert not (tmp_path / "debian13").exists()


def test_a_release_that_is_not_known_is_refused():
    done = subprocess.run([TREE / ".ci/debian", "11", "build"], capture_output=True, text=True)
    assert done.returncode == 2
    assert "RELEASE is 12, 13 or sid" in done.stderr


def test_the_scripts_pass_shellcheck():
    if shutil.which("shellcheck") is None:
        pytest.skip("shellcheck is not installed")
    scripts = [TREE / ".ci" / name for name in ("run", "setup", "debian", "first_actuator")]
    done = subprocess.run(["shellcheck", *scripts], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout

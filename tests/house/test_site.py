"""The frame of the docs site. `make docs-site` builds it strictly, in CI, too."""

import importlib.util
from pathlib import Path

import pytest
import yaml

from softact.doctor.supply import CONDA

TREE = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def hooks():
    pytest.importorskip("mkdocs")
    spec = importlib.util.spec_from_file_location("hooks", TREE / ".ci/site/hooks.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("page", "link", "place"),
    [
        ("sheets.md", "contact.md", "contact.md"),
        ("sheets.md", "../softact/bodies/plate.py", "repository/softact/bodies/plate.py"),
        ("platforms.md", "../.ci/Dockerfile", "repository/ci/Dockerfile"),
        ("tutorial/own_cad.md", "../../CONTRIBUTING.md", "CONTRIBUTING.md"),
        ("CONTRIBUTING.md", "docs/house.md", "house.md"),
        ("tutorial/x.md", "../notebooks/a.ipynb", "notebooks/a.md"),
    ],
)
def test_where_a_link_leads_on_the_site(hooks, page, link, place):
    assert hooks.site_place(hooks.in_repository(page, link)) == place


def test_links_in_code_stay(hooks):
    text = "[a](../b.py) `[a](../b.py)`\n```sh\n[a](../b.py)\n```\n"
    changed = hooks.outside_of_code(text, lambda part: part.replace("../b.py", "c"))
    assert changed.count("../b.py") == 2 and changed.startswith("[a](c)")


def test_every_command_has_its_help_on_the_page(hooks):
    page = hooks.commands()
    for path in (TREE / "cli").glob("[a-z]*.py"):
        if path.stem != "main":
            assert f"## softact {path.stem}\n" in page
            assert f"Usage: softact {path.stem}" in page


def test_a_notebook_is_a_page(hooks):
    page = hooks.as_page(TREE / "docs/notebooks/first_actuator.ipynb")
    assert page.startswith("# First actuator")
    assert "```python\nimport softact\n" in page
    assert "<table><thead>" in page and "data:image/png;base64," in page


def test_the_conda_environment_has_what_the_doctor_asks_for():
    listed = yaml.safe_load((TREE / ".ci/environment.yml").read_text())["dependencies"]
    names = {entry.split("=")[0].rstrip("<>") for entry in listed if isinstance(entry, str)}
    wanted = {name.strip("'").split("=")[0] for name in CONDA.values() if name}
    assert wanted - names == {"calculix"}  # for the comparison alone

"""docs/materials.md is the page that the code writes, and says what the issue asks of it."""

import importlib.util
from pathlib import Path

from softact.materials import CARDS, LAWS

DOCS = Path(__file__).parents[2] / "docs"


def written() -> str:
    spec = importlib.util.spec_from_file_location("docs_materials", DOCS / "materials.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.page()


def test_the_page_is_current():
    assert (DOCS / "materials.md").read_text(encoding="utf-8") == written()


def test_every_law_and_card_stands_on_the_page():
    page = written()
    for name, law in LAWS.items():
        assert f"### {name}\n" in page and law.formula in page and law.reference in page
        for constant in law.constants():
            assert f"| `{constant.name}` | {constant.unit} |" in page
    for card in CARDS:
        assert f"### {card}\n" in page

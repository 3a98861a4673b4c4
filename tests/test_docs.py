"""The generated page says what the code says."""

import importlib.util
from pathlib import Path

from softact.materials import CARDS, LAWS

DOCS = Path(__file__).resolve().parent.parent / "docs"


def generator():
    spec = importlib.util.spec_from_file_location("generate", DOCS / "generate.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_in_the_repository_is_the_current_one():
    assert (DOCS / "reference.md").read_text(encoding="utf-8") == generator().page(), "make docs"


def test_the_page_shows_every_law_and_card_and_the_units_of_a_constant():
    page = generator().page()
    for law in LAWS:
        assert f"\n### {law}\n" in page
    for card in CARDS:
        assert f"\n| `{card}` |" in page
    # Elastosil's constants as Polygerinos 2013 gives them (Yeoh, MPa).
    assert "c10 0.11 MPa, c20 0.02 MPa" in page
    assert "| `outer_wall` | length | 1 mm |" in page

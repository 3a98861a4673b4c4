"""The generated pages say what the code and the data say."""

import importlib.util
import sys
from pathlib import Path

from softact.geometries import GEOMETRIES
from softact.measures import MEASURES

DOCS = Path(__file__).resolve().parents[2] / "docs"


def generator(name="reference"):
    sys.path.append(str(DOCS))
    spec = importlib.util.spec_from_file_location(name, DOCS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_in_the_repository_is_the_current_one():
    assert (DOCS / "reference.md").read_text(encoding="utf-8") == generator().page(), "make docs"


def test_the_table_of_published_figures_is_the_current_one():
    text = (DOCS / "validation.md").read_text(encoding="utf-8")
    assert text == generator("validation_table").written(text), "make docs"


def test_the_page_shows_every_geometry_and_measure_with_units():
    page = generator().page()
    for name in (*GEOMETRIES, *MEASURES):
        assert f"\n### {name}\n" in page
    # From the files themselves: geometries/pneunet.py and softact/measures/elongation.py.
    assert "| `outer_wall` | length | 1 mm |" in page
    assert "| `elongation_mm` | displacement" in page

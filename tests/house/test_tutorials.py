"""Tutorials and notebooks, carried out: what they show is what the commands print."""

import importlib.util
import json
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGES = sorted((DOCS / "tutorial").glob("*.md"))
NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))


def load_tool():
    spec = importlib.util.spec_from_file_location("carry_out", DOCS / "tutorial/carry_out.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


TOOL = load_tool()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_tutorial_shows_what_its_commands_print(page, tmp_path):
    shown = 0
    for call, printed in TOOL.carry_out(page, tmp_path):
        if call[2] is not None:
            assert TOOL.difference(call[2], printed) == "", call[1]
            shown += 1
    assert shown, "the page shows no output"


def test_what_a_difference_is():
    assert TOOL.difference("angle 30.8 in 3 s\n", "angle 30.6   in 2 min 1.5 s\n") == ""
    assert "31.8" in TOOL.difference("angle 30.8\n", "angle 31.8\n")
    assert TOOL.difference("angle 30.8\n", "angel 30.8\n")
    assert TOOL.difference("one\n", "one\ntwo\n") and TOOL.difference("one\ntwo\n", "one\n")


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_shows_what_its_cells_put_out(path, tmp_path, monkeypatch):
    for module in ("nbformat", "nbclient", "ipykernel"):
        pytest.importorskip(module)
    for name in ("IPYTHONDIR", "JUPYTER_DATA_DIR", "JUPYTER_CONFIG_DIR"):
        monkeypatch.setenv(name, str(tmp_path / name))
    kept = json.loads(path.read_text(encoding="utf-8"))
    notebook = TOOL.executed(path, tmp_path)
    for before, after in zip(kept["cells"], notebook.cells, strict=True):
        for one, other in zip(texts(before), texts(after), strict=True):
            assert TOOL.difference(one, other) == "", before["source"]


def texts(cell):
    """What a cell has printed and returned, as text."""
    outputs = cell.get("outputs", [])
    found = [output.get("text") or output["data"]["text/plain"] for output in outputs]
    return ["".join(text) for text in found]

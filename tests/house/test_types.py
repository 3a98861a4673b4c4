"""Every parameter has a type. `make lint` runs mypy itself, with no module excused."""

import tomllib
from pathlib import Path

from benchmarks.house import files, ignored, parameters


def test_every_parameter_has_a_type():
    sources = {name: file.read_text(encoding="utf-8") for name, file in files().items()}
    assert [name for name, source in sources.items() if parameters(source)[0]] == []


def test_mypy_looks_everywhere():
    project = Path(__file__).resolve().parents[2] / "pyproject.toml"
    settings = tomllib.loads(project.read_text(encoding="utf-8"))["tool"]["mypy"]
    assert settings["disallow_untyped_defs"] and "overrides" not in settings
    assert sum(ignored(file.read_text(encoding="utf-8")) for file in files().values()) == IGNORED


#: Lines at which mypy is told to look away, each with its reason beside it.
IGNORED = 0


def test_what_a_parameter_without_a_type_is():
    source = "class A:\n def f(self, a, b: int, *c, d=1, **e: str): ...\ng = lambda x: x"
    assert parameters(source) == (3, 5)

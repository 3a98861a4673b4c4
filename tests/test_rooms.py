"""Imports go down: from a room to lower ones, never in a circle.

The order of the rooms is the table in CONTRIBUTING.md, section 'Where things are'. Imports inside
functions count; those under ``TYPE_CHECKING`` do not. That a module's packages are imported before
it is not counted: they are in its own room.
"""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

TREE = Path(__file__).parents[1]
FOLDERS = {"softact": "softact", "softact.cli": "cli", "softact.geometries": "geometries"}

# Imports from a lower room to a higher one that are still there, (module, module). The list may
# only shrink: one that is mended has to be taken out.
ALLOWED: set[tuple[str, str]] = set()


def _modules() -> dict[str, Path]:
    found = {}
    for package, folder in FOLDERS.items():
        for file in (TREE / folder).rglob("*.py"):
            parts = file.relative_to(TREE / folder).with_suffix("").parts
            found[".".join((package, *(part for part in parts if part != "__init__")))] = file
    return found


def _statements(node: ast.AST) -> Iterator[ast.Import | ast.ImportFrom]:
    """The imports below a node that are executed at some time."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and ast.unparse(child.test).endswith("TYPE_CHECKING"):
            for other in child.orelse:
                yield from _statements(ast.Module([other], []))
        elif isinstance(child, ast.Import | ast.ImportFrom):
            yield child
        else:
            yield from _statements(child)


def imports(source: str, modules: set[str], module: str = "") -> set[str]:
    """Those of ``modules`` that a source imports; ``module`` is its own name."""
    found = set()
    for statement in _statements(ast.parse(source)):
        if isinstance(statement, ast.Import):
            found |= {alias.name for alias in statement.names}
        elif statement.level:
            raise AssertionError(f"{module}:{statement.lineno}: import by the full name")
        else:
            whole = {f"{statement.module}.{alias.name}" for alias in statement.names}
            found |= whole & modules
            if whole - modules:
                found.add(statement.module)
    return (found & modules) - {module}


def circles(graph: dict[str, set[str]]) -> list[str]:
    """What remains of a graph when all that imports nothing, or is not imported, is taken away."""
    left = {name: set(targets) for name, targets in graph.items()}
    while True:
        wanted = set().union(*left.values()) if left else set()
        ends = {name for name, targets in left.items() if not targets or name not in wanted}
        if not ends:
            return sorted(left)
        left = {name: targets - ends for name, targets in left.items() if name not in ends}


def room(module: str) -> str:
    """The folder, or the module at the top, of 'softact.solve.rungs.base': 'solve'."""
    return [*module.split("."), ""][1]


def order(page: str) -> list[str]:
    """The rooms from below, as the table of CONTRIBUTING.md has them; softact itself is ''."""
    section = page.split("## Where things are")[1].split("\n## ")[0]
    rows = re.findall(r"^\| (`[^|]+`) \|", section, re.MULTILINE)
    names = [name for row in rows for name in re.findall(r"`([\w.]+)/?`", row)]
    return ["" if name == "__init__.py" else name.removesuffix(".py") for name in names]


def upward(graph: dict[str, set[str]], rooms: list[str]) -> set[tuple[str, str]]:
    """The imports from a lower room to a higher one."""
    height = {name: number for number, name in enumerate(rooms)}
    return {
        (module, target)
        for module, targets in graph.items()
        for target in targets
        if height[room(target)] > height[room(module)]
    }


@pytest.fixture(scope="module")
def graph() -> dict[str, set[str]]:
    modules = _modules()
    return {
        name: imports(file.read_text(encoding="utf-8"), set(modules), name)
        for name, file in modules.items()
    }


@pytest.fixture(scope="module")
def rooms() -> list[str]:
    return order((TREE / "CONTRIBUTING.md").read_text(encoding="utf-8"))


def test_every_room_stands_in_the_table_once(graph, rooms):
    assert len(graph) > 200
    assert sorted(rooms) == sorted({room(module) for module in graph})


def test_no_modules_import_each_other_in_a_circle(graph):
    assert circles(graph) == []


def test_imports_go_down(graph, rooms):
    found = upward(graph, rooms)
    assert sorted(found - ALLOWED) == []
    assert sorted(ALLOWED - found) == [], "mended: take it out of ALLOWED"


def test_what_an_import_is():
    modules = {"softact", "softact.a", "softact.a.b", "softact.c", "softact.d"}
    source = """
from typing import TYPE_CHECKING
import numpy
from softact.a import b, name
if TYPE_CHECKING:
    from softact import d
else:
    import softact.c
def function():
    with open("") as file:
        from softact import __version__
"""
    assert imports(source, modules) == {"softact", "softact.a", "softact.a.b", "softact.c"}


def test_a_circle_and_an_import_from_below_are_found():
    graph = {"softact.a.x": {"softact.b.y"}, "softact.b.y": {"softact.c"}, "softact.c": set()}
    assert circles(graph) == []
    assert upward(graph, ["c", "b", "a"]) == set()
    assert upward(graph, ["b", "c", "a"]) == {("softact.b.y", "softact.c")}
    graph["softact.c"] = {"softact.a.x"}
    assert circles(graph) == sorted(graph)

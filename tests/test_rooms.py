"""The order of rooms: no module imports from a higher room, and none in a circle.

The order stands in CONTRIBUTING.md, lowest first. What only types need (``TYPE_CHECKING``) and what
is imported inside a function when it is called does not count: a room may be handed what stands
above it.
"""

import ast
import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parent.parent
PACKAGES = {"softact": TREE / "softact", "softact.geometries": TREE / "geometries"}
PACKAGES["softact.cli"] = TREE / "cli"


def modules() -> dict[str, Path]:
    """Name of each module -> its file."""
    found = {}
    for package, folder in PACKAGES.items():
        for path in folder.rglob("*.py"):
            parts = path.relative_to(folder).with_suffix("").parts
            name = ".".join((package, *parts)).removesuffix(".__init__")
            found[name] = path
    return found


MODULES = modules()


def imported(tree: ast.Module) -> set[str]:
    """Names that a module imports when it is imported itself."""
    names: set[str] = set()

    def look(body: list[ast.stmt]) -> None:
        for node in body:
            if isinstance(node, ast.ImportFrom) and node.module and not node.level:
                names.update(f"{node.module}.{alias.name}" for alias in node.names)
            elif isinstance(node, ast.Import):
                names.update(alias.name for alias in node.names)
            elif isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
                look(node.orelse)
            elif isinstance(node, ast.If | ast.Try | ast.ClassDef | ast.With):
                look(node.body)

    look(tree.body)
    return names


def edges() -> dict[str, set[str]]:
    """Module -> modules of softact that it imports."""
    found = {}
    for name, path in MODULES.items():
        wanted = imported(ast.parse(path.read_text(encoding="utf-8")))
        known = {n if n in MODULES else n.rpartition(".")[0] for n in wanted}
        found[name] = {n for n in known if n in MODULES and n != name}
    return found


def rooms() -> list[list[str]]:
    """Rooms that stand beside each other, lowest first, as CONTRIBUTING.md lists them."""
    page = (TREE / "CONTRIBUTING.md").read_text(encoding="utf-8")
    order = re.search(r"```rooms\n(.*?)```", page, re.S)[1]
    return [line.split() for line in order.splitlines()]


LEVEL = {room: level for level, beside in enumerate(rooms()) for room in beside}


def room_of(module: str) -> str:
    """The most special name in the order that a module belongs to."""
    short = module.removeprefix("softact.")
    while short not in LEVEL and "." in short:
        short = short.rpartition(".")[0]
    return short


def test_every_module_is_in_a_room():
    lost = [name for name in MODULES if room_of(name) not in LEVEL and name != "softact"]
    assert not lost


def test_no_circle_of_imports():
    try:
        TopologicalSorter(edges()).prepare()
    except CycleError as error:
        pytest.fail(" <- ".join(error.args[1]))


def test_no_import_from_a_higher_room():
    wrong = [
        f"{name} ({room_of(name)}) imports {other} ({room_of(other)})"
        for name, others in edges().items()
        for other in others
        if name != "softact" and other != "softact"
        if room_of(name) != room_of(other) and LEVEL[room_of(other)] >= LEVEL[room_of(name)]
    ]
    assert not wrong, "\n".join(sorted(wrong))

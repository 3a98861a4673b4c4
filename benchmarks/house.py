"""What lies between the modules, measured: rooms, circles, imports upwards, types, lines.

    .venv/bin/python -m benchmarks.house

docs/house.md holds the figures. Tests in tests/house use the same functions.
"""

from __future__ import annotations

import ast
import statistics
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

TREE = Path(__file__).parents[1]
FOLDERS = {"softact": "softact", "softact.cli": "cli", "softact.geometries": "geometries"}


def files() -> dict[str, Path]:
    """The modules of softact by their names; a package is its __init__.py."""
    found = {}
    for package, folder in FOLDERS.items():
        for file in sorted((TREE / folder).rglob("*.py")):
            parts = file.relative_to(TREE / folder).with_suffix("").parts
            found[".".join((package, *(part for part in parts if part != "__init__")))] = file
    return found


def room(module: str) -> str:
    """The folder, or the module at the top, of 'softact.solve.rungs.base': 'solve'."""
    return [*module.split("."), ""][1]


def order(page: str) -> list[list[str]]:
    """Rooms that stand beside each other, lowest first, as the list of CONTRIBUTING.md has them."""
    _, found, rest = page.partition("```rooms\n")
    return [line.split() for line in rest.partition("```")[0].splitlines()] if found else []


def rooms() -> list[list[str]]:
    """The order that is written in CONTRIBUTING.md."""
    return order((TREE / "CONTRIBUTING.md").read_text(encoding="utf-8"))


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
    """Those of ``modules`` that a source imports; ``module`` is its own name.

    Imports inside functions count, those under ``TYPE_CHECKING`` do not. That a module's packages
    are imported before it is not counted: they are in its own room.
    """
    found: set[str] = set()
    for statement in _statements(ast.parse(source)):
        if isinstance(statement, ast.Import):
            found |= {alias.name for alias in statement.names}
        elif statement.level or statement.module is None:
            raise ValueError(f"{module}:{statement.lineno}: import by the full name")
        else:
            whole = {f"{statement.module}.{alias.name}" for alias in statement.names}
            found |= whole & modules
            if whole - modules:
                found.add(statement.module)
    return (found & modules) - {module}


def graph() -> dict[str, set[str]]:
    """Each module of softact with those that it imports."""
    modules = files()
    return {
        name: imports(file.read_text(encoding="utf-8"), set(modules), name)
        for name, file in modules.items()
    }


def circles(graph: dict[str, set[str]]) -> list[str]:
    """What remains of a graph when all that imports nothing, or is not imported, is taken away."""
    left = {name: set(targets) for name, targets in graph.items()}
    while True:
        wanted = set().union(*left.values()) if left else set()
        ends = {name for name, targets in left.items() if not targets or name not in wanted}
        if not ends:
            return sorted(left)
        left = {name: targets - ends for name, targets in left.items() if name not in ends}


def upward(graph: dict[str, set[str]], rooms: list[list[str]]) -> set[tuple[str, str]]:
    """The imports from a room to a higher one, or to one beside it. softact itself is free."""
    height = {name: level for level, beside in enumerate(rooms, start=1) for name in beside}
    height[""] = 0
    return {
        (module, target)
        for module, targets in graph.items()
        for target in targets
        if room(module) not in ("", room(target)) and height[room(target)] >= height[room(module)]
    }


def _functions(source: str) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node


def parameters(source: str) -> tuple[int, int]:
    """Parameters without a type, and all; ``self`` and ``cls`` need none."""
    found = []
    for node in _functions(source):
        a = node.args
        some = [*a.posonlyargs, *a.args, *a.kwonlyargs, a.vararg, a.kwarg]
        found += [p for p in some if p is not None and p.arg not in ("self", "cls")]
    return sum(p.annotation is None for p in found), len(found)


def ignored(source: str) -> int:
    """How many lines tell mypy to look away."""
    return source.count("# type: " + "ignore")


def _lengths(source: str) -> list[int]:
    return [(node.end_lineno or node.lineno) - node.lineno + 1 for node in _functions(source)]


def main() -> None:
    """Print the table of docs/house.md."""
    sources = {name: file.read_text(encoding="utf-8") for name, file in files().items()}
    links = graph()
    counts = Counter(room(name) for name in sources)
    untyped, every = (sum(n) for n in zip(*map(parameters, sources.values()), strict=True))
    lines = {name: len(source.splitlines()) for name, source in sources.items()}
    longest = max(lines, key=lambda name: lines[name])
    tops = {file.stem for file in (TREE / "softact").glob("*.py")} | {""}
    tops = {file.stem for file in (TREE / "softact").glob("*.py")} | {""}
    inside = {name: n for name, n in counts.items() if name not in tops}
    rows = {
        "modules": str(len(sources)),
        "modules in no folder": str(len(list((TREE / "softact").glob("*.py")))),
        "modules per folder": ", ".join(f"{name} {n}" for name, n in sorted(inside.items())),
        "modules in circles": str(len(circles(links))),
        "imports from a lower room to a higher one": str(len(upward(links, rooms()))),
        "median length of a function": str(
            statistics.median(n for source in sources.values() for n in _lengths(source))
        ),
        "longest module": f"{lines[longest]} lines ({longest})",
        "parameters without a type": f"{untyped} of {every}",
        "lines that mypy does not look at": str(sum(map(ignored, sources.values()))),
        "lines of Python": str(sum(lines.values())),
    }
    for name, figure in rows.items():
        print(f"| {name} | {figure} |")


if __name__ == "__main__":
    main()

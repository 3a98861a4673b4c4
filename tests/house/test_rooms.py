"""Imports go down: from a room to lower ones, and none in a circle.

The order stands in CONTRIBUTING.md, lowest first. Imports inside functions count, those under
``TYPE_CHECKING`` do not: see ``benchmarks.house.imports``.
"""

import pytest

from benchmarks import house
from benchmarks.house import circles, imports, room, upward


@pytest.fixture(scope="module")
def graph() -> dict[str, set[str]]:
    return house.graph()


def test_every_room_stands_in_the_order_once(graph):
    rooms = [name for beside in house.rooms() for name in beside]
    assert len(graph) > 200
    assert sorted(rooms) == sorted({room(module) for module in graph} - {""})


def test_no_modules_import_each_other_in_a_circle(graph):
    assert circles(graph) == []


def test_imports_go_down(graph):
    assert sorted(upward(graph, house.rooms())) == []


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
    assert upward(graph, [["c"], ["b"], ["a"]]) == set()
    assert upward(graph, [["b"], ["c"], ["a"]]) == {("softact.b.y", "softact.c")}
    assert upward(graph, [["c", "b"], ["a"]]) == {("softact.b.y", "softact.c")}
    graph["softact.c"] = {"softact.a.x"}
    assert circles(graph) == sorted(graph)

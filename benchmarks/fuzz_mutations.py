"""Texts, trees and files that are nearly right, and made wrong in one place or a few."""

from __future__ import annotations

import random
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import yaml

from benchmarks.damaging import ANY, KINDS, line_lost

#: Where somebody would write a text, a number, a quantity, a path or a name.
ODD_TEXTS = (
    "", " ", "-", "--", "-1", "0", "1", "1e308", "1e400", "nan", "inf", "1_000", "0x10", "٣", "½",
    "1 mm", "-1 mm", "0 mm", "1e30 mm", "1e-30 mm", "1 kPa", "1 mm^2", "1 furlong", "1 kg/cm^2",
    "5 %", "20 degC", "1 mm mm", "1 mm/0", "mm", "(", "1 mm..2 mm", "2 kPa..1 kPa", "..", ".", "=",
    "a=", "=b", "a=b", "a.b.c=1", "x" * 300, "ä", "☃", "e\u0301", "\u202e", "a\nb", "a\tb",
    "\x1b[1m", "\udcff", "*", "?", "[", "${HOME}", "%s", "{}", "'", '"', "<b>", "`id`", "null",
    "true", "../x", "yes", "2026-01-01", "cube", "cube/run.json", "spec.yaml", "missing.yaml",
    "results/a/b", "..",
)  # fmt: skip
ODD_VALUES = (
    None, True, False, -1, 0, 1, 3, 1e308, -1e308, 10**30, float("nan"), float("inf"), 1e-320,
    [], {}, [[]], [None], [{}], {"a": 1}, {1: 2}, {None: None}, [1, [2, [3, [4]]]], ["x"] * 50,
)  # fmt: skip
_UNITS = (
    "",
    "mm",
    "m",
    "um",
    "kPa",
    "MPa",
    "GPa",
    "bar",
    "N",
    "mL",
    "deg",
    "kg",
    "mm^4",
    "furlong",
)


def odd(draw: random.Random) -> Any:
    """A value of any kind that seldom fits."""
    if draw.random() < 0.6:
        return draw.choice(ODD_TEXTS)
    return deepcopy(draw.choice(ODD_VALUES))


def _places(tree: Any) -> list[tuple[Any, Any]]:
    """Every (container, key) in a tree."""
    keys = list(tree) if isinstance(tree, dict) else range(len(tree))
    found = []
    for key in keys:
        found.append((tree, key))
        if isinstance(tree[key], dict | list):
            found += _places(tree[key])
    return found


def _quantity(value: Any, draw: random.Random, mild: bool = False) -> Any:
    """Another number or another unit; a mild change keeps what is no number, and the unit."""
    number, _, unit = str(value).partition(" ")
    try:
        size = float(number)
    except ValueError:
        return value if mild else odd(draw)
    if mild:
        size *= draw.choice((-1, 0, 0.3, 0.9, 1.1, 2, 3, 10))
        return f"{size:g} {unit}".strip() if isinstance(value, str) else type(value)(size)
    if draw.random() < 0.4:
        return f"{number} {draw.choice(_UNITS)}".strip()
    size *= draw.choice((-1, 0, 0.5, 2, 10, 1e-3, 1e3, 1e-9, 1e9, 1e200))
    return f"{size:g} {unit}".strip() if isinstance(value, str) else size


def _change(tree: Any, draw: random.Random, mild: bool) -> None:
    at, key = draw.choice(_places(tree))
    if mild:
        if not isinstance(at[key], dict | list | bool):
            at[key] = _quantity(at[key], draw, mild)
        return
    how = draw.choice(("lost", "odd", "odd", "quantity", "quantity", "named", "nested", "moved"))
    if how == "lost":
        del at[key]
    elif how == "named" and isinstance(at, dict):
        at[draw.choice((odd, lambda d: f"{key}x", lambda d: str(key).upper()))(draw)] = at.pop(key)
    elif how == "nested":
        at[key] = draw.choice(([at[key]], {"a": at[key]}, [at[key], deepcopy(at[key])]))
    elif how == "moved":
        other, place = draw.choice(_places(tree))
        at[key] = yaml.safe_load(yaml.safe_dump(other[place]))
    elif how == "quantity" and not isinstance(at[key], dict | list):
        at[key] = _quantity(at[key], draw)
    else:
        at[key] = odd(draw)


def changed(text: str, times: int, draw: random.Random) -> bytes:
    """A YAML file with so many of its keys, values or bytes changed."""
    if times and draw.random() < 0.15:
        raw = bytearray(text.encode())
        return bytes(draw.choice((*ANY, line_lost))(raw, draw))
    tree, mild = yaml.safe_load(text), draw.random() < 0.4
    for _ in range(4 * times if mild else times):
        if not tree:
            break
        try:
            _change(tree, draw, mild)
        except TypeError:  # an odd value that is no key
            continue
    try:
        return yaml.safe_dump(tree, sort_keys=False, allow_unicode=True).encode(
            "utf-8", "surrogateescape"
        )
    except (yaml.YAMLError, UnicodeEncodeError):
        return repr(tree).encode("utf-8", "backslashreplace")


def paths_of(text: str) -> list[str]:
    """The dotted paths of a YAML file, as --set takes them."""
    found: list[str] = []

    def walk(tree: Any, before: str) -> None:
        pairs = tree.items() if isinstance(tree, dict) else enumerate(tree)
        for key, value in pairs:
            found.append(f"{before}{key}")
            if isinstance(value, dict | list):
                walk(value, f"{found[-1]}.")

    walk(yaml.safe_load(text), "")
    return found


def _kinds(path: Path) -> tuple[Callable, ...]:
    like = {".json": "run.json", ".csv": "curve.csv", ".yaml": "spec.yaml"}
    return KINDS.get(path.name) or KINDS.get(like.get(path.suffix, ""), ANY)


def damage(folder: Path, draw: random.Random) -> str:
    """Damage one file anywhere in a folder; returns its name and how."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    if not files:
        return "nothing there"
    path = draw.choice(files)
    name = str(path.relative_to(folder))
    if draw.random() < 0.15:
        path.unlink()
        if draw.random() < 0.3:
            path.mkdir()
            return f"{name}: a folder"
        return f"{name}: lost"
    if draw.random() < 0.1:
        path.write_bytes(draw.choice(files).read_bytes() if path.exists() else b"")
        return f"{name}: another file"
    kind = draw.choice(_kinds(path))
    raw = path.read_bytes()
    try:
        path.write_bytes(kind(bytearray(raw), draw))
    except (ValueError, IndexError, KeyError, TypeError):  # damaged before, or empty
        path.write_bytes(b"\xff" + raw)
    return f"{name}: {kind.__name__}"

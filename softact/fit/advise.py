"""The command that reads a table which softact could not read, or not without more."""

import re
import shlex
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from softact.fit.choose import DEFORMATIONS, LOADS, TRAVEL
from softact.fit.sheet import TestSheet
from softact.fit.trimming import turning_points
from softact.measured.headings import QUANTITIES, Column, Quantity, read_heading
from softact.measured.spelling import is_time, registry_unit
from softact.units import LENGTH, PRESSURE

_OPTIONS = {"stress": "stress", "cycle": "cycle", "stretch_from": "from", "stretch_to": "to",
            "smooth": "smooth", "points": "points"}  # fmt: skip
_USUAL = {"displacement": "mm", "position": "mm", "length": "mm", "force": "N"}
_OPEN = ("stress", "standard_stress")  # the name does not say which stress
UNKNOWN = "?"  # stands for a size that only the user knows


def advice(
    sheet: TestSheet,
    columns: Sequence[Column],
    values: np.ndarray | None,
    known: Mapping[str, float],
    renamed: Mapping[int, str] | None = None,
) -> str:
    """Return '; read it with: softact fit ...' for the end of a refusal.

    values: numbers of the columns, for guessing what those without a name may be. known: sizes that
    the file states. renamed: headings that are better than those that were understood.
    """
    if not columns or values is None or not len(values):
        return ""
    names, guessed = _names(columns, values, sheet, renamed or {})
    while len(names) > 1 and names[-1] == "-":
        names.pop()
    options = _needed(sheet, names, known, values)
    words = ["--columns", ", ".join(names), *_given(sheet, options)]
    command = shlex.join(["softact", "fit", _file(sheet), *words])
    said = ""
    if guessed:
        said = ", with what the columns hold in place of the names"
    if any(UNKNOWN in option for option in options):
        said += f", with the specimen's sizes in place of {UNKNOWN}"
    return f"; read it with: {command}{said}"


def _mode(sheet: TestSheet) -> str:
    return sheet.named_mode or sheet.mode


def _file(sheet: TestSheet) -> str:
    said = "mode" in sheet.model_fields_set or sheet.direction or sheet.named_mode
    mode = f":{_mode(sheet)}" if said else ""
    return f"{sheet.file}{mode}{f'@{sheet.direction}' if sheet.direction else ''}"


def _names(
    columns: Sequence[Column],
    values: np.ndarray,
    sheet: TestSheet,
    renamed: Mapping[int, str],
) -> tuple[list[str], bool]:
    """A heading for each column, '-' for those that are not read, and whether any is a guess."""
    names, guessed = ["-"] * len(columns), False
    taken: dict[str, int] = {}  # role -> place
    directed = any(c.direction and c.quantity.role for c in columns)
    for i, column in enumerate(columns):
        if column.quantity.role and directed:
            names[i] = _written(column, sheet)
    for role, order in (("x", DEFORMATIONS), ("y", LOADS)):
        if directed:
            break
        known = [i for i, c in enumerate(columns) if c.quantity.role == role and _holds(values, i)]
        known.sort(key=lambda i: (bool(columns[i].fault), order.index(columns[i].quantity.name)))
        place = next((i for i in renamed if i in known), known[0] if known else None)
        if place is None:
            place = _guess(columns, values, role, taken.values())
            guessed = True
        if place is not None:
            taken[role] = place
            names[place] = (
                _written(columns[place], sheet)
                if columns[place].quantity.role
                else _suggested(columns[place], role, values[:, place])
            )
    for i, name in renamed.items():
        names[i] = name
    for i, column in enumerate(columns):
        if column.quantity.name == "specimen":
            names[i] = "specimen"
    return names, guessed


def _holds(values: np.ndarray, i: int) -> bool:
    return bool(np.isfinite(values[:, i]).any())


def _guess(
    columns: Sequence[Column], values: np.ndarray, role: str, taken: Collection[int]
) -> int | None:
    """A column of numbers that move and of unknown name, for a deformation one that goes one way.

    Lengths come first for a deformation. Where there are columns enough, even steps are the time.
    """
    moving = []
    for i, column in enumerate(columns):
        numbers = values[:, i][np.isfinite(values[:, i])]
        if i not in taken and column.quantity is QUANTITIES[0] and len(numbers) > 1:
            if np.ptp(numbers) > 0 and not is_time(_unit_of(column)):
                moving.append((i, numbers))
    wanted = 2 if role == "x" and not taken else 1
    steps = np.diff(moving[0][1]) if len(moving) > wanted else np.zeros(0)
    if len(steps) and np.ptp(steps) <= 1e-6 * np.max(np.abs(steps)):
        moving = moving[1:]
    if role == "x":
        moving = [(i, numbers) for i, numbers in moving if len(turning_points(numbers)) <= 3]
        moving.sort(key=lambda entry: registry_unit(_unit_of(columns[entry[0]]), LENGTH) is None)
    return moving[0][0] if moving else None


def _unit_of(column: Column) -> str:
    """What stands where a heading has its unit."""
    inside = re.findall(r"[(\[]([^()\[\]]*)[)\]]", column.heading)
    words = re.split(r"[\s_/]", column.heading)
    return inside[-1] if inside else words[-1] if len(words) > 1 else ""


def _written(column: Column, sheet: TestSheet) -> str:
    """The heading of a column with a role as it is read without a question."""
    name = column.quantity.name
    unit = _USUAL.get(name, "MPa" if column.quantity.role == "y" else "")
    written = f"{column.written} {unit}".strip() if column.fault is not None else column.written
    return written.replace("nominal", sheet.stress) if name in _OPEN and sheet.stress else written


def _suggested(column: Column, role: str, numbers: np.ndarray) -> str:
    """A heading for a column of unknown quantity, from its unit and its numbers."""
    unit = _unit_of(column)
    if role == "y":
        return f"nominal_stress {registry_unit(unit, PRESSURE) or 'MPa'}"
    if length := registry_unit(unit, LENGTH):
        return f"displacement {length}"
    finite = numbers[np.isfinite(numbers)]
    if abs(finite[0] - 1.0) < 0.1 and np.max(finite) < 25:
        return "stretch"
    return "strain %" if np.max(np.abs(finite)) > 25 or "%" in column.heading else "strain"


def _needed(
    sheet: TestSheet, names: Sequence[str], known: Mapping[str, float], values: np.ndarray
) -> list[str]:
    """Options without which columns of these names cannot be read."""
    meant = [read_heading(name).quantity for name in names]
    kinds = {quantity.name for quantity in meant}
    options = []
    if kinds & set(TRAVEL) and not (sheet.length or known.get("length")):
        options += ["--length", f"{UNKNOWN} mm"]
    if "force" in kinds and not (sheet.cross_section or known.get("area")):
        if _mode(sheet) == "compression" and not (sheet.width or sheet.thickness):
            return [*options, "--area", f"{UNKNOWN} mm^2", *_branch(sheet, meant, values)]
        for size in ("width", "thickness"):
            if not (getattr(sheet, size) or known.get(size)):
                options += [f"--{size}", f"{UNKNOWN} mm"]
    return options + _branch(sheet, meant, values)


def _branch(sheet: TestSheet, meant: Sequence[Quantity], values: np.ndarray) -> list[str]:
    """--loading where the deformation turns back."""
    place = next((i for i, quantity in enumerate(meant) if quantity.role == "x"), None)
    if place is None or sheet.loading or sheet.cycle:
        return []
    numbers = values[:, place][np.isfinite(values[:, place])]
    return ["--loading"] if len(numbers) > 2 and len(turning_points(numbers)) > 2 else []


def _given(sheet: TestSheet, needed: list[str]) -> list[str]:
    """The options that were given, and those that are needed."""
    words = []
    for name in ("length", "width", "thickness"):
        if (size := getattr(sheet, name)) is not None:
            words += [f"--{name}", f"{size:g} mm"]
    if sheet.area is not None:
        words += ["--area", f"{sheet.area:g} mm^2"]
    if sheet.toe is not None:
        words += ["--toe", f"{sheet.toe:g} MPa"]
    for name, option in _OPTIONS.items():
        if (given := getattr(sheet, name)) is not None:
            words += [f"--{option}", f"{given:g}" if isinstance(given, float) else str(given)]
    words += [f"--{name}" for name in ("zero", "loading", "whole") if getattr(sheet, name)]
    return [*words, *needed]

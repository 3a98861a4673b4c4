"""`softact list`: what a spec may name, with parameters, units and defaults."""

import json
import sys
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rich.table import Table

KINDS = ("laws", "materials", "geometries", "measures", "loads")
PARAMETERS = "parameters"
PLAIN_WIDTH = 120


class Pasted(str):
    """A line that is pasted into a spec, and stays one line however long it is."""

    __slots__ = ()


@click.command(
    name="list",
    short_help="List laws, materials, geometries, measures, loads, parameters.",
)
@click.argument(
    "kind", type=click.Choice((*KINDS, PARAMETERS)), metavar="|".join((*KINDS, PARAMETERS))
)
@click.argument("names", nargs=-1, metavar="[NAME|SPEC]...")
@click.option("--json", "as_json", is_flag=True, help="Print JSON for a program to read.")
def list_kind(kind: str, names: tuple[str, ...], as_json: bool) -> None:
    """List what a spec may name, with parameters, units and defaults.

    Names after the kind show only these. After parameters a spec is wanted: the numbers in it by
    which softact run --sensitivities differentiates.

    \b
    Examples:
      softact list materials
      softact list geometries pneunet
      softact list parameters finger.yaml
    """
    if kind == PARAMETERS:
        _list_parameters(names, as_json)
        return
    from softact.catalogue import KINDS as CATALOGUE

    records = _chosen(CATALOGUE[kind](), kind, names)
    if as_json:
        click.echo(json.dumps(records, indent=2, ensure_ascii=False))
        return
    from rich.console import Console

    console = Console(width=None if sys.stdout.isatty() else PLAIN_WIDTH, highlight=False)
    for block in _blocks(kind, records):
        if isinstance(block, str):
            console.print(block, markup=False, soft_wrap=isinstance(block, Pasted))
        else:
            console.print(block)


def _list_parameters(specs: tuple[str, ...], as_json: bool) -> None:
    """Print the numbers of a spec by which its measures can be differentiated."""
    from softact.errors import SpecError
    from softact.sensitivities.parameters import parameters
    from softact.spec import load

    if len(specs) != 1:
        raise SpecError("list parameters: name one spec, such as finger.yaml")
    found = parameters(load(specs[0]))
    if as_json:
        records = [
            {"name": p.path, "value": p.told, "unit": p.unit, "usual": p.usual} for p in found
        ]
        click.echo(json.dumps(records, indent=2, ensure_ascii=False))
        return
    from rich.console import Console

    table = _table("parameter", "value", "unit", "without -p")
    for p in found:
        table.add_row(p.path, f"{p.told:.10g}", p.unit, "yes" if p.usual else "left out")
    console = Console(width=None if sys.stdout.isatty() else PLAIN_WIDTH, highlight=False)
    console.print(table)


def _chosen(
    records: list[dict[str, Any]], kind: str, names: tuple[str, ...]
) -> list[dict[str, Any]]:
    from softact.errors import SpecError
    from softact.nearest import nearest

    known = [record["name"] for record in records]
    unknown = [name for name in names if name not in known]
    if unknown:
        raise SpecError(*(f"{kind}: there is no '{n}'; {nearest(n, known)}" for n in unknown))
    return [record for record in records if not names or record["name"] in names]


def _blocks(kind: str, records: list[dict[str, Any]]) -> "list[str | Table]":
    if kind == "materials":
        return [_materials(records)]
    if kind == "measures":
        return [_measures(records)]
    if kind == "loads":
        return [_loads(records), *(b for r in records if r["parameters"] for b in _record(r))]
    blocks = [block for record in records for block in _record(record)]
    if kind == "laws":
        from softact.catalogue import shared_constants

        blocks += ["every law takes these too", _parameters(shared_constants())]
    return blocks


def _record(record: dict[str, Any]) -> "list[str | Table]":
    """A heading, what is to be known, and the table of the parameters."""
    blocks: list[str | Table] = [record["name"]]
    for key in ("formula", "use", "source"):
        if text := record.get(key):
            blocks.append(f"  {text}" if key != "source" else f"  Source: {text}")
    blocks += _names(record, "  ")
    for other in record.get("others", ()):
        blocks += [f"  with {other['with']} also", *_names(other, "    ")]
    if record.get("example"):
        blocks.append(Pasted(f"  What its sheets are made of: {record['example']}"))
    return [*blocks, _parameters(record["parameters"])]


def _names(record: dict[str, Any], indent: str) -> list[str]:
    from softact.catalogue import NAMES

    return [f"{indent}{key}: {', '.join(record[key])}" for key in NAMES if record.get(key)]


def _table(*titles: str) -> "Table":
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=True, header_style="bold")
    for number, title in enumerate(titles):
        table.add_column(title, overflow="fold", no_wrap=number == 0)
    return table


def _parameters(entries: list[dict[str, Any]]) -> "Table":
    table = _table("key", "value", "unit", "default", "meaning")
    for entry in entries:
        default = "needed" if entry["needed"] else _text(entry["default"])
        table.add_row(entry["name"], entry["value"], entry["unit"], default, entry["meaning"])
    return table


def _materials(records: list[dict[str, Any]]) -> "Table":
    table = _table("card", "law", "constants", "density", "strength", "elongation", "source")
    for record in records:
        constants = ", ".join(f"{key} {value}" for key, value in record["constants"].items())
        record = {**record, "strength": _strength(record)}
        rest = (_text(record[key]) for key in ("density", "strength", "elongation", "source"))
        table.add_row(record["name"], record["law"], constants, *rest)
    return table


def _strength(record: dict[str, Any]) -> str | None:
    """A card's strength and by which area it is."""
    return f"{record['strength']} ({record['strength_is']})" if record["strength"] else None


def _loads(records: list[dict[str, Any]]) -> "Table":
    table = _table("key of a step", "value", "unit", "meaning")
    for record in records:
        keys = ("name", "value", "unit", "meaning")
        table.add_row(*(_text(record[key]) for key in keys))
    return table


def _measures(records: list[dict[str, Any]]) -> "Table":
    table = _table("measure", "column of curve.csv", "meaning")
    for record in records:
        table.add_row(record["name"], "", record["use"])
        for column, meaning in record["columns"].items():
            table.add_row("", column, meaning)
    return table


def _text(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)

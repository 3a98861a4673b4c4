"""The spec: a YAML file as frozen models in internal units, every fault told at once."""

import re
from collections.abc import Sequence
from pathlib import Path

from pydantic import ValidationError

from softact.errors import SpecError
from softact.spec import card_files, document, overrides
from softact.spec.faults import fault_lines
from softact.spec.models import Layer, Payload, Solver, Spec, Step, Support, Traction
from softact.spec.schema import json_schema

__all__ = [
    "Layer",
    "Payload",
    "Solver",
    "Spec",
    "Step",
    "Support",
    "Traction",
    "json_schema",
    "load",
    "loads",
    "opened",
    "spec_of",
]


def load(path: str | Path, overrides: Sequence[str] = ()) -> Spec:
    """Read the spec in a YAML file; ``overrides`` are ``path=value`` and win over the file.

    Raises SpecError with one line per fault, ``file:line: path: what is wrong; what is right``.
    """
    return spec_of(opened(path, overrides))


def opened(path: str | Path, overrides: Sequence[str] = ()) -> document.Document:
    """Read a YAML file as ``load`` does, but not yet as a spec: plain data and its lines."""
    return _filled(document.read(Path(path)), overrides, Path(path).parent)


def loads(text: str, name: str = "spec", overrides: Sequence[str] = ()) -> Spec:
    """Return the spec in YAML text; ``name`` stands for the file in messages. See ``load``.

    Files that it names count from the working folder.
    """
    return spec_of(_filled(document.parse(text, name), overrides, Path()))


def _filled(source: document.Document, changes: Sequence[str], folder: Path) -> document.Document:
    overrides.apply(source, list(changes))
    card_files.insert(source, folder)
    source.data.setdefault("name", _name(source.name))
    _find_file(source)
    return source


def spec_of(source: document.Document) -> Spec:
    """The spec that plain data mean. Raises SpecError with one line per fault."""
    try:
        return Spec.model_validate(source.data)
    except ValidationError as error:
        raise SpecError(*fault_lines(error, source, Spec)) from None


def _find_file(source: document.Document) -> None:
    """Make the path of a geometry's file, which counts from the spec's folder, an absolute one."""
    geometry = source.data.get("geometry")
    if isinstance(geometry, dict) and isinstance(geometry.get("file"), str):
        folder = Path(source.name).absolute().parent
        geometry["file"] = str((folder / geometry["file"]).resolve())


def _name(file: str) -> str:
    return re.sub(r"[^a-z0-9_-]+", "_", Path(file).stem.lower()).strip("_-")[:64] or "actuator"

"""Files of the user's that a spec runs as code: said before they run."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

DATA = (".msh",)  # what ``from_script`` takes beside code


def scripts_as_code(spec: Any, other_files: Iterable[Any] = ()) -> list[str]:
    """A line for each script that runs where the plain data of a spec, as it stands in a file, are
    run. other_files: that take the place of the spec's, as an axis of a sweep does."""
    geometry = spec.get("geometry") if isinstance(spec, dict) else None
    if not isinstance(geometry, dict) or geometry.get("type") != "from_script":
        return []
    files = dict.fromkeys(f for f in (geometry.get("file"), *other_files) if isinstance(f, str))
    return [as_code(file) for file in files if not file.lower().endswith(DATA)]


def as_code(file: Any) -> str:
    """The line about a script."""
    return f"runs the script {file} as code"

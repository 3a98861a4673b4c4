"""A preview as a page, a picture or a mesh file."""

from __future__ import annotations

from pathlib import Path

from softact.errors import SpecError
from softact.files.text import write_atomic
from softact.mesh.abaqus import inp_text
from softact.preview import page, picture
from softact.preview.look import Preview

SUFFIXES = (".html", ".png", ".inp")


def write(preview: Preview, path: Path) -> None:
    """Write what the suffix asks for. Raises SpecError for another, and DrawingError where the
    picture cannot be drawn."""
    match path.suffix.lower():
        case ".html":
            write_atomic(path, page.html(preview))
        case ".png":
            write_atomic(path, picture.png(preview))
        case ".inp":
            if preview.mesh is None or preview.layout is None:
                raise SpecError(f"{path}: only the mesh of a solid is written as .inp")
            write_atomic(path, inp_text(preview.mesh, preview.layout))
        case _:
            raise SpecError(f"{path}: write one of {', '.join(SUFFIXES)}")

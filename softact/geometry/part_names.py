"""Names that users give to parts of their own geometries: what all files of softact can hold."""

from typing import Annotated

from pydantic import AfterValidator
from pydantic_core import PydanticCustomError

from softact.units import show

LONGEST = 100
#: '/' parts the groups of HDF5, quotes and '\' end the names of gmsh, '<' those of columns.
_FORBIDDEN = "/\\\"'`<>"


def name_fault(name: str) -> str | None:
    """Return what is wrong with the name of a solid, surface or cavity, None where nothing is."""
    signs = sorted({c for c in name if c in _FORBIDDEN})
    if not name.strip():
        why = "is empty"
    elif signs:
        why = f"holds {' '.join(signs)}"
    elif not name.isprintable():
        why = "holds a line break or another character that cannot be printed"
    elif name != name.strip():
        why = "begins or ends with a blank"
    elif name in (".", ".."):
        why = "means a folder"
    elif len(name) > LONGEST:
        why = f"is longer than {LONGEST} characters"
    else:
        return None
    return f"the name {show(name)} {why}; rename it, there and here, for example to 'wall_1'"


def _checked(name: str) -> str:
    if fault := name_fault(name):
        raise PydanticCustomError("part_name", "{fault}", {"fault": fault})
    return name


def _checked_or_empty(name: str) -> str:
    return _checked(name) if name else name


PartName = Annotated[str, AfterValidator(_checked)]
PartNameOrNone = Annotated[str, AfterValidator(_checked_or_empty)]

"""Which families of actuators have a first spec, and what each does."""

from functools import cache
from importlib.resources import files
from typing import Annotated

import yaml
from pydantic import BaseModel, ConfigDict, Field

from softact.errors import SpecError
from softact.geometries import GEOMETRIES
from softact.nearest import nearest
from softact.units import Length, Pressure

_MARK = "---\n"
#: What an actuator may do: in words, and the family that does it most simply.
MOTIONS = {
    "bend": ("curl to one side, as a finger or a tentacle", "pneunet"),
    "stretch": ("grow longer", "bellows"),
    "contract": ("grow shorter and pull, as a muscle", "braided_muscle"),
    "twist": ("turn its tip about its axis", "braided_muscle"),
    "grip": ("close on an object", "pneunet"),
    "press": ("straighten a joint and press on it", "woven_stiffening"),
    "inflate": ("grow wider", "thick_sphere"),
    "own": ("something else: a part of your own", "from_step"),
    "test": ("nothing: a bar of a material is pulled", "block"),
}


class Family(BaseModel):
    """A family of actuators. Lengths in mm, MPa.

    name: of its geometry. template: of the spec, "" where its geometry's defaults are written.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    name: str
    template: str
    about: str = Field(description="what it is, in a line")
    does: Annotated[tuple[str, ...], Field(strict=False)] = Field(
        description="of ``MOTIONS``, the usual one first"
    )
    length: Length = Field(description="usual length along x")
    width: Length = Field(description="usual width or diameter")
    material: str | dict[str, str] = Field(description="card, or a law as a spec writes it")
    pressure: Pressure = Field(description="for this size and material")


@cache
def families() -> dict[str, Family]:
    """Every family by its name, in the order of the geometries."""
    return {name: _read(name) for name in GEOMETRIES}


def family(name: str) -> Family:
    """The family of a geometry. Raises SpecError for an unknown one."""
    if name not in families():
        raise SpecError(
            f"there is no family '{name}'; {nearest(name, families())} "
            "(softact list geometries shows them)"
        )
    return families()[name]


def for_motion(does: str) -> list[Family]:
    """The families that do something, the simplest first. Raises SpecError for an unknown word."""
    if does not in MOTIONS:
        raise SpecError(f"no actuator is known to '{does}'; {nearest(does, MOTIONS)}")
    able = [entry for entry in families().values() if does in entry.does]
    return sorted(able, key=lambda entry: entry.name != MOTIONS[does][1])


def _read(name: str) -> Family:
    path = files("softact") / "starter" / "specs" / f"{name}.yaml"
    if not path.is_file():
        return _of_defaults(name)
    head, _, template = path.read_text(encoding="utf-8").partition(_MARK)
    return Family.model_validate({"name": name, "template": template, **yaml.safe_load(head)})


def _of_defaults(name: str) -> Family:
    about = " ".join((GEOMETRIES[name].__doc__ or "").split("\n\n")[0].split())
    return Family.model_validate({
        "name": name, "template": "", "about": about, "does": ("own",), "length": "100 mm",
        "width": "20 mm", "material": "dragon-skin-30", "pressure": "10 kPa",
    })  # fmt: skip

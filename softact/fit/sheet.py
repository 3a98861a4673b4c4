"""What the user says about a test: file, mode, columns, specimen, what to trim."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, get_args

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    WithJsonSchema,
    model_validator,
)

from softact.errors import SpecError
from softact.fields import NAMES_SCHEMA
from softact.files.document import dotted
from softact.spec.faults import validated
from softact.spec.kinds import read_as
from softact.units import Dimension, Dimensionless, Length, Pressure

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

AREA = Dimension("area", "mm^2", shown=("mm^2",), other=("cm^2", "m^2"), example="18 mm^2")
# What a file's name says of the mode of its test, where nobody says it.
_NAMED = (
    ("compression", re.compile(r"compress|druck|squish")),
    ("planar", re.compile(r"planar|shear")),
    ("equibiaxial", re.compile(r"equi|biax")),
)
_AREA_SCHEMA = {"type": "string", "description": f"area with unit, such as '{AREA.example}'"}
Area = Annotated[float, BeforeValidator(AREA.parse), WithJsonSchema(_AREA_SCHEMA)]
ModeName = Literal["uniaxial", "compression", "equibiaxial", "planar", "biaxial"]
MODE_NAMES: tuple[str, ...] = get_args(ModeName)


def _headings(value: object) -> object:
    if isinstance(value, str):
        return tuple(part.strip() for part in value.split(","))
    if value is not None and not isinstance(value, list | tuple):
        raise ValueError("write the headings as a list, such as [stretch, nominal_stress MPa]")
    return value


def _cycle(value: object) -> int | str | None:
    if value is None:
        return None
    text = str(value)
    if text == "last":
        return text
    if isinstance(value, bool) or not text.isdigit() or int(text) < 1:
        raise ValueError(f"'{text}' is no cycle; write 1, 2, ... or last")
    return int(text)


class TestSheet(BaseModel):
    """One file of test data and how to read it.

    Lengths in mm, pressures in MPa inside; every dimensional value is written with its unit.
    """

    __test__ = False  # not a test of pytest's
    model_config = ConfigDict(frozen=True, extra="forbid")

    file: Path
    mode: ModeName = "uniaxial"
    direction: Literal["course", "wale"] | None = Field(
        default=None, description="of the load in a sheet with fibres; course is the fibre axis"
    )
    specimen: str | None = Field(default=None, description="name; default: the file's stem")
    columns: Annotated[
        tuple[str, ...] | None, BeforeValidator(_headings), WithJsonSchema(NAMES_SCHEMA)
    ] = Field(
        default=None, description="headings in order, where the file has none; '-' skips a column"
    )
    stress: Literal["nominal", "cauchy"] | None = Field(
        default=None, description="what a column headed only 'stress' holds"
    )
    length: Length | None = Field(default=None, gt=0, description="gauge length, undeformed")
    width: Length | None = Field(default=None, gt=0)
    thickness: Length | None = Field(default=None, gt=0)
    area: Area | None = Field(default=None, gt=0, description="cross-section, undeformed")
    zero: bool = Field(default=False, description="subtract the load of the first point used")
    loading: bool = Field(default=False, description="keep the first loading only")
    cycle: Annotated[int | str | None, BeforeValidator(_cycle)] = Field(
        default=None, description="keep the loading of this cycle (1, 2, ... or last)"
    )
    toe: Pressure | None = Field(
        default=None, gt=0, description="drop points below this stress and shift the zero of strain"
    )
    stretch_from: Dimensionless | None = Field(default=None, gt=0)
    stretch_to: Dimensionless | None = Field(default=None, gt=0)
    whole: bool = Field(default=False, description="keep the break and a hold at the end")
    broke: bool = Field(
        default=False,
        description="the specimen broke where its test ends: strength and elongation of the card",
    )
    smooth: int | None = Field(
        default=None, ge=5, description="Savitzky-Golay window in points, second order"
    )
    points: int | None = Field(default=None, ge=5, description="thin to so many points")

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.area and (self.width or self.thickness):
            raise ValueError("area and width/thickness both give the cross-section; give one")
        if self.loading and self.cycle is not None:
            raise ValueError("loading and cycle both choose a branch; give one")
        return self

    @property
    def cross_section(self) -> float | None:
        """Undeformed cross-section in mm², None where the user gives none."""
        if self.area:
            return self.area
        return self.width * self.thickness if self.width and self.thickness else None

    @property
    def named_mode(self) -> str | None:
        """The mode that the file's name speaks of, where none is given; None where it does not."""
        if "mode" in self.model_fields_set:
            return None
        name = self.file.stem.lower()
        return next((mode for mode, words in _NAMED if words.search(name)), None)

    @property
    def name(self) -> str:
        """The specimen's name."""
        return self.specimen or self.file.stem


class TestList(BaseModel):
    """A file that lists tests which are read differently."""

    __test__ = False
    model_config = ConfigDict(frozen=True, extra="forbid")

    tests: tuple[TestSheet, ...] = Field(
        min_length=1, description="a list of mappings, one for each file of test data"
    )


def make_sheet(data: Mapping[str, Any], where: str) -> TestSheet:
    """Return a sheet; raises SpecError with one line per fault, each starting with ``where``."""
    try:
        return TestSheet(**data)
    except ValidationError as error:
        raise SpecError(*(_line(where, fault) for fault in error.errors())) from None


def _line(where: str, fault: "ErrorDetails") -> str:
    path = ".".join(str(part) for part in fault["loc"])
    if fault["type"] == "extra_forbidden":
        return f"{where}: unknown key '{path}'"
    message = fault["msg"].removeprefix("Value error, ")
    return f"{where}: {path}: {message}" if path else f"{where}: {message}"


def sheets_from_argument(argument: str, options: Mapping[str, Any]) -> list[TestSheet]:
    """Return the sheets of one command line argument: FILE, FILE:MODE, FILE:MODE@DIRECTION or YAML.

    options: fields of ``TestSheet`` from the command line. A YAML file holds ``tests:``, a list of
    sheets whose files count from its folder; the options fill what it leaves open. Raises SpecError
    with one line per fault.
    """
    if argument.endswith((".yaml", ".yml")):
        return _sheets_from_yaml(Path(argument), options)
    name, _, mode = argument.rpartition(":")
    if not name or mode.split("@")[0] not in MODE_NAMES:
        if name and mode and not Path(argument).exists():
            raise SpecError(f"{argument}: '{mode}' is no mode; one of {', '.join(MODE_NAMES)}")
        name, mode = argument, ""
    data = {**options, "file": name}
    if mode:
        data["mode"], _, direction = mode.partition("@")
        if direction:
            data["direction"] = direction
    return [make_sheet(data, argument)]


def _sheets_from_yaml(path: Path, options: Mapping[str, Any]) -> list[TestSheet]:
    source = read_as(path, "tests")
    tests = source.data.get("tests")
    for test in tests if isinstance(tests, list) else ():
        if not isinstance(test, dict):
            continue
        for key, value in options.items():
            test.setdefault(key, value)
        if isinstance(test.get("file"), str):
            test["file"] = str(path.parent / test["file"])
    sheets = list(validated(source, TestList).tests)
    places = [("tests", number, "file") for number in range(len(sheets))]
    missing = [
        f"{source.where(place)}: {dotted(place)}: {sheet.file}: there is no such file"
        for place, sheet in zip(places, sheets, strict=True)
        if not sheet.file.exists()
    ]
    if missing:
        raise SpecError(*missing)
    return sheets

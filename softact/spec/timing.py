"""How loads go with time, as a step of a spec says it."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, Field, GetJsonSchemaHandler, field_validator, model_validator
from pydantic_core import CoreSchema

from softact.contact.obstacles import SpecObstacle
from softact.errors import SpecError
from softact.fields import Fault, Part, fault
from softact.files.text import NAMES_A_FILE, digest
from softact.loads.dynamics import Dynamics
from softact.loads.pressure_file import PressureFile, read
from softact.loads.timing import (
    Amplitude,
    History,
    Hold,
    Sine,
    Smooth,
    Steady,
    Sudden,
    Timing,
    Triangle,
)
from softact.units import Dimensionless, Frequency

Shape = Literal["ramp", "smooth", "hold", "sudden"]
SHAPES: dict[str, Amplitude] = {
    "ramp": Steady(),
    "smooth": Smooth(),
    "hold": Hold(),
    "sudden": Sudden(),
}


class SineSpec(Part, title="Sine"):
    """Loads swing between their last and their new values, and begin and end at rest."""

    frequency: Frequency = Field(gt=0, description="cycles in a second")
    cycles: Dimensionless = Field(1.0, gt=0, le=1e4, description="how many; halves count")


class TriangleSpec(Part, title="Triangle"):
    """Loads go to their new values and back, at a constant rate."""

    cycles: Dimensionless = Field(1.0, gt=0, le=1e4, description="how many in the duration")


class DynamicsSpec(Part, title="Dynamics"):
    """Inertia in real time, by the generalised-alpha method."""

    spectral_radius: Dimensionless = Field(
        0.8,
        ge=0,
        le=1,
        description="what an increment leaves of motions far too fast for it; 1 damps nothing",
    )

    @model_validator(mode="before")
    @classmethod
    def _true(cls, data: Any) -> Any:
        if data is False:
            raise fault("leave dynamics out where a step has no inertia")
        return {} if data is True else data

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """The word true may stand for the whole."""
        return {"anyOf": [{"const": True}, handler(schema)]}


class AmplitudeSpec(Part, title="Amplitude"):
    """One of ramp, smooth, hold and sudden, or one of the following."""

    shape: Shape | None = Field(
        None, description="ramp, smooth, hold or sudden; may stand alone: `amplitude: smooth`"
    )
    sine: SineSpec | None = Field(None, description="cycles as a sine; they say the duration")
    triangle: TriangleSpec | None = Field(None, description="cycles at a constant rate")
    file: Annotated[str | None, NAMES_A_FILE] = Field(
        None,
        description="a CSV file of times and pressures, with units in its header: "
        "`time (s),pressure (kPa)`, or `pressure_NAME (kPa)` for each cavity",
    )

    @model_validator(mode="before")
    @classmethod
    def _one_word(cls, data: Any) -> Any:
        if isinstance(data, str):
            if data not in SHAPES:
                raise fault(
                    f"'{data}' is not one of: {', '.join(SHAPES)}; a file is written {{file: NAME}}"
                )
            return {"shape": data}
        return data

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        given = [name for name in type(self).model_fields if getattr(self, name) is not None]
        if len(given) != 1:
            what = " and ".join(given) or "nothing"
            raise fault(f"{what} given; write one of: {', '.join(SHAPES)}, sine, triangle, file")
        return self

    @field_validator("file")
    @classmethod
    def _can_be_read(cls, name: str | None) -> str | None:
        if name is not None:
            try:
                read(Path(name))
            except SpecError as error:
                raise fault("; ".join(error.lines)) from None
        return name

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """A word may stand for the whole."""
        found = handler(schema)
        return {"anyOf": [{"type": "string", "enum": list(SHAPES)}, found]}

    @property
    def own_duration(self) -> float | None:
        """What says itself how long it lasts, s; None where the step says it."""
        if self.sine is not None:
            return self.sine.cycles / self.sine.frequency
        return None if self.file is None else self.table.duration

    @property
    def table(self) -> PressureFile:
        """What stands in the file."""
        assert self.file is not None
        return read(Path(self.file))

    def amplitude(self, cavities: tuple[str, ...]) -> Amplitude:
        """What the solver takes; cavities: of the geometry."""
        if self.sine is not None:
            return Sine(self.sine.cycles)
        if self.triangle is not None:
            return Triangle(self.triangle.cycles)
        if self.file is not None:
            return History(self.table.parts, self.table.for_cavities(cavities))
        return SHAPES[self.shape or "ramp"]


def timing(
    duration: float | None,
    amplitude: AmplitudeSpec | None,
    cavities: tuple[str, ...],
    dynamics: DynamicsSpec | None = None,
) -> Timing | None:
    """The clock of a step; None where it has none."""
    inertia = None if dynamics is None else Dynamics(dynamics.spectral_radius)
    if amplitude is None:
        return None if duration is None else Timing(duration, dynamics=inertia)
    own = amplitude.own_duration
    whole = own if own is not None else duration
    assert whole is not None  # the step's own check
    return Timing(whole, amplitude.amplitude(cavities), inertia)


def inertia_faults(
    steps: Sequence[Any],
    materials: Mapping[str, BaseModel],
    module: bool,
    obstacles: Mapping[str, SpecObstacle],
) -> Iterator[Fault]:
    """Steps with inertia that the bodies of a spec cannot have. module: the spec is that of one."""
    moving = [number for number, step in enumerate(steps) if step.dynamics is not None]
    if not moving:
        return
    for name, law in materials.items():
        if "density" not in law.model_fields_set:
            what = "missing; dynamics needs the mass; write for example density: 1070 kg/m^3"
            yield ("materials", name, "density"), what
    for name, obstacle in obstacles.items():
        if obstacle.mass is not None and not obstacle.turns_evenly:
            fault = (
                "dynamics follows free bodies that resist all turns alike, such as a sphere or a "
                "cube; leave dynamics out, or the mass"
            )
            yield ("obstacles", name, "mass"), fault
    if module:
        yield ("steps", moving[0], "dynamics"), "a module of a chain has no inertia; leave it out"


def with_contents(steps: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The plain data of steps with what is in the files that they name, in place of the names."""

    def known(step: dict[str, Any]) -> dict[str, Any]:
        amplitude = step.get("amplitude")
        if not isinstance(amplitude, dict) or "file" not in amplitude:
            return step
        return {**step, "amplitude": {"file": digest(Path(amplitude["file"]))}}

    return [known(step) for step in steps]

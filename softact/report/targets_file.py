"""The file of published requirements: applications, what each asks of an actuator, and who says so.

The figures are columns of curve.csv, or those of the undeformed body in ``softact.report.targets``.
"""

from typing import Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from softact.fields import fault, fault_at
from softact.nearest import nearest
from softact.units import conversion, show

#: How the names of figures end -> the unit for the registry.
UNITS = {
    "kPa": "kPa", "MPa": "MPa", "deg": "deg", "mm": "mm", "mm3": "mm^3", "N": "N", "Nmm": "N*mm",
    "mJ": "mJ", "g": "g", "kg": "kg", "N_per_kg": "N/kg", "J_per_kg": "J/kg", "percent": "percent",
}  # fmt: skip


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Source(_Part):
    """A publication."""

    short: str = Field(description="as it stands beside a figure")
    full: str = Field(description="with title and journal")


class Asked(_Part):
    """A requirement; one without a figure is one that no run can tell."""

    source: str = Field(description="name of one of the sources")
    text: str = Field(description="as printed")
    figure: str = Field("", description="what of a run tells it")
    at_least: str | None = Field(None, description="lower bound with its unit")
    at_most: str | None = Field(None, description="upper bound with its unit")
    at: str | None = Field(None, description="pressure with its unit; default: any")
    together: dict[str, str] = Field(
        {}, alias="while", description="figure: value to be reached in the same state"
    )

    @model_validator(mode="after")
    def _one_bound(self) -> Self:
        bounds = [bound for bound in (self.at_least, self.at_most) if bound is not None]
        if len(bounds) != bool(self.figure):
            raise fault("write a figure with one of at_least and at_most, or none of them")
        units = [(bound, self.figure) for bound in bounds]
        units += [(value, figure) for figure, value in self.together.items()]
        units += [(self.at, "pressure_kPa")] if self.at else []
        for text, figure in units:
            try:
                in_unit_of(figure, text)
            except ValueError as error:
                raise fault(f"{show(text)} is no value of {show(figure)}: {error}") from None
        return self

    @property
    def bound(self) -> str | None:
        """The bound as written."""
        return self.at_most if self.at_least is None else self.at_least


class Application(_Part):
    """An application and what it asks for."""

    title: str = Field(description="what it is called")
    requirements: tuple[Asked, ...] = Field(strict=False, min_length=1, description="its bounds")


class TargetsFile(_Part):
    """Published requirements of applications."""

    sources: dict[str, Source] = Field(description="name -> publication")
    targets: dict[str, Application] = Field(description="name -> application")

    @model_validator(mode="after")
    def _sources_are_known(self) -> Self:
        for name, application in self.targets.items():
            for number, asked in enumerate(application.requirements):
                if asked.source not in self.sources:
                    where = ("targets", name, "requirements", number, "source")
                    hint = nearest(asked.source, self.sources)
                    raise fault_at(where, f"no source {show(asked.source)}; {hint}")
        return self


def in_unit_of(figure: str, text: str) -> float:
    """Return a value with its unit in the unit that a figure's name ends with.

    Raises ValueError where it is no such value.
    """
    number, _, unit = text.partition(" ")
    to = figure.rpartition("_")[2]
    if to not in UNITS:
        raise ValueError("its name ends with no unit, as that of blocked_force_N does")
    return float(number) if unit == to else float(number) * conversion(unit, UNITS[to])

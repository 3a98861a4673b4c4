"""How the equilibrium is sought, as a spec says it."""

from typing import Literal, Self

from pydantic import Field, model_validator

from softact.fields import Part, fault
from softact.solve.settings import FactorName, Predictor, Settings
from softact.units import Dimensionless

USUAL = Settings()


class Solver(Part):
    """How the equilibrium is sought. Increments are fractions of a step."""

    element: Literal["P2/P1", "P2/P0", "P2"] = Field(
        "P2/P1",
        description="displacement and pressure; P2/P0 holds the volume under stresses of many "
        "times the shear modulus; P2 alone locks near incompressibility",
    )
    curved: bool = Field(
        True,
        description="round walls are curved in the mesh, too; false: they are flat between the "
        "corners of its elements",
    )
    initial_increment: Dimensionless = Field(
        USUAL.initial_increment, gt=0, le=1, description="first increment"
    )
    max_increment: Dimensionless = Field(
        USUAL.max_increment, gt=0, le=1, description="largest increment"
    )
    min_increment: Dimensionless = Field(
        USUAL.min_increment, gt=0, le=1, description="below it the run ends"
    )
    max_iterations: int = Field(
        USUAL.max_iterations,
        ge=2,
        le=1000,
        description="Newton iterations before the increment is cut; up to three times as many "
        "while the residual falls steadily",
    )
    tolerance: Dimensionless = Field(
        USUAL.tolerance, gt=0, le=1e-2, description="on the relative residual"
    )
    predictor: Predictor = Field(
        USUAL.predictor, description="extrapolation from the last states as the first guess"
    )
    dynamics: bool = Field(
        USUAL.dynamics,
        description="let the actuator move to its next equilibrium where none is near",
    )
    time_tolerance: Dimensionless | None = Field(
        None,
        gt=0,
        le=0.1,
        description="on the error of stresses that creep, in one increment of a step with a clock, "
        f"by the largest stress so far; default: {USUAL.time_tolerance:g}",
    )

    factor: FactorName = Field(
        USUAL.factor,
        description="what factorises the tangent: mumps, or MKL's pardiso where you have installed "
        "mkl yourself: faster, and not free software",
    )

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.min_increment <= self.initial_increment <= self.max_increment:
            raise fault(
                "min_increment <= initial_increment <= max_increment is wanted, not "
                f"{self.min_increment:g}, {self.initial_increment:g}, {self.max_increment:g}"
            )
        return self

    @property
    def settings(self) -> Settings:
        """What of it is the stepper's; ``element`` and ``curved`` are the model's."""
        given = self.model_dump(exclude={"element", "curved"}, exclude_none=True)
        return Settings(**given)

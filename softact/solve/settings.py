"""How equilibrium is sought: the settings of the solver and their defaults."""

from dataclasses import dataclass
from typing import Literal

Predictor = Literal["none", "linear", "quadratic"]
FactorName = Literal["mumps", "pardiso"]


@dataclass(frozen=True)
class Settings:
    """Increments are fractions of a step. The spec's ``solver`` says what each one means."""

    initial_increment: float = 0.1
    max_increment: float = 0.1
    min_increment: float = 1e-4
    max_iterations: int = 15
    tolerance: float = 1e-8
    predictor: Predictor = "quadratic"
    dynamics: bool = True
    time_tolerance: float = 5e-4
    factor: FactorName = "mumps"

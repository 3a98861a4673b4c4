"""What a calibration is asked for, its trials, and what it has found."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from softact.fit.knobs import Knob
from softact.measured.curve import Measured
from softact.spec import Spec


@dataclass(frozen=True)
class CalibrationRequest:
    """What to calibrate.

    vary: see ``read_knobs``. x: abscissa or None. columns: headings in place of the data's own, or
    None. max_runs: then it ends. force: write into the folder whatever it holds.
    """

    spec: Path
    data: Path
    vary: Sequence[str]
    overrides: Sequence[str] = ()
    x: str | None = None
    columns: str | None = None
    processes: int = 1
    max_runs: int = 30
    force: bool = False


@dataclass(frozen=True)
class Trial:
    """One run: values of the knobs, predicted columns (None: it ended early), its folder."""

    values: tuple[float, ...]
    columns: dict[str, np.ndarray] | None
    folder: Path

    @property
    def curves(self) -> dict[str, np.ndarray]:
        """The predicted columns of a run that did not end early. Raises ValueError for another."""
        if self.columns is None:
            raise ValueError(f"{self.folder}: the run ended before the data do")
        return self.columns


def differences(measured: Measured, trial: Trial) -> np.ndarray:
    """Run minus measured (count,), in parts of the largest measured value of their column; infinite
    for a run that ended early."""
    if trial.columns is None:
        return np.full(measured.count, np.inf)
    parts = []
    for name in measured.names:
        data = measured.values[name]
        parts.append((trial.columns[name] - data) / np.max(np.abs(data)))
    return np.concatenate(parts)


def misfit(measured: Measured, trial: Trial) -> float:
    """Root mean square of ``differences``."""
    return float(np.sqrt(np.mean(differences(measured, trial) ** 2)))


@dataclass
class Calibration:
    """The outcome.

    spec: with the constants that were found. first, best: the runs before and after. interval:
    half width of the 95 % interval per knob; NaN at a bound, infinite where the data do not
    determine it. covariance: (k, k) of the knobs, in their units, likewise. trials: all runs
    in their order, those for differences among them.
    """

    spec: Spec
    knobs: list[Knob]
    measured: Measured
    first: Trial
    best: Trial
    interval: np.ndarray
    covariance: np.ndarray
    trials: Sequence[Trial]
    remarks: list[str] = field(default_factory=list)

    @property
    def runs(self) -> int:
        """How many runs it took."""
        return len(self.trials)

    def misfit(self, trial: Trial) -> float:
        """Root mean square of its ``differences`` from the data."""
        return misfit(self.measured, trial)

    def rmse(self, trial: Trial) -> dict[str, float]:
        """Root mean square error of each measured column in its unit."""
        return {
            name: float(np.sqrt(np.mean((trial.curves[name] - self.measured.values[name]) ** 2)))
            for name in self.measured.names
        }

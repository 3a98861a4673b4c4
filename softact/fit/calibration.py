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


@dataclass
class Calibration:
    """The outcome.

    spec: with the constants that were found. first, best: the runs before and after. interval:
    half width of the 95 % interval per knob; NaN at a bound, infinite where the data do not
    determine it. covariance: (k, k) of the knobs, in their units, likewise.
    """

    spec: Spec
    knobs: list[Knob]
    measured: Measured
    first: Trial
    best: Trial
    interval: np.ndarray
    covariance: np.ndarray
    runs: int
    remarks: list[str] = field(default_factory=list)

    def rmse(self, trial: Trial) -> dict[str, float]:
        """Root mean square error of each measured column in its unit."""
        return {
            name: float(np.sqrt(np.mean((trial.curves[name] - self.measured.values[name]) ** 2)))
            for name in self.measured.names
        }

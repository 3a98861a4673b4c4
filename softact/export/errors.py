"""How far the reduced model is from the states of the runs, in and out of its fit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from softact.export import reduced
from softact.export.states import States


@dataclass(frozen=True)
class Deviation:
    """Of one figure, in its unit. percent: the largest of ``of``, which says what 100 % is."""

    name: str
    unit: str
    largest: float
    rms: float
    percent: float
    of: str

    def text(self) -> str:
        """In words."""
        return (
            f"{self.name}: at most {self.largest:.3g} {self.unit} ({self.percent:.2g} % of "
            f"{self.of}), root mean square {self.rms:.3g} {self.unit}"
        )


def against(model: reduced.Reduced, found: States) -> list[Deviation]:
    """Of a model from states; the model takes their pressures and loads and nothing else."""
    seen = model.rod.state(found.pressure, found.force, found.moment, found.gravity)
    turned = np.degrees(found.turned)
    span = max(float(np.ptp(model.states.volume)), 1e-12)
    length = sum(model.data[f"{part}_mm"] for part in ("start", "active_length", "end"))
    bent = np.hypot(seen["bending_y_deg"] - turned[:, 1], seen["bending_z_deg"] - turned[:, 2])
    place = np.column_stack([seen[f"tip_{c}_mm"] for c in "xyz"]) - found.tip
    rows = [
        ("bending angle", "deg", bent, _range(np.degrees(model.states.turned[:, 1:])), "its range"),
        ("tip's place", "mm", np.linalg.norm(place, axis=1), length, "the length"),
        ("volume", "mm3", seen["cavity_volume_mm3"] - found.volume, span, "its change"),
    ]
    if "twist" in model.data["components"]:
        twist = seen["twist_angle_deg"] - turned[:, 0]
        rows.append(("twist", "deg", twist, _range(turned[:, :1]), "its range"))
    return [_deviation(*row) for row in rows]


def _range(values: np.ndarray) -> float:
    """Length of the diagonal of what values (s, k) span."""
    return max(float(np.linalg.norm(np.ptp(values, axis=0))), 1e-12)


def _deviation(name, unit, apart, whole, of) -> Deviation:
    largest = float(np.abs(apart).max())
    return Deviation(
        name, unit, largest, float(np.sqrt(np.mean(apart**2))), 100 * largest / whole, of
    )


def unseen(model: reduced.Reduced) -> tuple[str, list[Deviation]] | None:
    """Deviation from states that a fit did not see, and which these were; None where there are too
    few. Of three or more runs each is left out once, of fewer every second state."""
    parts = list(_folds(model.states, len(model.runs)))
    told = "each run by a fit to the others" if len(model.runs) > 2 else (
        "every second state by a fit to the others"
    )  # fmt: skip
    worst: dict[str, Deviation] = {}
    for left_out in parts:
        if left_out.sum() < 1 or (~left_out).sum() < 6:
            return None
        fitted = reduced.refit(model, model.states.part(~left_out))
        for deviation in against(fitted, model.states.part(left_out)):
            before = worst.get(deviation.name)
            if before is None or deviation.largest > before.largest:
                worst[deviation.name] = deviation
    return (told, list(worst.values())) if parts else None


def _folds(found: States, runs: int) -> Iterator[np.ndarray]:
    if runs > 2:
        for number in range(runs):
            yield found.run == number
        return
    inner = np.zeros(len(found), bool)
    inner[1:-1:2] = True
    yield inner

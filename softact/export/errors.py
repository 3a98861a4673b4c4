"""How far the reduced model is from the states of the runs, in and out of its fit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from softact.errors import SpecError
from softact.export import reduced
from softact.export.rod import COMPONENTS
from softact.export.states import States

#: Of many runs some are left out at once.
MOST_FOLDS = 5


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
    """Of a model from states; the model takes their pressures and loads and nothing else.

    Where a tip is held, its place and angle are given, and the mean moment is compared.
    """
    rows = [*_free_states(model, found.part(~found.held)), *_held_states(model, found)]
    return [_deviation(*row) for row in rows if len(row[2])]


def _free_states(model: reduced.Reduced, found: States) -> Iterator[tuple]:
    if not len(found):
        return
    shapes = reduced.shapes(model.rod, found, reduced.strains(found, model.data))
    seen = model.rod.figures(found.pressure, shapes)
    turned, whole = np.degrees(found.turned), np.degrees(model.states.turned)
    length = sum(model.data[f"{part}_mm"] for part in ("start", "active_length", "end"))
    bent = np.hypot(seen["bending_y_deg"] - turned[:, 1], seen["bending_z_deg"] - turned[:, 2])
    yield "bending angle", "deg", bent, _range(whole[:, 1:]), "its range"
    if "twist" in model.data["components"]:
        twist = seen["twist_angle_deg"] - turned[:, 0]
        yield "twist", "deg", twist, _range(whole[:, :1]), "its range"
    place = np.column_stack([seen[f"tip_{c}_mm"] for c in "xyz"]) - found.tip
    yield "tip's place", "mm", np.linalg.norm(place, axis=1), length, "the length"
    apart = seen["cavity_volume_mm3"] - found.volume
    yield "volume", "mm3", apart, _range(model.states.volume[:, None]), "its change"


def _held_states(model: reduced.Reduced, found: States) -> Iterator[tuple]:
    found, whole = found.part(found.held), model.states.part(model.states.held)
    if not len(found):
        return
    for name in model.data["components"]:
        if name.startswith("bending"):
            given, taken = _moments(model, found, name)
            most = max(float(np.abs(_moments(model, whole, name)[0]).max()), 1e-12)
            yield f"mean moment of a held tip, {name}", "N·mm", taken - given, most, "the largest"


def _moments(model: reduced.Reduced, found: States, name: str) -> tuple[np.ndarray, np.ndarray]:
    """(states,) mean moments: of what holds the tip, and of the model where it is held."""
    at, mean = COMPONENTS.index(name), reduced.strains(found, model.data)
    uniform = np.repeat(mean[:, None], model.rod.pieces, axis=1)
    given = model.rod.loads(uniform, found.force, found.moment, found.gravity)[..., at]
    strain = mean[:, at] - model.rod.rest(found.pressure)[:, at]
    return given.mean(axis=1), model.rod.stiffness(found.pressure)[:, at] * strain


def _range(values: np.ndarray) -> float:
    """Length of the diagonal of what values (s, k) span."""
    return max(float(np.linalg.norm(np.ptp(values, axis=0))), 1e-12)


def _deviation(name: str, unit: str, apart: np.ndarray, whole: float, of: str) -> Deviation:
    largest = float(np.abs(apart).max())
    return Deviation(
        name, unit, largest, float(np.sqrt(np.mean(apart**2))), 100 * largest / whole, of
    )


def unseen(model: reduced.Reduced) -> tuple[str, list[Deviation]] | None:
    """Deviation from states that a fit did not see, and which these were; None where there are too
    few. Of three or more runs each is left out once (of more than five a fifth of them at a time),
    of fewer every second state."""
    parts = list(_folds(model.states, len(model.runs)))
    told = "each run by a fit to the others" if len(model.runs) > 2 else (
        "every second state by a fit to the others"
    )  # fmt: skip
    worst: dict[str, Deviation] = {}
    for left_out in parts:
        if left_out.sum() < 1 or (~left_out).sum() < 6:
            return None
        try:
            fitted = reduced.refit(model, model.states.part(~left_out))
            found = against(fitted, model.states.part(left_out))
        except SpecError:  # a part of the states does not tell a model that bears the others' loads
            return None
        for deviation in found:
            before = worst.get(deviation.name)
            if before is None or deviation.largest > before.largest:
                worst[deviation.name] = deviation
    return (told, list(worst.values())) if parts else None


def _folds(found: States, runs: int) -> Iterator[np.ndarray]:
    if runs > 2:
        for number in range(min(runs, MOST_FOLDS)):
            yield found.run % MOST_FOLDS == number
        return
    inner = np.zeros(len(found), bool)
    inner[1:-1:2] = True
    yield inner

"""A reduced model of an actuator, fitted to the states of its runs: a rod of pieces of constant
curvature whose rest shape, stiffness and volume follow the pressure; see ``rod`` for the model and
``states`` for what it is fitted to.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from softact.errors import SpecError
from softact.export import fitting, masses, states
from softact.export.rod import COMPONENTS, Rod, rotations
from softact.export.stiffness import ASSUMED, FITTED, SAME, assumed
from softact.results.folder import Results
from softact.verdict.judge import from_data

TABLE_ROWS = 41
#: A piece turns by no more, degrees; and there are no fewer and no more pieces.
PIECE_TURN, FEWEST, MOST = 8.0, 6, 40
#: How much less a neutral line is drawn from a stretch that the pressure alone explains.
BY_PRESSURE = 0.1
ROUNDS = 3
#: An actuator that bends by less, in radians, has its line through the centres of its ends.
LEAST_BENT = 0.02


@dataclass(frozen=True)
class Body:
    """The undeformed actuator in the model's directions, the clamp's centre in the origin, mm.

    base: that centre, and axes: (3, 3) the directions, both as the spec has them. length, tip: from
    clamp to tip. active: between which x the driven cavities lie. places, masses: of its cells.
    box: (2, 3) smallest and largest coordinates.
    """

    base: np.ndarray
    axes: np.ndarray
    length: float
    tip: np.ndarray
    active: tuple[float, float]
    places: np.ndarray
    masses: np.ndarray
    box: np.ndarray


@dataclass(frozen=True)
class Origin:
    """Where a model is from, in words. source: what it was made of; beside: the states that it is
    compared with; verdict: on the source. fitted: whether it was fitted to these states."""

    source: str
    beside: str
    verdict: str
    fitted: bool = True


@dataclass(frozen=True)
class Reduced:
    """A reduced model.

    data: the model in numbers, as ``model.json`` holds it. rod: the model itself. states: what it
    is compared with. body: the undeformed actuator. runs: results that it was fitted to.
    """

    data: dict
    rod: Rod
    states: states.States
    body: Body
    runs: tuple[Results, ...]
    origin: Origin


def fit(runs: Sequence[Results], pieces: int | None = None) -> Reduced:
    """Fit the reduced model to the states of runs of one actuator.

    pieces: of constant curvature; by default so many that none turns by more than 8 degrees.
    Raises SpecError where the runs do not allow it.
    """
    runs = tuple(runs)
    states.check(runs)
    body = _body(runs[0])
    found = states.gather(runs, body.base)
    return fit_states(runs, body, found, pieces or pieces_for(found))


def fit_states(runs: tuple[Results, ...], body: Body, found: states.States, pieces: int) -> Reduced:
    """The same for some of the states."""
    data = _geometry(runs[0], body, found, pieces)
    mean = strains(found, data)
    free, table, sources = _law(runs[0], body, found, data, mean)
    data |= {"components": free, "table": table, "stiffness_from": sources}
    rod = Rod(data)
    _fill_volume(data, found, rod, shapes(rod, found, mean))
    return Reduced(data, Rod(data), found, body, runs, _origin(runs))


def refit(model: Reduced, found: states.States) -> Reduced:
    """The same model fitted to other states, such as a part of its own."""
    return fit_states(model.runs, model.body, found, model.data["pieces"])


def _origin(runs: Sequence[Results]) -> Origin:
    names = [run.directory.name for run in runs]
    verdicts = [from_data(run.run.get("verdict")) for run in runs]
    cells = Counter(found.cell if found else "without one" for found in verdicts)
    return Origin(
        names[0] if len(names) == 1 else f"{len(names)} runs",
        "finite-element states",
        "the runs: " + ", ".join(f"{count} {said}" for said, count in cells.items()),
    )


def pieces_for(found: states.States) -> int:
    """So many that in no state one turns by more than ``PIECE_TURN``."""
    turned = np.degrees(np.linalg.norm(found.turned, axis=1)).max()
    return int(np.clip(np.ceil(turned / PIECE_TURN), FEWEST, MOST))


def _body(run: Results) -> Body:
    layout = run.layout
    axes = states.frame(layout)
    base, tip = masses.centre(run, layout.clamp), masses.centre(run, layout.tip)
    tip = axes @ (tip - base)
    places, mass = masses.point_masses(run, states.spec_of(run))
    places = (places - base) @ axes.T
    walls = [run.surfaces[name] for name in states.driven_walls(run)]
    walls = [wall for wall in walls if len(wall)]
    active = 0.0, float(tip[0])
    if walls:
        nodes = np.unique(np.concatenate([wall[:, :3].ravel() for wall in walls]))
        along = (run.points[nodes] - base) @ axes[0]
        active = float(max(0.0, along.min())), float(min(tip[0], along.max()))
    if not active[1] - active[0] > 0:
        raise SpecError(f"{run.directory}: its cavities have no extent from clamp to tip")
    corners = np.vstack([run.points, *[run.points * np.where(np.arange(3) == n, -1.0, 1.0)
                                       for n in layout.symmetry.values()]])  # fmt: skip
    corners = (corners - base) @ axes.T
    box = np.stack([corners.min(axis=0), corners.max(axis=0)])
    return Body(base, axes, float(tip[0]), tip, active, places, mass, box)


def _geometry(run: Results, body: Body, found: states.States, pieces: int) -> dict:
    """What the model holds of the undeformed actuator, its line where states say."""
    name = {"name": str(run.spec.get("name") or "actuator")}
    y, z = _neutral(found, undeformed(body, pieces, (0.0, 0.0)), body.box)
    return name | undeformed(body, pieces, (y, z))


def undeformed(body: Body, pieces: int, offset: tuple[float, float]) -> dict:
    """Lengths and masses of a model whose line lies at an offset (y, z), mm."""
    start, stop = body.active
    y, z = offset
    data: dict = {
        "pieces": pieces,
        "start_mm": start,
        "active_length_mm": stop - start,
        "end_mm": body.length - stop,
        "tip_y_mm": float(body.tip[1]),
        "tip_z_mm": float(body.tip[2]),
        "offset_y_mm": y,
        "offset_z_mm": z,
    }
    borders = [0.0, *np.linspace(start, stop, pieces + 1), body.length]
    lumps = masses.lumps(body.places, body.masses, borders)
    middles = (np.array(borders[1:]) + borders[:-1]) / 2
    line = np.column_stack([middles, np.full(len(middles), y), np.full(len(middles), z)])
    data["masses"] = {
        "mass_tonne": lumps.mass.tolist(),
        "centre_mm": (np.where(lumps.mass[:, None] > 0, lumps.centre - line, 0.0)).tolist(),
    }
    return data


def _arc(found: states.States, data: dict) -> np.ndarray:
    """(states,) mm length of the arc of constant curvature on the rod's line."""
    offset = np.array([0.0, data["offset_y_mm"], data["offset_z_mm"]])
    arm = np.array([data["end_mm"], data["tip_y_mm"], data["tip_z_mm"]]) - offset
    turn, chord = rotations(found.turned)
    span = found.tip - turn @ arm - offset - [data["start_mm"], 0.0, 0.0]
    return np.linalg.norm(span, axis=1) / np.linalg.norm(chord[:, :, 0], axis=1)


def _neutral(found: states.States, data: dict, box: np.ndarray) -> tuple[float, float]:
    """Where the line lies that bends without a stretch, as far as there is one: y and z, mm.

    A line beside another one, by o, has an arc that is longer by o times the angle.
    """
    longer = _arc(found, data) - data["active_length_mm"]
    by_pressure = BY_PRESSURE * fitting.basis(fitting.knots_of(found.pressure), found.pressure)
    bent = np.column_stack([found.turned[:, 2], -found.turned[:, 1]])
    place = np.linalg.lstsq(np.hstack([bent, by_pressure]), longer, rcond=None)[0][:2]
    place = np.where(np.ptp(bent, axis=0) > LEAST_BENT, place, 0.0)
    y, z = np.clip(place, box[0, 1:], box[1, 1:])
    return float(y), float(z)


def strains(found: states.States, data: dict) -> np.ndarray:
    """(states, 4) mean strains of the rod that finite elements found."""
    stretch = _arc(found, data) / data["active_length_mm"] - 1
    return np.column_stack([found.turned / data["active_length_mm"], stretch])


def shapes(rod: Rod, found: states.States, mean: np.ndarray) -> np.ndarray:
    """(states, pieces, 4) strains of the model under the loads of states; of a tip that is held,
    the mean strains ``mean`` that finite elements found. Raises SpecError where a load is more than
    the model bears."""
    solved = np.repeat(mean[:, None], rod.pieces, axis=1)
    loose = ~found.held
    loads = found.force[loose], found.moment[loose], found.gravity[loose]
    try:
        solved[loose] = rod.solve(found.pressure[loose], *loads)
    except ArithmeticError:
        raise SpecError(
            "the reduced model finds no equilibrium under the loads of these runs: they buckle it, "
            "or they are too few to tell its stiffness; add runs with smaller payloads"
        ) from None
    return solved


def _free(run: Results, mean: np.ndarray, length: float) -> list[str]:
    """Components that the model has: symmetry excludes others, or they do not occur."""
    free = {"stretch"}
    if len(run.layout.symmetry) < 2:
        free.add("bending_y")
    if run.layout.bending_axis is None and not run.layout.symmetry:
        free.add("bending_z")
    if np.degrees(np.abs(mean[:, 0]).max() * length) > states.TWISTED:
        free.add("twist")
    return [name for name in COMPONENTS if name in free]


def _law(
    run: Results, body: Body, found: states.States, data: dict, mean: np.ndarray
) -> tuple[list[str], dict, dict[str, str]]:
    """Rest strains and stiffnesses as functions of the pressure."""
    length = data["active_length_mm"]
    free = _free(run, mean, length)
    grid = np.linspace(min(found.pressure.min(), 0.0), max(found.pressure.max(), 0.0), TABLE_ROWS)
    guess = {**data, "components": free, "table": _empty(grid)}
    guessed, uniform = Rod(guess), np.repeat(mean[:, None], data["pieces"], axis=1)
    stiff = assumed(run, body, data)
    sources = {}
    for _ in range(ROUNDS):
        loads = guessed.loads(uniform, found.force, found.moment, found.gravity)
        curves, compliances = {}, {}
        for name in free:
            at = COMPONENTS.index(name)
            seen = length if name != "stretch" else 1.0
            scale = 1.0 / stiff[name]
            pairs = found.pressure, mean[:, at], loads[..., at].mean(axis=1)
            curves[name], compliances[name] = fitting.strain(*pairs, seen)
            if not compliances[name].terms:
                sources[name] = ASSUMED
                given = fitting.Compliance((scale,), 1.0)
                left = pairs[1] - scale * pairs[2]
                curves[name], compliances[name] = fitting.curve(pairs[0], left), given
            else:
                sources[name] = FITTED
        _share(curves, compliances, sources, found, mean, loads)
        table = _table(grid, free, curves, compliances)
        solved = shapes(Rod({**data, "components": free, "table": table}), found, mean)
        # The next round takes the loads of this shape, brought to the mean strains that were found.
        uniform = solved + (mean - solved.mean(axis=1))[:, None]
    return free, table, sources


def _share(
    curves: dict[str, fitting.Curve],
    compliances: dict[str, fitting.Compliance],
    sources: dict[str, str],
    found: states.States,
    mean: np.ndarray,
    loads: np.ndarray,
) -> None:
    """An actuator without a plane of bending is as stiff in one plane as in the other."""
    pair = ("bending_y", "bending_z")
    known = [name for name in pair if sources.get(name) == FITTED]
    if len(known) == 1 and all(name in curves for name in pair):
        other = pair[1 - pair.index(known[0])]
        at = COMPONENTS.index(other)
        compliances[other], sources[other] = compliances[known[0]], SAME
        left = mean[:, at] - compliances[other](found.pressure) * loads[..., at].mean(axis=1)
        curves[other] = fitting.curve(found.pressure, left)


def _empty(grid: np.ndarray) -> dict:
    nothing = {f"{kind}_{c}": [0.0] * len(grid) for kind in ("rest", "stiffness")
               for c in COMPONENTS}  # fmt: skip
    return {"pressure_kPa": grid.tolist(), **nothing, "rest_volume_mm3": [0.0] * len(grid)}


def _table(
    grid: np.ndarray,
    free: Sequence[str],
    curves: Mapping[str, fitting.Curve],
    compliances: Mapping[str, fitting.Compliance],
) -> dict:
    table = _empty(grid)
    for name in COMPONENTS:
        if name in free:
            table[f"rest_{name}"] = curves[name](grid).tolist()
            table[f"stiffness_{name}"] = (1.0 / compliances[name](grid)).tolist()
        else:
            table[f"stiffness_{name}"] = [None] * len(grid)
    return table


def _fill_volume(data: dict, found: states.States, rod: Rod, solved: np.ndarray) -> None:
    """The volume without a load: what Maxwell's relation leaves of the volumes found."""
    by_loads = rod.volume(found.pressure, solved)  # of a table of zeros
    grid = np.array(data["table"]["pressure_kPa"])
    found_curve = fitting.curve(found.pressure, found.volume - by_loads)
    data["table"]["rest_volume_mm3"] = found_curve(grid).tolist()

"""A reduced model from the table of an actuator's module, without any fit to runs.

At each pressure the module that nothing holds gives the strains without a load and the volume, and
the second derivatives of its energy there give the stiffnesses. The model is compared with the
states of the rod of these modules, which knows more: how the stiffness follows the load, and shear.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softact.errors import SpecError
from softact.export import errors, reduced, statement, states
from softact.export.job import DAMPING_RATIO, Job
from softact.export.reduced import Body, Origin, Reduced
from softact.export.rod import COMPONENTS, Rod
from softact.export.stiffness import OF_MODULE
from softact.modules.chain import Acting, Chain
from softact.modules.driven import driven
from softact.modules.rod_run import RodRun
from softact.spec import Spec

Array = NDArray[np.float64]
BESIDE = "states of the rod of modules"
TOUCHED = 1e-6  # N: an obstacle that pushes more is another load


def check(spec: Spec) -> None:
    """Raise SpecError where several pressures are driven apart."""
    if len(spec.geometry.in_segments()) > 1:
        raise SpecError("a reduced model follows one pressure, and here each segment has its own")
    loads = driven(spec)
    if len(loads.groups) != 1:
        raise SpecError(
            f"a reduced model follows one pressure, and here {len(loads.groups)} are driven apart: "
            f"{', '.join(loads.names)}"
        )


def prepare(
    chain: Chain, run: RodRun, pieces: int | None = None, damping_ratio: float = DAMPING_RATIO
) -> Job:
    """The model of a chain of modules whose spec passes ``check``, beside the states of its rod.
    Raises SpecError where there are none at rest."""
    table, axes = chain.table, states.frame(chain.layout)
    found = _states(chain, run, axes)
    if not len(found):
        raise SpecError("the rod has no state at rest under weight and payload alone to export")
    body = _body(chain, axes)
    data = _data(chain, body, axes, pieces or reduced.pieces_for(found))
    origin = Origin(f"{chain.spec.name}, {len(table.walked.samples.places)} states of its module",
                    BESIDE, f"its law: off by at most {100 * table.errors.max():.2g} % at states "
                    "held out", False)  # fmt: skip
    model = Reduced(data, Rod(data), found, body, (), origin)
    seen = errors.against(model, found)
    about = statement.lines(model, seen, None, damping_ratio)
    return Job(model, seen, None, damping_ratio, about)


def _states(chain: Chain, run: RodRun, axes: Array) -> states.States:
    """Those of a rod at rest that nothing but weight and payload loads."""
    timed = {s.name for s in chain.spec.steps if s.timing(chain.layout)}
    acting = _acting(chain)
    length, left_out = float(chain.lengths.sum()), Counter[str]()
    kept, loads = [], []
    for number, row in enumerate(run.rows):
        name = str(row["step"])
        pushed = [float(v) for key, v in row.items() if key.startswith("contact_force_")]
        if name in timed:
            left_out[states.MOVING] += 1
        elif max(map(abs, pushed), default=0.0) > TOUCHED:
            left_out[states.OTHER_LOAD] += 1
        else:
            before, after = acting[name]
            kept.append(number)
            loads.append(before.towards(after, float(row["step_fraction"])))
    rows, count = [run.rows[n] for n in kept], len(kept)
    tip = np.array([[row[f"tip_{c}_mm"] for c in "xyz"] for row in rows], float).reshape(-1, 3)
    curved = np.array([run.strains[n][:, :3].mean(axis=0) for n in kept]).reshape(-1, 3)
    force = np.array([load.payload for load in loads]).reshape(-1, 3)
    gravity = np.array([load.gravity for load in loads]).reshape(-1, 3)
    return states.States(
        run=np.zeros(count, int),
        pressure=np.array([1e3 * float(load.pressures[0, 0]) for load in loads]),
        turned=length * curved @ axes.T,
        tip=(tip - chain.base) @ axes.T,
        volume=np.array([_volume(row) for row in rows]),
        force=force @ axes.T,
        moment=np.zeros((count, 3)),
        gravity=gravity @ axes.T,
        held=np.zeros(count, bool),
        left_out=left_out,
    )


def _volume(row: Mapping[str, Any]) -> float:
    (name,) = (key for key in row if key.startswith("cavity_volume"))
    return float(row[name])


def _acting(chain: Chain) -> dict[str, tuple[Acting, Acting]]:
    """What acts at the start and at the end of each step."""
    before, found = chain.at_rest(), {}
    for number, step in enumerate(chain.spec.steps):
        after = chain.acting(number, before)
        found[step.name] = before, after
        before = after
    return found


def _body(chain: Chain, axes: Array) -> Body:
    """The undeformed actuator. Each slice is six points with its mass and its second moments."""
    lumps = chain.table.lumps
    places, weights = [], []
    for mass, centre, spread in zip(lumps.masses, lumps.centres, lumps.spreads, strict=True):
        if mass > 0:
            sizes, ways = np.linalg.eigh(spread)
            arms = np.sqrt(3 * np.maximum(sizes, 0.0) / mass) * ways
            places += [centre + sign * arm for arm in arms.T for sign in (1, -1)]
            weights += [mass / 6] * 6
    tip = axes @ (lumps.tip - chain.base)
    outline = (lumps.outline + np.asarray(chain.layout.origin) - chain.base) @ axes.T
    mirrored = [
        outline * np.where(np.abs(axes) @ np.eye(3)[plane] > 0.5, -1.0, 1.0)
        for plane in chain.layout.symmetry.values()
    ]
    corners = np.vstack([outline, *mirrored])
    box = np.stack([corners.min(axis=0), corners.max(axis=0)])
    box[:, 0] = 0.0, tip[0]
    active = chain.spare, chain.spare + float(chain.lengths.sum())
    return Body(chain.base, axes, float(tip[0]), tip, active,
                (np.array(places) - chain.base) @ axes.T, np.array(weights), box)  # fmt: skip


def _data(chain: Chain, body: Body, axes: Array, pieces: int) -> dict[str, Any]:
    """The model in numbers, as ``softact.export.reduced`` makes it of runs."""
    table = chain.table
    low, high = min(float(table.low[0]), 0.0), max(float(table.high[0]), 0.0)
    pressures = np.linspace(low, high, reduced.TABLE_ROWS)
    laws = [_law(chain, axes, pressure) for pressure in pressures]
    rest, stiffness, coupling, volume = (np.array(c) for c in zip(*laws, strict=True))
    # The line beside the module's, on which a bend brings no stretch at a middle pressure.
    of_bend = coupling[len(coupling) // 2]
    offset = np.array([0.0, of_bend[2], -of_bend[1]])
    rest[:, 3] += rest[:, 1] * offset[2] - rest[:, 2] * offset[1]
    free = _free(table.free, axes)
    columns = {"pressure_kPa": (1e3 * pressures).tolist(), "rest_volume_mm3": volume.tolist()}
    for at, name in enumerate(COMPONENTS):
        columns[f"rest_{name}"] = (rest[:, at] if name in free else 0.0 * pressures).tolist()
        known = stiffness[:, at].tolist() if name in free else [None] * len(pressures)
        columns[f"stiffness_{name}"] = known
    data = {"name": str(chain.spec.name or "actuator")}
    data |= reduced.undeformed(body, pieces, (float(offset[1]), float(offset[2])))
    return data | {
        "components": free,
        "table": columns,
        "stiffness_from": {name: OF_MODULE for name in free},
    }


def _free(free: NDArray[np.int64], axes: Array) -> list[str]:
    """Components that symmetry leaves: all of the model but those about an axis that it holds."""
    turns = [int(np.abs(axes[:, i]).argmax()) for i in free if i < 3]
    return [name for at, name in enumerate(COMPONENTS) if name == "stretch" or at in turns]


def _law(chain: Chain, axes: Array, pressure: float) -> tuple[Array, Array, Array, float]:
    """At a pressure, MPa: strains (4,) without a load, stiffnesses (4,), stretch by curvature (3,)
    at no force, and the volume, mm³, in the model's directions."""
    table, given = chain.table, np.array([pressure])
    place = np.concatenate([table.free_curvature(given), given])
    firsts, seconds = table.energy.both(place[None])
    first, second, k = firsts[0], seconds[0], table.k
    pull = int(np.flatnonzero(table.free == 3 + table.axis)[0])
    bends = np.flatnonzero(table.turns)
    curvature, coupling, stiff = np.zeros(3), np.zeros(3), np.zeros((3, 3))
    curvature[table.free[bends]] = place[bends]
    coupling[table.free[bends]] = -second[pull, bends]
    stiff[np.ix_(table.free[bends], table.free[bends])] = second[np.ix_(bends, bends)]
    idle, lost = table.ends.at(given)
    bending = chain.segments.modules - table.ends.stiff
    part = 1 - (idle - table.ends.stiff) / bending if table.ends.known else 1.0
    rest = np.append(part * (axes @ curvature), -first[pull])
    stiffness = np.append(np.diag(axes @ stiff @ axes.T), -1 / second[pull, pull])
    volume = -chain.segments.modules * table.pitch * first[k] - lost[0]
    return rest, stiffness, axes @ coupling, float(volume)

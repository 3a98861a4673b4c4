"""Where a run stands: enough to go on from its last accepted increment to the same numbers.

Unknowns are stored with the places of their nodes, so that a run may go on with another number of
processes, which hold other parts of the mesh.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import scipy.spatial

from softact.errors import SpecError
from softact.files.restart import RESTART, of_another_version, seal, unseal
from softact.loads import BY_FIELD
from softact.solve.path import Point
from softact.system.term import AIR, CONTACT, Clock, State, Value

if TYPE_CHECKING:
    import dolfinx
    from mpi4py import MPI
    from numpy.lib.npyio import NpzFile

    from softact.model import Model

SAME_PLACE = 1e-9  # of the body's size
#: How the names begin of what all processes remember alike; it is stored once.
COMMON = (AIR, CONTACT)
# How names ended, without ``CONTACT``, where each process had facets in an order of its own.
_FORMER = (".partner", ".stiffness")


@dataclass
class Checkpoint:
    """A run after an accepted increment under load control.

    step: number of the current step. begun: state at its start. state: now. path: its last points.
    size: next increment. traced_at: where volume control was tried. rows: increments written down.
    attempts, remarks, notes, counts: what the run has told so far. curve: text of curve.csv; spec:
    see ``softact.run.resuming.identity``. passed: what ``softact.solve.passed.Passed`` keeps of
    this process. beside, vectors: what is carried along beside the run, as plain data and as
    unknowns (local,).
    """

    step: int
    begun: State
    state: State
    path: list[Point]
    size: float
    traced_at: float | None
    rows: int
    attempts: list[dict] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    counts: dict = field(default_factory=dict)
    curve: str = ""
    spec: dict = field(default_factory=dict)
    passed: dict[str, np.ndarray] = field(default_factory=dict)
    beside: dict = field(default_factory=dict)
    vectors: list[np.ndarray] = field(default_factory=list)

    @property
    def step_done(self) -> bool:
        """Whether the current step is at its end."""
        return self.path[-1].s >= 1.0


# Entries of a checkpoint that are stored as they are: all but what is made of vectors.
PLAIN = tuple(
    item.name
    for item in fields(Checkpoint)
    if item.name not in ("begun", "state", "path", "passed", "beside", "vectors")
)


def pack(model: Model, checkpoint: Checkpoint) -> bytes | None:
    """The checkpoint as the content of a file, on rank 0 (None elsewhere). Collective."""
    arrays: dict[str, np.ndarray] = {}
    vectors = [checkpoint.begun.x, *(point.x for point in checkpoint.path)]
    rate = checkpoint.path[-1].rate
    if rate is not None:
        vectors.append(rate)
    vectors += checkpoint.vectors
    for number, (places, dofs, owned) in enumerate(_groups(model)):
        mine = places[:owned], np.stack([x[dofs[:owned]] for x in vectors])
        found = model.comm.gather(mine)
        if found is not None:
            arrays[f"places_{number}"] = np.concatenate([places for places, _ in found])
            arrays[f"values_{number}"] = np.concatenate([v for _, v in found], axis=1)
    parts = {"begun": checkpoint.begun.memory, "now": checkpoint.state.memory}
    memories = model.comm.gather(parts | {"passed": checkpoint.passed})
    shares = model.comm.gather(_share(model))
    if memories is None:
        return None
    for rank, parts in enumerate(memories):
        for when, memory in parts.items():
            for name, value in memory.items():
                if rank and name.startswith(COMMON):
                    continue
                arrays[f"memory/{rank}/{when}/{name}"] = np.asarray(value)
    known = {
        **{name: getattr(checkpoint, name) for name in PLAIN},
        "begun": plain_loads(checkpoint.begun),
        "state": plain_loads(checkpoint.state),
        "path": [{"s": p.s, "q": p.q.tolist()} for p in checkpoint.path],
        "times": [checkpoint.begun.clock.now, checkpoint.state.clock.now],
        "has_rate": rate is not None,
        "beside": checkpoint.beside,
        "vectors": len(checkpoint.vectors),
        "processes": len(memories),
        "parts": shares,
    }
    return seal(known, arrays)


def read(model: Model, directory: Path) -> Checkpoint | None:
    """The checkpoint in a result folder; None where there is none. Collective.

    Raises DamagedResultError where it cannot be used, SpecError where it does not fit the model's
    mesh or processes.
    """
    path = Path(directory) / RESTART
    if not model.comm.bcast(path.is_file() if model.comm.rank == 0 else None):
        return None
    known, file = unseal(path)
    try:
        return _unpacked(model, path, known, file)
    except (KeyError, TypeError, ValueError, IndexError):
        raise of_another_version(path) from None


def _unpacked(model: Model, path: Path, known: Mapping, file: NpzFile) -> Checkpoint:
    count, more = 1 + len(known["path"]), known.get("vectors", 0)
    vectors = np.zeros((count + known["has_rate"] + more, model.unknowns.local))
    for number, (places, dofs, _) in enumerate(_groups(model)):
        known_places = file.get(f"places_{number}", np.empty((0, 3)))
        order = _find(known_places, places) if len(known_places) else None
        if model.comm.allreduce(int(order is None)):
            raise SpecError(f"{path}: was written on another mesh; start the run anew")
        for vector, values in zip(vectors, file[f"values_{number}"], strict=True):
            vector[dofs] = values[order]
    if any(n.endswith(_FORMER) and CONTACT not in n for n in file.files):
        raise KeyError("contact")
    same_parts = _same_parts(model, known)
    states, (began, now) = [], known["times"]
    for when, loads, x, time in (
        ("begun", known["begun"], vectors[0], began),
        ("now", known["state"], vectors[count - 1], now),
    ):
        if set(loads) != {field for field, load in BY_FIELD.items() if not load.holds_volume}:
            raise KeyError("loads")
        memory = _memory(file, known["processes"], same_parts, when, model.comm)
        named = loads_of(loads)
        states.append(State(x.copy(), named, memory, clock=Clock(time, time)))
    points = [
        Point(p["s"], x, np.array(p["q"], dtype=float))
        for p, x in zip(known["path"], vectors[1:count], strict=True)
    ]
    if known["has_rate"]:
        points[-1] = replace(points[-1], rate=vectors[count])
    begun, now = states
    plain = {name: known[name] for name in PLAIN}
    passed = _passed(file, known["processes"], same_parts, model.comm)
    beside = {"beside": known.get("beside", {}), "vectors": list(vectors[len(vectors) - more :])}
    return Checkpoint(begun=begun, state=now, path=points, passed=passed, **beside, **plain)


@dataclass(frozen=True)
class Ended:
    """Where the run of another actuator stood at its end: unknowns (local,), and those of its twins
    by their parameters' paths."""

    x: np.ndarray
    twins: Mapping[str, np.ndarray]


def ended(model: Model, directory: Path, places: np.ndarray) -> Ended | str:
    """The end of another actuator's run on a mesh of the same cells, of one process; or why it is
    none. places: (n, 3) of its nodes as they are numbered in its fields.

    Raises DamagedResultError where the file cannot be used.
    """
    path = Path(directory) / RESTART
    if not path.is_file():
        return "that run has left nothing to go on from"
    known, file = unseal(path)
    count = 1 + len(known["path"])
    vectors = np.zeros((count + known["has_rate"] + known["vectors"], model.unknowns.local))
    for number, (here, dofs, _) in enumerate(_groups(model)):
        if known["processes"] != 1 or file.get(f"places_{number}", places[:0]).shape != here.shape:
            return "its unknowns are others"
        vectors[:, dofs] = file[f"values_{number}"]
    nodes = file["places_0"]
    if not np.array_equal(nodes, places[model.nodes.number[: len(nodes)]]):
        return "its nodes are numbered otherwise"
    of_twins = vectors[len(vectors) - known["vectors"] :][1::2]
    twins = dict(zip(known["beside"].get("twins", {}), of_twins, strict=True))
    return Ended(vectors[count - 1], twins)


def _share(model: Model) -> list[list[float]]:
    """What tells the part of the mesh that a process has: number and centre of its nodes."""
    return [
        [owned, *places[:owned].mean(axis=0).tolist()] if owned else [0, 0.0, 0.0, 0.0]
        for places, _, owned in _groups(model)
    ]


def _same_parts(model: Model, known: Mapping) -> bool:
    """Whether each process has the part of the mesh that it had. Collective."""
    if known["processes"] != model.comm.size:
        return False
    mine = _share(model)
    kept = known.get("parts", [mine] if model.comm.size == 1 else [[]] * model.comm.size)
    there = np.array(kept[model.comm.rank], dtype=float)
    here = np.array(mine, dtype=float)
    size = max(float(np.abs(here).max(initial=0.0)), 1.0)
    same = here.shape == there.shape and bool(np.abs(here - there).max(initial=0.0) < 1e-6 * size)
    return bool(model.comm.allreduce(int(same)) == model.comm.size)


def _passed(
    file: NpzFile, processes: int, same_parts: bool, comm: MPI.Comm
) -> dict[str, np.ndarray]:
    """Equilibria that were passed; without a limit, other parts of the mesh need not know them."""
    if not same_parts and not file["memory/0/passed/left"]:
        return {}
    kept = _memory(file, processes, same_parts, "passed", comm)
    return {name: np.asarray(value) for name, value in kept.items()}


def _memory(
    file: NpzFile, processes: int, same_parts: bool, when: str, comm: MPI.Comm
) -> dict[str, np.ndarray | float]:
    """What ``pack`` was given by this process."""
    prefix = f"memory/{comm.rank}/{when}/"
    own = {n.removeprefix(prefix): file[n] for n in file.files if n.startswith(prefix)}
    own = {name: value for name, value in own.items() if not name.startswith(COMMON)}
    found = {name: value if value.ndim else float(value) for name, value in own.items()}
    if comm.allreduce(len(found)) and processes != comm.size:
        raise SpecError(
            "a run with an obstacle, with inertia, with a material that creeps or softens, or "
            f"beyond a limit of its load, was begun with -n {processes} and goes on with as many, "
            f"not with -n {comm.size}"
        )
    if comm.allreduce(len(found)) and not same_parts:
        raise SpecError(
            "a run with an obstacle, or beyond a limit of its load, was begun by an earlier "
            "softact, which gave each process another part of the mesh; start it anew, or with -n 1"
        )
    first = f"memory/0/{when}/"
    everywhere = {n.removeprefix(first): file[n] for n in file.files if n.startswith(first)}
    common = {n: value for n, value in everywhere.items() if n.startswith(COMMON)}
    return found | {n: value if value.ndim else float(value) for n, value in common.items()}


def _groups(model: Model) -> list[tuple[np.ndarray, np.ndarray, int]]:
    """Places (n, 3), unknowns (n, size) and how many of them are this process's own, of each space,
    of the nodes of sheets and of what is no node's, which has its number for a place."""
    unknowns = model.unknowns
    groups = [
        (_places(space), dofs, space.dofmap.index_map.size_local)
        for space, dofs in zip(unknowns.spaces, unknowns.space_dofs, strict=True)
    ]
    if groups:  # the displacement's nodes lie on curved walls
        _, dofs, owned = groups[0]
        groups[0] = model.nodes.places[: len(dofs)], dofs, owned
    loose = len(unknowns.loose_dofs)
    if loose:
        groups.append((model.nodes.places[-loose:], unknowns.loose_dofs, loose))
    apart = len(unknowns.apart_dofs)
    if apart:
        numbers = np.zeros((apart, 3))
        numbers[:, 0] = np.arange(apart)
        groups.append((numbers, unknowns.apart_dofs, apart if model.comm.rank == 0 else 0))
    return groups


def _places(space: dolfinx.fem.FunctionSpace) -> np.ndarray:
    return space.tabulate_dof_coordinates()


def _find(stored: np.ndarray, wanted: np.ndarray) -> np.ndarray | None:
    """Where the wanted places are among the stored ones; None where one is missing."""
    size = max(float(np.ptp(stored, axis=0).max()), 1e-300)
    if stored.shape == wanted.shape and np.abs(stored - wanted).max() < SAME_PLACE * size:
        return np.arange(len(wanted))  # also where sheets lie on each other
    distance, order = scipy.spatial.cKDTree(stored).query(wanted)
    return order if not len(distance) or distance.max() < SAME_PLACE * size else None


def plain_loads(state: State) -> dict[str, dict]:
    """The loads of a state by field, as plain data."""
    return {
        field: {name: np.asarray(value, dtype=float).tolist() for name, value in values.items()}
        for field, values in state.loads.items()
    }


def loads_of(plain: Mapping[str, dict]) -> dict[str, dict[str, Value]]:
    """The loads of a state of which ``plain_loads`` has made plain data."""
    return {field: _values(written) for field, written in plain.items()}


def _values(written: dict[str, float | list]) -> dict[str, Value]:
    """The loads of one field, of which ``_loads`` has made plain data."""
    values = ((name, written[name]) for name in written)
    return {name: np.array(v) if isinstance(v, list) else v for name, v in values}


def first_to_solve(checkpoint: Checkpoint, new: Sequence[dict]) -> int | None:
    """Number of the step to begin, or None to go on inside the current one.

    new: the steps of the spec to go on with, as plain data; their names are part of them. Raises
    SpecError where it is no continuation.
    """
    k, old = checkpoint.step, checkpoint.spec["steps"]
    if list(old[:k]) != list(new[:k]) or len(new) <= k:
        raise SpecError(
            f"steps: the results were computed with other steps up to '{old[k]['name']}'; "
            "only what comes after may change"
        )
    if new[k] == old[k]:
        return k + 1 if checkpoint.step_done else None
    if not checkpoint.step_done:
        raise SpecError(
            f"steps.{k}: '{old[k]['name']}' was begun with other loads and is not finished; "
            "resume it as it was, then extend it"
        )
    return k  # extended: from where it ended to the new loads

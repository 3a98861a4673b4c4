"""At which pressure a region breaks, by three criteria: nominal stress, Cauchy stress, stretch.

In uniaxial tension the stresses say the same; where a wall is pulled in two directions they do not,
and which is right depends on the material. The largest principal value of each is held against what
the card bears (``softact.materials.breaking``). The peak at a re-entrant corner grows with every
refinement, so it decides nothing: the value that 0.1 % of the region's undeformed volume exceeds
does. The pressure at which the nodal peak gets there is told beside it.

Sheets are judged in the same way, each ply by the stress and stretch in its plane.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from softact.materials.breaking import breaking
from softact.materials.tensors import bounds, largest_eigenvalue, symmetric
from softact.measures.base import Measure, per_cavity, vector_columns
from softact.measures.pressure import PRESSURE
from softact.measures.sheet_failure import plies

if TYPE_CHECKING:
    from mpi4py import MPI

    from softact.bodies.solid import Solid
    from softact.materials.base import Material
    from softact.measures.snapshot import Snapshot

SHARE = 1e-3  # of the volume, which is above the percentile
ROUNDING = 1e-12  # of the largest value
STRESS_COLUMN = "principal_stress_p999_<region>_MPa"
NOMINAL_COLUMN = "principal_nominal_stress_p999_<region>_MPa"
STRETCH_COLUMN = "principal_stretch_p999_<region>"
PEAK_COLUMN = "principal_stress_peak_<region>_MPa"
PLACE_COLUMN = "failure_<region>_<xyz>_mm"
FAILURE_COLUMN = "failure_pressure_<region>_kPa"
#: By which column each criterion is judged. "Nominal" comes first in all that is told.
CRITERIA = {"nominal": NOMINAL_COLUMN, "cauchy": STRESS_COLUMN, "stretch": STRETCH_COLUMN}


def criterion_column(criterion: str) -> str:
    """Title of the failure pressure by one of ``CRITERIA``."""
    return FAILURE_COLUMN.replace("_<region>", f"_{criterion}_<region>")


def percentile(
    comm: MPI.Comm,
    tensors: np.ndarray,
    volumes: np.ndarray,
    places_of: Callable[[np.ndarray], np.ndarray],
) -> tuple[float, np.ndarray, tuple[int, int]]:
    """The largest eigenvalue that a ``SHARE`` of the volume exceeds, the place (3,) where it
    stands, and the process and the number there of that point.

    tensors: (n, 6), symmetric, at this process's points; volumes: (n,) of the points; places_of:
    gives the places (k, 3) of points by their numbers (k,). Eigenvalues are taken only where their
    bounds leave room for a doubt.
    """
    share = SHARE * sum(comm.allgather(float(volumes.sum())))
    low, high = bounds(tensors)
    least = low[_top(low, volumes, share)].min(initial=np.inf)
    open_ = np.flatnonzero(high >= least - ROUNDING * np.abs(high).max(initial=0.0))
    values = largest_eigenvalue(tensors[open_])
    first = _top(values, volumes[open_], share)
    numbers = open_[first]
    at = np.column_stack([np.full(len(numbers), comm.rank), numbers])
    mine = values[first], volumes[numbers], places_of(numbers), at
    parts = zip(*comm.allgather(mine), strict=True)
    values, volumes, places, at = (np.concatenate(part) for part in parts)
    chosen = _top(values, volumes, share)[-1]
    rank, number = map(int, at[chosen])
    return float(values[chosen]), places[chosen], (rank, number)


def exceeded(comm: MPI.Comm, values: np.ndarray, volumes: np.ndarray, share: float) -> float:
    """The value that this part of the whole volume exceeds. values, volumes: (n,) of the points of
    this process; not all processes may be without any."""
    wanted = share * sum(comm.allgather(float(volumes.sum())))
    first = _top(values, volumes, wanted)
    parts = zip(*comm.allgather((values[first], volumes[first])), strict=True)
    values, volumes = (np.concatenate(part) for part in parts)
    return float(values[_top(values, volumes, wanted)[-1]])


def _top(values: np.ndarray, volumes: np.ndarray, share: float) -> np.ndarray:
    """Numbers of the largest values, descending, that together have the volume ``share``."""
    some = max(64, len(values) // 100)
    while True:  # a share is small: rather the largest than to sort all
        first = _largest(values, some)
        order = first[np.argsort(-values[first], kind="stable")]
        above = np.cumsum(volumes[order])
        if len(first) == len(values) or above[-1] > share:
            return order[: np.searchsorted(above, share) + 1]
        some *= 8


def _largest(values: np.ndarray, some: int) -> np.ndarray:
    """Numbers, ascending, of at least so many of the largest values, with all that are as large as
    the least of them."""
    if some >= len(values):
        return np.arange(len(values))
    return np.flatnonzero(values >= np.partition(values, -some)[-some])


def of_region(title: str, region: str, regions: Sequence[str]) -> str:
    """A column's name for one of the regions; it is left out where there is one alone."""
    return title.replace("_<region>", "" if len(regions) == 1 else f"_{region}")


def _largest_pressure(columns: Mapping[str, float], names: Iterable[str]) -> float:
    """The pressure of the largest magnitude in a row, kPa; 0 in no row at all."""
    titles = per_cavity("pressure_<cavity>_kPa", dict.fromkeys(names, 0.0))
    return max((columns.get(title, 0.0) for title in titles), key=abs)


def reached(
    row: Mapping[str, float],
    previous: Mapping[str, float],
    column: str,
    limit: float,
    names: Iterable[str],
) -> float | None:
    """Pressure (kPa) at which a column reached a limit, linear between two rows; None before."""
    value, pressure = row[column], _largest_pressure(row, names)
    if value < limit:
        return None
    if column not in previous:
        return pressure
    before, start = previous[column], _largest_pressure(previous, names)
    return start + (limit - before) / (value - before) * (pressure - start)


Judged = tuple[dict[str, float], dict[str, np.ndarray]]
#: Of each criterion the process and, there, the number of the point that decides.
Chosen = Mapping[str, tuple[int, int]]


def _judged(
    comm: MPI.Comm,
    tensors: Mapping[str, np.ndarray],
    volumes: np.ndarray,
    places_of: Callable[[np.ndarray], np.ndarray],
    named: Callable[[str], str],
) -> tuple[dict[str, float], dict[str, np.ndarray], Chosen]:
    """Columns of stress and stretch of a part, the place (3,) of each of ``CRITERIA``, and the
    points that decide.

    tensors: of each criterion, (n, 6); of the stretch C. named: a title with the part's name.
    """
    found = {
        criterion: percentile(comm, values, volumes, places_of)
        for criterion, values in tensors.items()
    }
    columns, places = _told({c: (value, place) for c, (value, place, _) in found.items()}, named)
    return columns, places, {criterion: chosen for criterion, (_, _, chosen) in found.items()}


def _told(found: Mapping[str, tuple[float, np.ndarray]], named: Callable[[str], str]) -> Judged:
    """What ``_judged`` says of the values and places that decide."""
    columns = {
        named(STRESS_COLUMN): float(found["cauchy"][0]),
        named(NOMINAL_COLUMN): float(found["nominal"][0]),
        named(STRETCH_COLUMN): float(np.sqrt(found["stretch"][0])),
    }
    return columns, {criterion: place for criterion, (_, place) in found.items()}


def _tensors(snapshot: Snapshot, solid: Solid, cauchy: np.ndarray) -> dict[str, np.ndarray]:
    """What ``_judged`` judges in a solid with this Cauchy stress (cells, points, 3, 3)."""
    return {
        "nominal": solid.nominal(snapshot.state, cauchy),
        "cauchy": symmetric(cauchy),
        "stretch": solid.right_cauchy_green(snapshot.state.x).reshape(-1, 6),
    }


def _region(snapshot: Snapshot, name: str, solid: Solid, named: Callable[[str], str]) -> Judged:
    """See ``_judged``, of a region of solids; with the highest node."""
    if snapshot.decided is not None:
        return _region_beside(snapshot, name, solid, named, snapshot.decided.failure[name])
    comm = snapshot.model.comm
    tensors = _tensors(snapshot, solid, snapshot.cauchy_at_points(name))

    def places_of(chosen: np.ndarray) -> np.ndarray:
        return snapshot.quadrature_places(solid, chosen)

    columns, places, chosen = _judged(comm, tensors, solid.volumes.ravel(), places_of, named)
    snapshot.deciding.failure[name] = chosen
    return columns | {named(PEAK_COLUMN): _peak(snapshot, name)}, places


def _peak(snapshot: Snapshot, name: str) -> float:
    """The largest nodal stress of a region, MPa."""
    stress = snapshot.max_principal_stress[snapshot.model.parts.nodes[name]]
    return max(snapshot.model.comm.allgather(float(stress.max(initial=-np.inf))))


def _region_beside(
    snapshot: Snapshot, name: str, solid: Solid, named: Callable[[str], str], chosen: Chosen
) -> Judged:
    """``_region`` of a twin, at the points that decide in the actuator itself."""
    comm, criteria = snapshot.model.comm, list(chosen)
    mine = [criterion for criterion in criteria if chosen[criterion][0] == comm.rank]
    points = solid.volumes.shape[1]
    cells, point = np.divmod(np.array([chosen[c][1] for c in mine], int), points)
    part = solid.part(cells)
    at = np.arange(len(mine)) * points + point
    cauchy = part.cauchy(snapshot.state)
    tensors = _tensors(snapshot, part, cauchy)
    values = [largest_eigenvalue(tensors[c][i : i + 1])[0] for c, i in zip(mine, at, strict=True)]
    places = snapshot.quadrature_places(part, at)
    known = comm.allgather(dict(zip(mine, zip(values, places, strict=True), strict=True)))
    found = {criterion: every[criterion] for every in known for criterion in every}
    columns, where = _told({criterion: found[criterion] for criterion in criteria}, named)
    return columns | {named(PEAK_COLUMN): _peak(snapshot, name)}, where


@dataclass(frozen=True)
class Part:
    """A region or a ply in a state: its names in titles, material and ``_judged``."""

    named: Callable[[str], str]
    material: Material
    judged: Judged


def _parts(snapshot: Snapshot) -> Iterator[Part]:
    """All regions, then all plies of sheets. A name is left out of titles where a region, or in an
    actuator without any, a ply is the only one."""
    regions, comm = snapshot.layout.regions, snapshot.model.comm
    for name, solid in snapshot.model.solids.items():
        named = partial(of_region, region=name, regions=regions)
        yield Part(named, solid.material, _region(snapshot, name, solid, named))
    layers = list(plies(snapshot))
    names = (*regions, *(layer.name for layer in layers))
    for layer in layers:
        named = partial(of_region, region=layer.name, regions=names)
        columns, places, _ = _judged(comm, layer.tensors, layer.volumes, layer.places_of, named)
        yield Part(named, layer.material, (columns, places))


def _limits(material: Material) -> dict[str, tuple[str, float | None]]:
    """Title of each pressure -> the column that is judged, and the largest value it may have."""
    bears, card = breaking(material), material.card
    limits = {
        criterion_column(criterion): (column, getattr(bears, criterion))
        for criterion, column in CRITERIA.items()
    }
    return limits | {
        "failure_pressure_peak_<region>_kPa": (PEAK_COLUMN, bears.cauchy),
        "tested_stretch_pressure_<region>_kPa": (
            STRETCH_COLUMN,
            card.stretch_range and card.stretch_range[1],
        ),
    }


def _first(row: Mapping[str, float], named: Callable[[str], str]) -> tuple[str, float] | None:
    """The criterion that was reached first and its pressure, None where none was."""
    told = {
        criterion: row[title]
        for criterion in CRITERIA
        if (title := named(criterion_column(criterion))) in row
    }
    return min(told.items(), key=lambda item: abs(item[1])) if told else None


def _pressures(snapshot: Snapshot, part: Part, pressures: Mapping[str, float]) -> dict[str, float]:
    """Pressures at which a part has reached what it bears, and where it first did."""
    previous, names = snapshot.previous, tuple(snapshot.layout.cavities)
    found, places = part.judged
    columns: dict[str, float] = {}
    for title, (column, limit) in _limits(part.material).items():
        title, column = part.named(title), part.named(column)
        now = previous.get(title)
        if now is None and limit and column in found:
            now = reached({**found, **pressures}, previous, column, limit, names)
        if now is not None:
            columns[title] = now
    if first := _first(columns, part.named):
        criterion, pressure = first
        failed = part.named(FAILURE_COLUMN)
        columns[failed] = previous.get(failed, pressure)
        at = vector_columns(part.named(PLACE_COLUMN), places[criterion])
        columns |= {title: previous.get(title, value) for title, value in at.items()}
    return columns


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    pressures = PRESSURE.evaluate(snapshot)
    columns: dict[str, float] = {}
    safe = []
    for part in _parts(snapshot):
        columns |= part.judged[0]
        if not snapshot.layout.cavities or part.material.card is None:
            continue
        columns |= _pressures(snapshot, part, pressures)
        if (failed := part.named(FAILURE_COLUMN)) in columns:
            safe.append(columns[failed] / snapshot.safety_factor)
    if safe:
        columns["safe_pressure_kPa"] = min(safe, key=abs)
    return columns


FAILURE = Measure(
    "failure",
    "pressure at which a region or a ply of a sheet breaks: by nominal stress, by Cauchy stress "
    "and by stretch",
    {
        STRESS_COLUMN: "largest principal Cauchy stress, exceeded in 0.1 % of the region's volume",
        PEAK_COLUMN: "its largest nodal mean in the region; grows under refinement at corners",
        NOMINAL_COLUMN: "largest principal nominal stress (force per undeformed area), exceeded in "
        "0.1 % of the region's volume",
        STRETCH_COLUMN: "largest principal stretch, exceeded in 0.1 % of the region's volume",
        FAILURE_COLUMN: "pressure at which the region first reaches the strength or the stretch at "
        "break of its card, the smallest of the next three; empty before. Of several cavities the "
        "largest pressure counts",
        criterion_column("nominal"): "pressure at which the nominal stress reaches the card's "
        "strength",
        criterion_column("cauchy"): "pressure at which the Cauchy stress reaches what a bar of "
        "this law has at the card's strength",
        criterion_column("stretch"): "pressure at which the stretch reaches that at break, 1 + "
        "elongation of the card",
        "failure_pressure_peak_<region>_kPa": "as by the Cauchy stress, for its largest nodal mean",
        "tested_stretch_pressure_<region>_kPa": "pressure at which the stretch leaves the range in "
        "which the material was tested",
        **{
            f"failure_<region>_{c}_mm": f"undeformed {c} coordinate of where it first breaks"
            for c in "xyz"
        },
        "safe_pressure_kPa": "smallest failure pressure over the safety factor of the spec",
    },
    _evaluate,
)

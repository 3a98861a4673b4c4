"""At which pressure a region's largest principal stress and stretch reach what its card bears.

The peak at a re-entrant corner grows with every refinement, so it decides nothing: the stress that
0.1 % of the region's undeformed volume exceeds does. The pressure at which the nodal peak gets
there is told beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from softact.materials.tensors import bounds, largest_eigenvalue, symmetric
from softact.measures.base import Measure, per_cavity, vector_columns
from softact.measures.pressure import PRESSURE

if TYPE_CHECKING:
    from mpi4py import MPI

    from softact.bodies.solid import Solid
    from softact.measures.snapshot import Snapshot

SHARE = 1e-3  # of the volume, which is above the percentile
ROUNDING = 1e-12  # of the largest value
STRESS_COLUMN = "principal_stress_p999_<region>_MPa"
STRETCH_COLUMN = "principal_stretch_p999_<region>"
PEAK_COLUMN = "principal_stress_peak_<region>_MPa"
PLACE_COLUMN = "failure_<region>_<xyz>_mm"


def percentile(
    comm: MPI.Comm,
    tensors: np.ndarray,
    volumes: np.ndarray,
    places_of: Callable[[np.ndarray], np.ndarray],
) -> tuple[float, np.ndarray]:
    """The largest eigenvalue that a ``SHARE`` of the volume exceeds, and the place (3,) where it
    stands.

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
    mine = values[first], volumes[open_[first]], places_of(open_[first])
    parts = zip(*comm.allgather(mine), strict=True)
    values, volumes, places = (np.concatenate(part) for part in parts)
    chosen = _top(values, volumes, share)[-1]
    return float(values[chosen]), places[chosen]


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


def _name(title: str, region: str, regions: Sequence[str]) -> str:
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


def _region(snapshot: Snapshot, name: str, solid: Solid) -> tuple[dict[str, float], np.ndarray]:
    """Columns of stress and stretch of one region, and where the stress stands."""
    regions, comm = snapshot.layout.regions, snapshot.model.comm
    volumes = solid.volumes.ravel()
    stretches = solid.right_cauchy_green(snapshot.state.x).reshape(-1, 6)

    def places_of(chosen: np.ndarray) -> np.ndarray:
        return snapshot.quadrature_places(solid, chosen)

    stress, place = percentile(comm, symmetric(snapshot.cauchy_at_points(name)), volumes, places_of)
    squared, _ = percentile(comm, stretches, volumes, places_of)
    nodes = np.unique(snapshot.model.cell_nodes[solid.cells])
    peak = float(snapshot.max_principal_stress[nodes].max(initial=-np.inf))
    columns = {
        _name(STRESS_COLUMN, name, regions): stress,
        _name(PEAK_COLUMN, name, regions): max(comm.allgather(peak)),
        _name(STRETCH_COLUMN, name, regions): float(np.sqrt(squared)),
    }
    return columns, place


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    layout, previous = snapshot.layout, snapshot.previous
    names, regions = tuple(layout.cavities), layout.regions
    columns: dict[str, float] = {}
    pressures = PRESSURE.evaluate(snapshot)
    safe = []
    for name, solid in snapshot.model.solids.items():
        found, place = _region(snapshot, name, solid)
        columns |= found
        card = solid.material.card
        if not names or card is None:
            continue
        limits = {
            "failure_pressure_<region>_kPa": (STRESS_COLUMN, card.strength),
            "failure_pressure_peak_<region>_kPa": (PEAK_COLUMN, card.strength),
            "tested_stretch_pressure_<region>_kPa": (
                STRETCH_COLUMN,
                card.stretch_range and card.stretch_range[1],
            ),
        }
        for title, (column, limit) in limits.items():
            title, column = _name(title, name, regions), _name(column, name, regions)
            now = previous.get(title)
            if now is None and limit:
                now = reached(found | pressures, previous, column, limit, names)
            if now is not None:
                columns[title] = now
        failed = columns.get(_name("failure_pressure_<region>_kPa", name, regions))
        if failed is not None:
            safe.append(failed / snapshot.safety_factor)
            titles = vector_columns(_name(PLACE_COLUMN, name, regions), place)
            columns |= {title: previous.get(title, at) for title, at in titles.items()}
    if safe:
        columns["safe_pressure_kPa"] = min(safe, key=abs)
    return columns


FAILURE = Measure(
    "failure",
    "pressure at which the stress reaches the card's strength, and the stretch its tested range",
    {
        STRESS_COLUMN: "largest principal Cauchy stress, exceeded in 0.1 % of the region's volume",
        PEAK_COLUMN: "its largest nodal mean in the region; grows under refinement at corners",
        STRETCH_COLUMN: "largest principal stretch, exceeded in 0.1 % of the region's volume",
        "failure_pressure_<region>_kPa": "pressure at which the former reaches the strength; empty "
        "before. Of several cavities the largest pressure counts",
        "failure_pressure_peak_<region>_kPa": "the same for the largest nodal mean",
        "tested_stretch_pressure_<region>_kPa": "pressure at which the stretch leaves the range in "
        "which the material was tested",
        **{
            f"failure_<region>_{c}_mm": f"undeformed {c} coordinate of where it is reached"
            for c in "xyz"
        },
        "safe_pressure_kPa": "smallest failure pressure over the safety factor of the spec",
    },
    _evaluate,
)

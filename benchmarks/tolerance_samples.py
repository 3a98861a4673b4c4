"""Samples of a tolerance sweep at their last state alone, each found from the actuator of the spec.

    .venv/bin/python -m benchmarks.tolerance_samples SWEEP CACHE [--set PATH=VALUE]...

SWEEP: a file with the design ``tolerances``. Its points are those of ``softact sweep``; each starts
from the nearest one that is there and the derivatives there, in place of going through all states,
the first from the spec as it is.
Prints mean and standard deviation of all measures that vary, beside those to first order, and how
much work a run was. Samples that are kept in CACHE are not computed again.
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from softact.files import document
from softact.results.folder import COMPLETE, read
from softact.spec import spec_at
from softact.spec.overrides import apply
from softact.sweep.cache import Cache
from softact.sweep.compute import Answer, compute
from softact.sweep.points import changes_of
from softact.sweep.record import Record
from softact.sweep.spec import Sweep
from softact.sweep.spec import read as read_sweep
from softact.sweep.version import run_key
from softact.tolerances.causes import causes, paths
from softact.tolerances.first_order import scatter


def nominal(base: document.Document, cache: Cache) -> Answer:
    """The run of the spec as it is, with all of its states and the derivatives."""
    spec = spec_at(base)
    slopes = paths(causes(spec))
    return compute(spec, run_key(spec, slopes=slopes), cache, slopes=slopes)


def sample(base: document.Document, changes: Any, cache: Cache, near: Path) -> Record:
    """One actuator, from the run of another."""
    spec, slopes = spec_at(base, changes), paths(causes(spec_at(base)))
    key = run_key(spec, slopes=slopes, end_only=True)
    answer = compute(spec, key, cache, slopes=slopes, end_only=True, near=near)
    if answer.record is None or answer.record.status != COMPLETE:
        sys.exit(f"a sample is not complete: {answer.cause}")
    return answer.record


def work(folder: Path) -> tuple[int, int, float]:
    """States, factorisations and seconds of the solver of a run."""
    run = json.loads((folder / "run.json").read_text())
    return run["counts"]["increments"], run["counts"]["factorisations"], run["times_s"]["solve"]


def tell(base: document.Document, folder: Path, samples: list[Record]) -> None:
    """Means and standard deviations, to first order and of the samples."""
    results = read(folder)
    last = len(results.increments) - 1
    for of in scatter(results, causes(spec_at(base))):
        values = np.array([found.measures.get(of.measure, np.nan) for found in samples])
        if of.row == last and of.deviation and np.isfinite(values).all():
            mean, deviation = values.mean(), values.std(ddof=1)
            print(
                f"{of.measure}: {of.mean:.5g} ± {of.deviation:.4g} to first order, {mean:.5g} ± "
                f"{deviation:.4g} in {len(samples)} samples: {mean / of.mean - 1:+.1%}, "
                f"{deviation / of.deviation - 1:+.1%}"
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sweep", type=Path)
    parser.add_argument("cache", type=Path)
    parser.add_argument("--set", action="append", default=[])
    given = parser.parse_args()
    wanted, base = read_sweep(given.sweep, Sweep)
    apply(base, given.set)
    cache = Cache(given.cache)
    first = nominal(base, cache)
    folder = cache.folder(first.key)
    print("the spec as it is: states, factorisations, s:", *work(folder), flush=True)
    ends = {axis.title: [float(axis.number(end)) for end in (axis.from_, axis.to)]
            for axis in wanted.axes}  # fmt: skip
    points = [
        (np.array([(float(axis.number(c[axis.title])) - low) / (high - low) - 0.5
                   for axis, (low, high) in zip(wanted.axes, ends.values(), strict=True)]), c)
        for c in wanted.design.points(wanted.axes)
    ]  # fmt: skip
    there, samples = [(np.zeros(len(wanted.axes)), folder)], []
    for place, coordinates in sorted(points, key=lambda point: float(np.linalg.norm(point[0]))):
        _, near = min(there, key=lambda known: float(np.linalg.norm(known[0] - place)))
        samples.append(sample(base, changes_of(wanted.axes, coordinates), cache, near))
        there.append((place, cache.folder(samples[-1].key)))
        print(len(samples), *work(there[-1][1]), flush=True)
    tell(base, folder, samples)


if __name__ == "__main__":
    main()

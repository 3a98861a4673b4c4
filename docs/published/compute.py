"""Computes the runs behind the page, one at a time; finished ones are in a sweep's cache."""

from __future__ import annotations

import signal
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from published.figures import ROOT, Figure, Run
from published.results import FAILED, STOPPED, Outcome, asked
from softact.errors import SpecError
from softact.sweep.cache import Cache
from softact.sweep.compute import compute
from softact.sweep.points import spec_at
from softact.sweep.version import WITHOUT_EFFECT, run_key

_QUIET = {"capture_output": True, "text": True}


class TooLongError(Exception):
    """A run has taken longer than it may."""


class _Curve:
    """The states of a run as they come: what remains of one that is stopped."""

    def __init__(self, told: Callable[[str], None]):
        self.rows: list[dict[str, float]] = []
        self.told, self.size = told, {}

    def __call__(self, event: dict[str, Any]) -> None:
        if event["stage"] == "solve":
            self.size = {name: event[name] for name in ("cells", "unknowns")}
            self.told(f"{event['cells']} tetrahedra, {event['unknowns']} unknowns")
        if event["stage"] == "increment":
            self.rows.append({k: float(v) for k, v in event.items() if _number(v)})
            self.told(f"{event['step']} {event['fraction']:.1%}")

    def table(self) -> tuple[list[str], np.ndarray]:
        """(c,) columns and (n, c) values; NaN where a state lacks one."""
        columns = list(dict.fromkeys(name for row in self.rows for name in row))
        table = [[row.get(name, np.nan) for name in columns] for row in self.rows]
        return columns, np.array(table, float).reshape(len(self.rows), len(columns))


def outcome_of(
    run: Run,
    figures: Sequence[Figure],
    cache: Cache,
    limit: float,
    told: Callable[[str], None] = lambda line: None,
) -> Outcome:
    """Compute a run unless the cache has it, and read its figures off.

    limit: seconds of wall time after which it is stopped; its figures are then read off what it
    had reached. Raises SpecError where the spec is wrong.
    """
    spec = spec_at(run.base(), run.changes)
    curve, started = _Curve(told), time.perf_counter()
    about = {"input": run.fingerprint(), "commit": commit()}
    try:
        with _within(limit):
            answer = compute(spec, run_key(spec), cache, progress=curve)
    except TooLongError:
        columns, table = curve.table()
        about |= {"status": STOPPED, "cause": f"by us after {limit:g} s", **curve.size}
        return Outcome(
            **about, seconds=round(limit), readings=readings(figures, columns, table, run)
        )
    found = answer.record
    if found is None:
        seconds = round(time.perf_counter() - started)
        return Outcome(**about, status=FAILED, cause=answer.cause, seconds=seconds, **curve.size)
    return Outcome(
        **about,
        status=found.status,
        cause=found.cause,
        seconds=round(found.seconds),
        cells=found.cells,
        unknowns=found.unknowns,
        readings=readings(figures, found.columns, found.table, run),
    )


def readings(
    figures: Sequence[Figure], columns: Sequence[str], table: np.ndarray, run: Run
) -> dict[str, dict[str, Any]]:
    """Figure -> how it was read and what was found. Raises SpecError for an unknown column."""
    found = {}
    for figure in figures:
        if not len(table):
            continue
        try:
            found[figure.id] = {"read": asked(figure), **figure.read.of(columns, table)}
        except KeyError as error:
            raise SpecError(f"{figure.id}: {error.args[0]} in the run of {run.spec}") from None
    return found


def commit() -> str:
    """Short hash of the last commit that touched what makes the numbers; + where files differ.

    Only what makes numbers counts, so that the hash outlives a rebase of other work.
    """
    sources = ["softact", "geometries", *(f":!softact/{name}" for name in WITHOUT_EFFECT)]

    def git(*words: str) -> str:
        done = subprocess.run(["git", *words, "--", *sources], cwd=ROOT, **_QUIET)
        return done.stdout.strip()

    return git("log", "-1", "--format=%h") + ("+" if git("status", "--porcelain") else "")


@contextmanager
def _within(seconds: float) -> Iterator[None]:
    def ring(number, frame):
        raise TooLongError

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)

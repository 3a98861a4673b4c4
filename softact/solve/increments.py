"""How long the next increment is, after one that was accepted and after one that failed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Increments:
    """easy, hard: Newton counts that let the increment grow, and beyond which it shrinks; growth,
    shrink: by how much. cut: part that is kept after a failure. small: part of the largest
    increment below which an accepted one always grows, by recovery at least, and by leap where it
    took no more than swift: it had been cut for a place that has been passed. Measured on the
    benchmark's finger (docs/performance.md) and on the glove's (docs/contact.md)."""

    easy: int = 5
    hard: int = 8
    growth: float = 1.6
    shrink: float = 0.7
    cut: float = 0.4
    small: float = 0.1
    recovery: float = 1.25
    swift: int = 2
    leap: float = 4.0


INCREMENTS = Increments()


def next_size(size: float, iterations: int, largest: float) -> float:
    """Increment after one that was accepted.

    A small one does not shrink for its many iterations: where they converge slowly in themselves
    (a follower pressure on an open face) no increment would be small enough.
    """
    factor = growth(iterations)
    if size < INCREMENTS.small * largest:
        swift = iterations <= INCREMENTS.swift
        factor = max(factor, INCREMENTS.leap if swift else INCREMENTS.recovery)
    return min(largest, size * factor)


def growth(iterations: int) -> float:
    """Factor for the next increment after so many iterations."""
    if iterations <= INCREMENTS.easy:
        return INCREMENTS.growth
    return 1.0 if iterations <= INCREMENTS.hard else INCREMENTS.shrink

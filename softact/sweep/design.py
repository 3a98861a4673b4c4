"""Which points of the axes are computed: grid, one at a time, or a sample of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from softact.sweep.axes import Axis

MOST_POINTS = 100_000
TOLERANCES = "tolerances"
Coordinates = dict[str, Any]  # axis's title -> value; an axis that is left out has the base's


class Design(BaseModel):
    """How the points are chosen."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    kind: Literal["grid", "one_at_a_time", "latin_hypercube", "sobol", "tolerances"] = Field(
        "grid",
        description="of all values, around the base, a sample of the ranges, or a Latin hypercube "
        "of the base's tolerances",
    )
    samples: int = Field(32, ge=1, le=MOST_POINTS, description="points of a sample")
    seed: int = Field(
        0, ge=0, lt=2**32, description="of a sample; the same seed gives the same points"
    )

    def count(self, axes: Sequence[Axis]) -> int:
        """The number of points, or a little more where points would be twice the same."""
        if self.kind == "grid":
            return math.prod(axis.size for axis in axes)
        if self.kind == "one_at_a_time":
            return 1 + sum(axis.size for axis in axes)
        return self.samples

    def points(self, axes: Sequence[Axis]) -> list[Coordinates]:
        """The points, each once; the base itself is the first of one_at_a_time."""
        if self.kind == "grid":
            steps = [axis.steps() for axis in axes]
            return [_named(axes, values) for values in product(*steps)]
        if self.kind == "one_at_a_time":
            moved = [{axis.title: value} for axis in axes for value in axis.steps()]
            return [{}, *moved]
        return sampled(axes, self._fractions(len(axes)))

    def _fractions(self, dimensions: int) -> np.ndarray:
        """(samples, dimensions) numbers in [0, 1)."""
        from scipy.stats import qmc

        if self.kind in ("latin_hypercube", TOLERANCES):
            return qmc.LatinHypercube(dimensions, seed=self.seed).random(self.samples)
        import warnings

        with warnings.catch_warnings():
            # Sobol points are balanced for powers of two only; any number is a fair sample.
            warnings.filterwarnings("ignore", message="The balance properties")
            return qmc.Sobol(dimensions, seed=self.seed).random(self.samples)


def sampled(axes: Sequence[Axis], fractions: np.ndarray) -> list[Coordinates]:
    """Points at (n, axes) fractions of the axes."""
    columns = [
        axis.at([float(f) for f in fractions[:, number]]) for number, axis in enumerate(axes)
    ]
    return [_named(axes, values) for values in zip(*columns, strict=True)]


def _named(axes: Sequence[Axis], values: Sequence[Any]) -> Coordinates:
    return {axis.title: value for axis, value in zip(axes, values, strict=True)}

"""The published figures, the runs that give softact's, and how a figure is read off a run.

``figures.yaml`` holds them: for each source its runs (a spec of the repository and what replaces
values of it, as in ``softact run --set``) and its figures.
"""

from __future__ import annotations

import hashlib
import json
import operator
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from softact.files import document
from softact.spec import Spec, opened
from softact.spec.faults import validated
from softact.spec.path import assign

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
DATA = HERE / "figures.yaml"

BOUNDS = {
    "at_least": ("≥", operator.ge),
    "at_most": ("≤", operator.le),
    "above": (">", operator.gt),
    "below": ("<", operator.lt),
}
# Keys of a spec that change no number of its run.
_TEXTS = ("name", "description", "source", "assumptions")
#: Kinds of rows, which are never mixed: what softact stands beside.
TEST, MODEL, CLAIM, AIM, DRAWN = "test", "model", "claim", "aim", "drawn"


class Strict(BaseModel):
    """Plain data that takes no other field than its own."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Run(Strict):
    """A run: ``spec`` relative to the repository, ``set`` as of ``--set``: path -> value.

    large: why it is computed only where it is named.
    """

    spec: str
    set: dict[str, Any] = {}
    assumes: str = ""
    large: str = ""

    def base(self) -> document.Document:
        """The spec's file as plain data."""
        return opened(ROOT / self.spec)

    @property
    def changes(self) -> tuple[tuple[str, Any], ...]:
        """(path, value) of each replaced value, for ``softact.spec.spec_at``."""
        return tuple(self.set.items())

    def fingerprint(self) -> str:
        """16 hexadecimal digits of all that is written for this run and makes its numbers."""
        base = self.base()
        for path, value in self.changes:
            assign(base, path, value, path, Spec)
        data = {key: value for key, value in base.data.items() if key not in _TEXTS}
        return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]

    def command(self) -> str:
        """The command that computes it."""
        words = [f"softact run {self.spec}"]
        for path, value in self.set.items():
            text = value if isinstance(value, str) else json.dumps(value).replace('"', "")
            words.append(f"--set {path}='{text}'" if " " in text else f"--set {path}={text}")
        return " ".join(words)


class Reading(Strict):
    """The value of a column where another one first has the value in ``at``; else the last one.

    column: a name, or several with " + " between them for their sum. scale: factor on it, for other
    units.
    """

    column: str
    at: dict[str, float] = Field({}, max_length=1)
    scale: float = 1.0

    @property
    def summands(self) -> list[str]:
        """Names of the columns that are added up."""
        return self.column.split(" + ")

    def of(self, columns: Sequence[str], table: np.ndarray) -> dict[str, Any]:
        """Read it off a curve. columns: (c,) names, table: (n, c), a row per equilibrium.

        ``value``: linear between equilibria, None where the run ended before; then ``last`` says
        what both columns had at the end. Raises KeyError where a column is not there.
        """
        missing = [name for name in (*self.summands, *self.at) if name not in columns]
        if missing:
            raise KeyError(f"no column {missing[0]}")
        curve = sum(table[:, list(columns).index(name)] for name in self.summands) * self.scale
        if not self.at:
            return {"value": _plain(curve[-1])}
        ((name, wanted),) = self.at.items()
        along = table[:, list(columns).index(name)]
        for i in range(len(along)):
            if abs(along[i] - wanted) <= 1e-9 * max(abs(wanted), 1.0):
                return {"value": _plain(curve[i])}
            if i + 1 < len(along) and (along[i] - wanted) * (along[i + 1] - wanted) < 0:
                part = (wanted - along[i]) / (along[i + 1] - along[i])
                return {"value": _plain(curve[i] + part * (curve[i + 1] - curve[i]))}
        return {"value": None, "last": [_plain(along[-1]), _plain(curve[-1])]}


class Figure(Strict):
    """A published figure: a number (``value``), a bound, a trend over several runs, or a picture
    (``kind: drawn``) whose text gives none of these.

    what, where: what it is, and the place in the source. said: the source's words where they are
    no number. kind: how the source got it. variant_of: the figure that this one is, computed under
    another assumption; differs: in what. cause: why softact's number is off, or that this is not
    known.
    """

    id: str
    what: str
    where: str
    unit: str = ""
    value: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    above: float | None = None
    below: float | None = None
    trend: Literal["rises", "falls", "peak"] | None = None
    said: str = ""
    kind: Literal["measured", "computed", "aimed at", "drawn"]
    runs: tuple[str, ...] = Field(min_length=1)
    read: Reading
    assumes: str = ""
    variant_of: str = ""
    differs: str = ""
    cause: str = ""

    @model_validator(mode="after")
    def _one_claim(self) -> Figure:
        bounds = [name for name in BOUNDS if getattr(self, name) is not None]
        claims = len(bounds) + (self.value is not None) + (self.trend is not None)
        if self.kind == "drawn":
            if claims:
                raise ValueError(f"{self.id}: a picture has no number; it was measured or computed")
            return self
        if claims != 1:
            raise ValueError(f"{self.id}: one of value, {', '.join(BOUNDS)}, trend, not {claims}")
        if (self.trend is None) != (len(self.runs) == 1):
            raise ValueError(f"{self.id}: a trend is over several runs, all else over one")
        return self

    @property
    def row(self) -> str:
        """The kind of its row: a number that was measured is a test, a computed one the source's
        model, what is no number a claim, what is a picture alone drawn."""
        if self.kind in ("aimed at", "drawn"):
            return AIM if self.kind == "aimed at" else DRAWN
        if self.value is None:
            return CLAIM
        return TEST if self.kind == "measured" else MODEL

    @property
    def published(self) -> tuple[Any, ...]:
        """What the source says, which variants of a figure have in common."""
        bounds = (getattr(self, name) for name in BOUNDS)
        return (self.kind, self.unit, self.value, self.trend, *bounds)

    @property
    def bound(self) -> str | None:
        """Name of the bound, None where it is a number or a trend."""
        return next((name for name in BOUNDS if getattr(self, name) is not None), None)

    def holds(self, values: Sequence[float]) -> bool:
        """Whether softact's values, one for each run, are as the bound or the trend says."""
        if self.bound:
            return BOUNDS[self.bound][1](values[0], getattr(self, self.bound))
        steps = np.diff(values)
        if self.trend == "peak":
            return max(values) > max(values[0], values[-1])
        return bool(np.all(steps > 0) if self.trend == "rises" else np.all(steps < 0))


class Source(Strict):
    """A paper or data set with its runs and figures."""

    name: str
    source: str
    remark: str = ""
    runs: dict[str, Run]
    figures: tuple[Figure, ...]

    @model_validator(mode="before")
    @classmethod
    def _with_variants(cls, data: Any) -> Any:
        """``also`` of a figure: the same figure of other runs, each with what differs."""
        if not isinstance(data, dict) or not isinstance(data.get("figures"), list):
            return data
        figures = []
        for figure in data["figures"]:
            also = figure.get("also", []) if isinstance(figure, dict) else []
            own = {k: v for k, v in figure.items() if k != "also"} if also else figure
            figures.append(own)
            for number, other in enumerate(also, 1):
                said = {"id": f"{own['id']}_also_{number}", "variant_of": own["id"]}
                figures.append({**own, "assumes": "", "cause": "", **said, **other})
        return {**data, "figures": figures}

    @property
    def groups(self) -> list[tuple[Figure, ...]]:
        """Each figure with its variants after it."""
        own = {figure.id: [figure] for figure in self.figures if not figure.variant_of}
        for figure in self.figures:
            if figure.variant_of:
                own[figure.variant_of].append(figure)
        return [tuple(group) for group in own.values()]


class _File(Strict):
    sources: tuple[Source, ...]


def read(path: Path = DATA) -> tuple[Source, ...]:
    """All sources. Raises ValueError where names are used twice or lead nowhere."""
    sources = validated(document.read(path), _File).sources
    runs = [name for source in sources for name in source.runs]
    figures = [figure.id for source in sources for figure in source.figures]
    for names in (runs, figures):
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"{path.name}: used twice: {', '.join(twice)}")
    for source in sources:
        for figure in source.figures:
            unknown = [name for name in figure.runs if name not in source.runs]
            if unknown:
                raise ValueError(f"{figure.id}: there is no run {unknown[0]} of {source.name}")
        check_variants(source)
    return sources


def check_variants(source: Source) -> None:
    """Raises ValueError where a variant leads nowhere or is of another published figure."""
    known = {figure.id: figure for figure in source.figures if not figure.variant_of}
    for figure in source.figures:
        if not figure.variant_of:
            continue
        if figure.variant_of not in known:
            raise ValueError(f"{figure.id}: there is no figure {figure.variant_of}")
        if figure.published != known[figure.variant_of].published:
            raise ValueError(f"{figure.id}: {figure.variant_of} is published otherwise")
        if not figure.differs:
            raise ValueError(f"{figure.id}: say in what it differs from {figure.variant_of}")


def _plain(number: float) -> float | None:
    return float(f"{number:.6g}") if np.isfinite(number) else None

"""What an exporter gets: the model, its deviations, what is assumed."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from softact.export import errors, reduced, statement
from softact.export.chain import Chain, chain_of
from softact.export.errors import Deviation
from softact.results.folder import Results

DAMPING_RATIO = 0.1


@dataclass(frozen=True)
class Job:
    """A model that is to be written.

    seen, unseen: its deviations, see ``errors``. damping_ratio: of critical, assumed.
    """

    model: reduced.Reduced
    seen: list[Deviation]
    unseen: statement.Unseen
    damping_ratio: float = DAMPING_RATIO
    about: list[str] = field(default_factory=list)

    @property
    def name(self) -> str:
        """Of the files, an identifier of Python and C."""
        return re.sub(r"\W", "_", f"_{self.model.data['name']}").lstrip("_0123456789") or "actuator"

    @property
    def chain(self) -> Chain:
        """The model as links and joints."""
        return chain_of(self.model, self.damping_ratio)


def prepare(
    runs: Sequence[Results], pieces: int | None = None, damping_ratio: float = DAMPING_RATIO
) -> Job:
    """Fit a model to runs and compare it with them. Raises SpecError."""
    model = reduced.fit(runs, pieces)
    seen, unseen = errors.against(model, model.states), errors.unseen(model)
    about = statement.lines(model, seen, unseen, damping_ratio)
    return Job(model, seen, unseen, damping_ratio, about)

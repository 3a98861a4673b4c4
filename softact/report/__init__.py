"""report.html and the pictures of a result folder, from the files in the folder alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from softact.report.base import Section
    from softact.results.folder import Results
    from softact.verdict.judge import Verdict

__all__ = ["Extra", "write_report"]

#: Makes a further section of the report from the results.
Extra = Callable[["Results"], "Section"]


def write_report(
    directory: str | Path,
    extra: Sequence[Extra] = (),
    warn: Callable[[str], None] = lambda line: None,
    verdict: Verdict | None = None,
) -> Path:
    """(Re)build report.html, curve.png, states.png and shape.png; returns the report's path.

    extra: further sections; where one raises SpecError, the report says so in its place. Measured
    curves that stand in the folder (``remembered``) have one of their own. warn: called with each
    line that the report has on what is missing or damaged. verdict: on the run, where it has just
    been judged; one without the places that it speaks of is made anew.

    A picture or 3-D view that cannot be made does not stop the rest: the report says which is
    missing and why. Raises SpecError where the folder is not a result folder, DamagedResultError
    where its figures cannot be read.
    """
    # Imported here: a sweep takes a label or a plot from this package, and makes no report.
    from softact.report.making import Report

    with Report(Path(directory)) as report:
        return report.write(extra, warn, verdict)

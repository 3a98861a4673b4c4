"""softact from Python: ``import softact``, and the names of ``NAMES``.

    import softact

    finger = softact.load("finger.yaml")
    sheet = softact.run(finger.with_({"geometry.wall": "1.2 mm"}))
    sheet.curve.plot("pressure_chambers_kPa", "bending_angle_deg")

The command line has the same functions behind it, so that a run from Python is that of ``softact
run``: same folder, same figures, same messages. Errors are ``softact.SoftactError`` with one line
for each fault in ``lines``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from softact.errors import SoftactError, SpecError
from softact.results import folder as result_folder
from softact.results.own_folder import Output, check_results
from softact.spec import Spec, loads
from softact.spec import load as load_spec
from softact.verdict.judge import Verdict, judge

if TYPE_CHECKING:
    import pandas
    import pyvista

    from softact.fit.fit import Fit
    from softact.results.folder import Results

#: What ``import softact`` offers.
NAMES = (
    "DataSheet",
    "SoftactError",
    "Spec",
    "fit",
    "load",
    "loads",
    "read",
    "run",
    "sweep",
)

__all__ = [*NAMES]


class DataSheet:
    """What a run has found: its folder, read when a part is asked for.

    directory: the folder, which holds the same as after ``softact run``.
    """

    def __init__(self, directory: str | Path) -> None:
        self.directory = Path(directory)

    def __repr__(self) -> str:
        return f"<DataSheet {self.directory}: {self.verdict.cell}>"

    @cached_property
    def results(self) -> Results:
        """All that is in the folder as numpy arrays: mesh, surfaces, states.

        Raises SpecError where the folder is none of softact's, DamagedResultError where its figures
        cannot be read.
        """
        return result_folder.read(self.directory)

    @property
    def status(self) -> str:
        """ "complete", "no_equilibrium" or "incomplete"."""
        return self.results.status

    @cached_property
    def verdict(self) -> Verdict:
        """Whether to trust it: ``colour`` green, amber or red, and ``reasons``."""
        return judge(self.results)

    @property
    def spec(self) -> Spec:
        """The resolved spec of the run. Raises DamagedResultError where it cannot be read."""
        if self.results.spec_faults:
            raise result_folder.DamagedResultError(*self.results.spec_faults)
        return loads(self.results.spec_yaml, str(self.directory / result_folder.SPEC))

    @property
    def summary(self) -> dict[str, float | str]:
        """Key figures at the last state: column of summary.csv -> number or text."""
        return dict(self.results.summary)

    @cached_property
    def curve(self) -> pandas.DataFrame:
        """A row for each state; the columns of curve.csv, whose names end with their units.

        Raises SoftactError where pandas is not installed.
        """
        return _pandas().DataFrame(dict(self.results.curve))

    @cached_property
    def sensitivities(self) -> pandas.DataFrame:
        """A row for each state, measure and parameter; the columns of sensitivities.csv. Empty
        where the run had none.

        Raises SoftactError where pandas is not installed.
        """
        return self._table(result_folder.SENSITIVITIES)

    @cached_property
    def tolerances(self) -> pandas.DataFrame:
        """A row for each state and measure; the columns of tolerances.csv. Empty where the spec has
        no tolerances.

        Raises SoftactError where pandas is not installed.
        """
        return self._table(result_folder.TOLERANCES)

    @cached_property
    def along(self) -> pandas.DataFrame:
        """A row for each state and place on the undeformed axis: curvature, twist and stretch there
        (``softact.results.along.COLUMNS``). Empty for an actuator without an axis.

        Raises SoftactError where pandas is not installed, DamagedResultError where the fields
        cannot be read.
        """
        from softact.results.along import along, rows

        found = along(self.results)
        return _pandas().DataFrame([] if found is None else rows(self.results, found))

    def _table(self, name: str) -> pandas.DataFrame:
        path, pandas = self.directory / name, _pandas()
        return pandas.read_csv(path) if path.is_file() else pandas.DataFrame()

    def fields(self, number: int = -1) -> pyvista.UnstructuredGrid:
        """State ``number`` (row of ``curve``, the last by default) as a grid of pyvista.

        The grid has the mesh at rest, mm; ``point_data`` and ``cell_data`` hold the fields under
        the names and units of fields.h5, "displacement" (n, 3) in mm among them:
        ``grid.warp_by_vector("displacement")`` is the deformed shape. Raises IndexError where there
        is no such state, DamagedResultError where the fields cannot be read.
        """
        from softact.results.grid import grid

        return grid(self.results, range(len(self.results.increments))[number])

    def report(self) -> Path:
        """Write report.html and its pictures anew; returns the path of the page."""
        from softact.report import write_report

        return write_report(self.directory)


def load(path: str | Path, changes: Mapping[str, Any] | None = None) -> Spec:
    """Read a spec from a YAML file; ``changes`` (dotted path -> value) win over the file.

    Values have the units that YAML would have: ``{"steps.inflate.pressure": "30 kPa"}``. Raises
    SpecError with one line for each fault.
    """
    return load_spec(path, [f"{place}={value}" for place, value in (changes or {}).items()])


def run(
    spec: Spec | str | Path,
    directory: str | Path | None = None,
    *,
    processes: int | None = None,
    resume: bool = False,
    report: bool = True,
    force: bool = False,
    progress: Callable[[Mapping[str, Any]], None] | None = None,
    sensitivities: bool | Sequence[str] = False,
) -> DataSheet:
    """Solve a spec, or the spec in a file, and return its data sheet.

    directory: for the results, by default ``results/<name of the spec>``; results in it are
    replaced, other files only with ``force``. processes: MPI processes, by default the cores, up to
    two. resume: go on with the run in the folder from its last state. report: whether report.html
    and pictures are made, too. progress: called with each event of the run, a mapping with "stage".
    sensitivities: True, or paths such as "geometry.wall": all measures are differentiated by all
    numbers of the spec, or by these, see ``DataSheet.sensitivities``.

    A run that finds no equilibrium returns what it reached: see ``status`` and ``verdict``. Raises
    SpecError before anything is written, and the other errors of ``softact.run.start.run``.
    """
    from softact.run import start

    found = spec if isinstance(spec, Spec) else load(spec)
    folder = Path("results") / found.name if directory is None else Path(directory)
    check_results(folder, force, reads=[] if isinstance(spec, Spec) else [Path(spec)])
    start.run(
        found,
        folder,
        processes=processes or start.usual_processes(found),
        progress=progress,
        report=report,
        resume=resume,
        sensitivities=_paths(sensitivities),
    )
    return DataSheet(folder)


def _paths(sensitivities: bool | Sequence[str]) -> Sequence[str] | None:
    """As ``softact.run.start.run`` takes them."""
    if isinstance(sensitivities, bool):
        return () if sensitivities else None
    return sensitivities or None


def read(directory: str | Path) -> DataSheet:
    """The data sheet in a result folder of an earlier run, finished or not.

    Raises SpecError where the folder is none of softact's, DamagedResultError where its figures
    cannot be read.
    """
    sheet = DataSheet(directory)
    sheet.results  # noqa: B018  (read now, so that a wrong folder is told where it is named)
    return sheet


def sweep(
    path: str | Path,
    directory: str | Path | None = None,
    *,
    jobs: int = 1,
    cache: str | Path | None = None,
    force: bool = False,
) -> pandas.DataFrame:
    """Compute all points of a sweep file, ``jobs`` at a time; a row for each, as in sweep.csv.

    What was computed before, here or by ``softact sweep``, is taken from the cache. Raises
    SpecError with one line for each fault of the file, SoftactError where pandas is missing.
    """
    from softact.sweep import output as files
    from softact.sweep.cache import DEFAULT, Cache
    from softact.sweep.spec import Sweep
    from softact.sweep.spec import read as read_study
    from softact.sweep.study import locally, open_study

    frames = _pandas()
    study, base = read_study(Path(path), Sweep)
    folder = Path("results") / study.name if directory is None else Path(directory)
    reads, kept = [Path(path), Path(base.name)], "the runs are kept in the cache"
    output = Output(folder, "sweep", force, reads, kept)
    output.check(files.FILES)
    opened = open_study(study, base, Cache(Path(cache or DEFAULT)), folder / files.PLAN)
    with output.opened(files.FILES):
        rows, _, _ = files.carry_out(
            opened, locally(jobs), None, output, lambda point, answer: None
        )
    return frames.DataFrame(rows)


def fit(
    *data: str | Path,
    law: str = "yeoh",
    directory: str | Path = "results/fit",
    name: str | None = None,
    force: bool = False,
    tell: Callable[[str], None] = lambda line: None,
    **reading: Any,
) -> list[Fit]:
    """Fit a law ("all" for every one) to tests and return the fits, the best first.

    data: as for ``softact fit``: "uni.csv", "sheet.csv:planar", or a YAML file of tests. reading:
    how the files are read, such as ``columns`` and ``sheet``. Card, plot, numbers and page are
    written into the folder under ``name``, by default the first file's. tell: called with each line
    that the command would print. The law of a fit is ``fit.candidate.make(fit.vector)``.

    Raises SpecError with one line for each fault.
    """
    from softact.fit.run import Request
    from softact.fit.run import run as fit_all
    from softact.fit.sheet import TestSheet, sheets_from_argument

    if not data:
        raise SpecError("fit: name a file of test data")
    if unknown := reading.keys() - TestSheet.model_fields:
        raise SpecError(f"fit: there is no option {', '.join(map(repr, sorted(unknown)))}")
    sheets = [sheet for entry in data for sheet in sheets_from_argument(str(entry), reading)]
    return fit_all(Request(sheets, law, Path(directory), name or sheets[0].file.stem, force), tell)


def _pandas() -> Any:
    try:
        import pandas
    except ImportError:
        raise SoftactError(
            "tables need pandas, which is not installed: pip install pandas"
        ) from None
    return pandas

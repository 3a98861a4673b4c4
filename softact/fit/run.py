"""``softact fit`` from arguments to files: read, fit, tell, write."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from softact.errors import SpecError
from softact.files import write_atomic
from softact.fit.candidates import Candidate, chosen
from softact.fit.card import card_text, numbers
from softact.fit.data import Test, read_tests
from softact.fit.fit import Fit, Options, fit, ranked
from softact.fit.page import html
from softact.fit.plausible import warnings
from softact.fit.plot import write_plot
from softact.fit.sheet import TestSheet
from softact.fit.tell import tell_comparison, tell_fit, tell_ranking, tell_tests
from softact.materials import Law, load_card, parse_material
from softact.output import Output
from softact.spec.card_files import is_file, read_card
from softact.units import dimension_of

SUFFIXES = (".yaml", ".png", ".json", ".html")  # of card, plot, numbers and page


@dataclass(frozen=True)
class Request:
    """What to fit and what to write. density: tonne/mm³; strength: MPa; None where not given.
    force: write into the folder whatever it holds."""

    sheets: list[TestSheet]
    law: str
    directory: Path
    name: str
    force: bool = False
    options: Options = field(default_factory=Options)
    held: dict[str, str] = field(default_factory=dict)
    compare: tuple[str, ...] = ()
    density: float | None = None
    strength: float | None = None


def run(request: Request, say: Callable[[str], None]) -> list[Fit]:
    """Fit, print and write card, plot and numbers; return the fits, best first.

    say: gets one line at a time. Raises SpecError with one line per fault, and writes nothing then.
    """
    tests = _read_all(request.sheets)
    for line in tell_tests(tests):
        say(line)
    for test in tests:
        for warning in warnings(test):
            say(f"warning: {warning}")
    others = {name: _card(name) for name in request.compare}
    candidates, output = _candidates(request, tests), _output(request)
    fits = _fit_all(tests, candidates, request.options, say)
    say("")
    if len(fits) > 1:
        for line in tell_ranking(fits):
            say(line)
        say("")
    best = fits[0]
    for line in tell_fit(best):
        say(line)
    for name, law in others.items():
        for line in tell_comparison(best, law, name):
            say(line)
    with output.opened():
        _write(request, output, fits, others, say)
    return fits


def _card(name: str) -> Law:
    """A card of the library, or a file such as an earlier fit wrote."""
    return parse_material(read_card(Path(name))) if is_file(name) else load_card(name)


def _read_all(sheets: list[TestSheet]) -> list[Test]:
    tests, faults = [], []
    for sheet in sheets:
        try:
            tests += read_tests(sheet)
        except SpecError as error:
            faults += error.lines
    if faults:
        raise SpecError(*faults)
    return tests


def _candidates(request: Request, tests: list[Test]) -> list[Candidate]:
    anisotropic = any(test.direction for test in tests)
    candidates = chosen(request.law, anisotropic)
    if not request.held:
        return candidates
    if len(candidates) > 1:
        raise SpecError("--fix holds constants of one law; it does not go with --law all")
    return [candidates[0].fix({k: _held(candidates[0], k, v) for k, v in request.held.items()})]


def _held(candidate: Candidate, name: str, text: str) -> object:
    """Return the value of a held constant: with a unit where it has a dimension."""
    entry = candidate.law.model_fields.get(name)
    if entry is None:
        return text  # ``fix`` names the nearest constant
    dimension = dimension_of(entry)
    try:
        if dimension is not None:
            return dimension.parse(text)
        return int(text) if text.lstrip("-").isdigit() else float(text)
    except ValueError as error:
        if dimension is None and name in ("convention",):
            return text
        raise SpecError(f"--fix {name}: {error}") from None


def _fit_all(tests, candidates: list[Candidate], options: Options, say) -> list[Fit]:
    fits, refused = [], []
    for candidate in candidates:
        if len(candidates) > 1:
            say(f"fitting {candidate.name}")
        try:
            fits.append(fit(tests, candidate, options))
        except SpecError as error:
            refused += error.lines
    if not fits:
        raise SpecError(*refused)
    for line in refused:
        say(f"left out: {line}")
    return ranked(fits)


def _output(request: Request) -> Output:
    """The folder, found fit for its files."""
    files = [Path(name) for name in request.compare if is_file(name)]
    reads = [*(sheet.file for sheet in request.sheets), *files]
    output = Output(request.directory, "fit", request.force, reads)
    output.check([f"{request.name}{suffix}" for suffix in SUFFIXES])
    return output


def _write(request: Request, output: Output, fits: list[Fit], others: dict[str, Law], say) -> None:
    card, plot, values, page = (f"{request.name}{suffix}" for suffix in SUFFIXES)
    try:
        text = card_text(fits[0], request.density, request.strength)
    except ValueError as error:
        text = ""
        say(f"no card: {' '.join(str(error).split())}")
    else:
        write_atomic(output.file(card), text)
        say(f"card:    {request.directory / card}")
    write_plot(output.file(plot), fits, others)
    say(f"plot:    {request.directory / plot}")
    write_atomic(output.file(values), numbers(fits))
    say(f"numbers: {request.directory / values}")
    write_atomic(output.file(page), html(request.name, fits, others, text))
    say(f"page:    {request.directory / page}")

"""``softact fit`` from arguments to files: read, fit, tell, write."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from pydantic import ValidationError

from softact.errors import SpecError
from softact.files.text import write_atomic
from softact.fit.candidates import Candidate, chosen
from softact.fit.card import card_text, numbers
from softact.fit.data import Test, read_tests
from softact.fit.fit import Fit, Options, fit, ranked
from softact.fit.fit_page import html
from softact.fit.held import first_fault, hold
from softact.fit.plausible import warnings
from softact.fit.plot import write_plot
from softact.fit.sheet import TestSheet
from softact.fit.tell import tell_comparison, tell_fit, tell_ranking, tell_tests
from softact.materials import Law, load_card, parse_material
from softact.results.own_folder import Output
from softact.spec.card_files import is_file, read_card

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
    others = {name: _card(name) for name in request.compare}
    tests = _read_all(request.sheets)
    candidates, output = _candidates(request, tests), _output(request)
    for line in tell_tests(tests):
        say(line)
    for test in tests:
        for warning in warnings(test):
            say(f"warning: {warning}")
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
    return [hold(candidates[0], request.held)]


def _fit_all(
    tests: list[Test],
    candidates: list[Candidate],
    options: Options,
    say: Callable[[str], None],
) -> list[Fit]:
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
    if len(fits) == 1:
        return fits
    say("trying what each law says of what it was not fitted to")
    return ranked(fits)


def _output(request: Request) -> Output:
    """The folder, found fit for its files."""
    files = [Path(name) for name in request.compare if is_file(name)]
    reads = [*(sheet.file for sheet in request.sheets), *files]
    output = Output(request.directory, "fit", request.force, reads)
    output.check([f"{request.name}{suffix}" for suffix in SUFFIXES])
    return output


def _write(
    request: Request,
    output: Output,
    fits: list[Fit],
    others: dict[str, Law],
    say: Callable[[str], None],
) -> None:
    card, plot, values, page = (f"{request.name}{suffix}" for suffix in SUFFIXES)
    try:
        text = card_text(fits[0], request.density, request.strength)
    except ValidationError as error:
        text = ""
        say(f"no card: {first_fault(error)}")
    else:
        write_atomic(output.file(card), text)
        say(f"card:    {request.directory / card}")
    write_plot(output.file(plot), fits, others)
    say(f"plot:    {request.directory / plot}")
    write_atomic(output.file(values), numbers(fits))
    say(f"numbers: {request.directory / values}")
    write_atomic(output.file(page), html(request.name, fits, others, text))
    say(f"page:    {request.directory / page}")

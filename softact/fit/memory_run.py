"""``softact fit`` of whole records, from arguments to files: read, fit, tell, write."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import ValidationError

from softact.errors import SpecError
from softact.files.text import json_text, replacing, write_atomic
from softact.fit.candidates import chosen
from softact.fit.card import DIGITS, card_of
from softact.fit.held import first_fault
from softact.fit.history import History
from softact.fit.memory_fit import MemoryFit, Question, best, fit_memory
from softact.fit.record import Record, read_records
from softact.fit.sheet import TestSheet
from softact.materials import Law
from softact.results.own_folder import Output
from softact.units import TIME

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SUFFIXES = (".yaml", ".png", ".json")
COLOURS = ("#0b62a4", "#d1495b", "#2e8b57", "#8a5fbf", "#c77d0a", "#5a5a5a")
# Stretch at no stress after an unloading, from which on it is said that no law here keeps it.
SET = 0.02


@dataclass(frozen=True)
class MemoryRequest:
    """What to fit and what to write. density: tonne/mm³; strength: MPa; None where not given.
    force: write into the folder whatever it holds."""

    sheets: Sequence[TestSheet]
    law: str
    directory: Path
    name: str
    softens: bool = False
    creeps: bool = False
    by_stretch: bool = False
    balance: bool = False
    density: float | None = None
    strength: float | None = None
    force: bool = False


def run(request: MemoryRequest, say: Callable[[str], None]) -> list[MemoryFit]:
    """Fit, print and write card, plot and numbers; return all fits that were compared.

    say: gets one line at a time. Raises SpecError with one line per fault, and writes nothing then.
    """
    candidates = chosen(request.law, False)
    if len(candidates) > 1:
        raise SpecError("--law all ranks laws by slow tests; name one law for a fit of memory")
    if candidates[0].law.anisotropic:
        raise SpecError(f"--law: memory is not fitted with fibres; {request.law} has some")
    records = _read_all(request)
    reads = [sheet.file for sheet in request.sheets]
    output = Output(request.directory, "fit", request.force, reads)
    output.check([f"{request.name}{suffix}" for suffix in SUFFIXES])
    question = Question(
        candidates[0], request.softens, request.creeps, request.by_stretch, request.balance
    )
    fits = fit_memory(records, question)
    for line in tell(fits):
        say(line)
    with output.opened():
        _write(request, output, fits, say)
    return fits


def _read_all(request: MemoryRequest) -> list[Record]:
    records, faults = [], []
    for sheet in request.sheets:
        try:
            records += read_records(sheet, request.creeps)
        except SpecError as error:
            faults += error.lines
    if faults:
        raise SpecError(*faults)
    return records


def tell(fits: Sequence[MemoryFit]) -> Iterator[str]:
    """What the records say, line by line."""
    chosen_one = best(fits)
    for history in chosen_one.histories:
        yield from _of_record(history.record)
    what = "stretch" if chosen_one.question.by_stretch else "stress"
    for fit in fits:
        parts = [*fit.softening, f"elements: {len(fit.series.g)}"]
        if not fit.question.creeps:
            parts.pop()
        mark = "  <- taken" if fit is chosen_one else ""
        yield (
            f"  {', '.join(parts)}: {fit.series.rms:.3%} of the largest {what} (rms), "
            f"BIC {fit.bic:.1f}{mark}"
        )
    yield from _constants(chosen_one)
    yield from (f"  attention: {line}" for line in remarks(chosen_one))


def _of_record(record: Record) -> Iterator[str]:
    loops = len(record.turns) // 2
    ways = f"{loops} loading{'s' if loops > 1 else ''}"
    clock = "" if record.times is None else f", {np.ptp(record.times):.4g} s"
    yield (
        f"{record.name} ({record.mode}): {len(record.stretch)} points{clock}, stretch "
        f"{record.stretch.min():.4g} to {record.stretch.max():.4g}, {ways}"
    )
    yield from (f"  {message}" for message in record.messages)


def _constants(fit: MemoryFit) -> Iterator[str]:
    candidate = fit.question.candidate
    units = {c.name: c.unit for c in candidate.law.constants()}
    yield f"{candidate.name}: {candidate.law.formula}"
    for name, value, half in zip(candidate.names, fit.vector, fit.law_error, strict=True):
        yield f"  {name:9s} = {value:12.6g} {units[name]:5s} {_interval(half)}".rstrip()
    for name, value in fit.softening.items():
        unit = "MPa" if name == "m" else ""
        yield f"  {name:9s} = {value:12.6g} {unit:5s} {_interval(fit.softening_error[name])}"
    rows = fit.series.g, fit.series.g_error, fit.series.tau, fit.series.tau_error
    for g, error, tau, factor in zip(*rows, strict=True):
        yield (
            f"  g {g:.4f} ± {error:.4f}, tau {tau:.4g} s (95 %: {tau / factor:.3g} to "
            f"{tau * factor:.3g} s)"
        )


def _interval(half: float) -> str:
    return "at a bound" if np.isnan(half) else f"± {half:.2g} (95 %)"


def remarks(fit: MemoryFit) -> list[str]:
    """What a user must know before using the constants."""
    lines = []
    if fit.question.softens and fit.peaks_alike:
        lines.append("all peaks are alike, which does not part m from beta; beta is held at 0")
    if fit.question.creeps and not len(fit.series.g):
        lines.append("nothing creeps beyond the noise of the tests")
    spans = [np.ptp(h.record.times) for h in fit.histories if h.record.times is not None]
    slowest = fit.series.tau.max(initial=0.0)
    if len(fit.series.g) and slowest > max(spans):
        lines.append(f"{slowest:.3g} s is longer than the tests; what is left for ever is a guess")
    for history in fit.histories:
        lasting = _lasting(history.record)
        if fit.question.softens and lasting > SET:
            lines.append(
                f"{history.record.name}: unloaded it is {lasting:.1%} longer than at first; a "
                "permanent set is not part of the law"
            )
    loose = [n for n, e in fit.softening_error.items() if e > abs(fit.softening[n])]
    if loose:
        lines.append(f"poorly determined (interval wider than the value): {', '.join(loose)}")
    return lines


def _lasting(record: Record) -> float:
    """Elongation at which the stress has gone, at the end of the last unloading."""
    size = np.abs(record.stress).max()
    peak = record.peaks[-1] if record.peaks else 0
    gone = np.flatnonzero(record.stress[peak:] < 1e-3 * size)
    return float(record.stretch[peak + gone[0]] - 1) if len(gone) else 0.0


def law_of(fit: MemoryFit, density: float | None, strength: float | None) -> Law:
    """The law with its memory, as a card holds it. Raises ValidationError where it cannot be."""
    records = [h.record for h in fit.histories]
    low = min(1.0, *(float(r.stretch.min()) for r in records))
    high = max(1.0, *(float(r.stretch.max()) for r in records))
    fields: dict[str, object] = {
        "stretch_range": [float(f"{low:.6g}"), float(f"{high:.6g}")],
        "test": "; ".join(_tested(record) for record in records),
        "source": f"softact fit, {', '.join(sorted({r.name for r in records}))}",
    }
    if said := remarks(fit):
        fields["notes"] = "; ".join(said)
    if density is not None:
        fields["density"] = density
    if strength is not None:
        fields["strength"] = strength
    if fit.softening:
        values = {name: float(f"{v:.{DIGITS}g}") for name, v in fit.softening.items()}
        values.setdefault("beta", 0.0)
        fields["mullins"] = {**values, "m": f"{values.get('m', 0.0)!r} MPa"}
    if len(fit.series.g):
        fields["viscoelastic"] = {
            "g": [float(f"{g:.6g}") for g in fit.series.g],
            "tau": [TIME.format(float(f"{tau:.6g}")) for tau in fit.series.tau],
            "constants": "long_time",
        }
    rounded = np.array([float(f"{value:.{DIGITS}g}") for value in fit.vector])
    return fit.question.candidate.make(rounded, **fields)


def _tested(record: Record) -> str:
    low, high = record.stretch.min(), record.stretch.max()
    clock = "" if record.times is None else f" in {np.ptp(record.times):.3g} s"
    return f"{record.mode}, stretch {low:.3g} to {high:.3g}, {len(record.turns) - 1} ways{clock}"


def numbers(fits: Sequence[MemoryFit]) -> str:
    """Everything that is known about the fits as JSON, the one that is taken first; MPa, s."""
    first = best(fits)
    return json_text([_numbers(f) for f in [first, *(f for f in fits if f is not first)]])


def _numbers(fit: MemoryFit) -> dict[str, object]:
    names, series = fit.question.candidate.names, fit.series
    return {
        "law": fit.question.candidate.law.model_fields["law"].default,
        "constants": dict(zip(names, map(float, fit.vector), strict=True)),
        "confidence_95": dict(zip(names, map(float, fit.law_error), strict=True)),
        "mullins": fit.softening,
        "mullins_confidence_95": fit.softening_error,
        "g": series.g.tolist(),
        "g_confidence_95": series.g_error.tolist(),
        "tau_s": series.tau.tolist(),
        "tau_confidence_95_factor": series.tau_error.tolist(),
        "rms": series.rms,
        "bic": series.bic,
        "tests": [h.record.name for h in fit.histories],
        "remarks": remarks(fit),
    }


def _write(
    request: MemoryRequest, output: Output, fits: Sequence[MemoryFit], say: Callable[[str], None]
) -> None:
    card, plot, values = (f"{request.name}{suffix}" for suffix in SUFFIXES)
    taken = best(fits)
    try:
        text = card_of(law_of(taken, request.density, request.strength), bool(request.density))
    except ValidationError as error:
        say(f"no card: {first_fault(error)}")
    else:
        write_atomic(output.file(card), text)
        say(f"card:    {request.directory / card}")
    write_plot(output.file(plot), taken)
    say(f"plot:    {request.directory / plot}")
    write_atomic(output.file(values), numbers(fits))
    say(f"numbers: {request.directory / values}")


def write_plot(path: Path, fit: MemoryFit) -> None:
    """Write a PNG: every record as stress over stretch, and over time where it has a clock."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    timed = any(h.record.times is not None for h in fit.histories)
    figure = Figure(figsize=(6.2 * (1 + timed), 5.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes: list[Axes] = list(np.ravel(figure.subplots(1, 1 + timed)))
    for i, history in enumerate(fit.histories):
        _draw(axes, history, fit, COLOURS[i % len(COLOURS)])
    loops = axes[0]
    loops.set(xlabel="stretch", ylabel="nominal stress / kPa", title="all loadings and unloadings")
    if timed:
        over, by_stretch = axes[1], fit.question.by_stretch
        over.set(xlabel="time / s", ylabel="stretch" if by_stretch else "nominal stress / kPa")
        over.set_title("points: tests; lines: fit")
        if fit.question.creeps:
            over.set_xscale("symlog", linthresh=_first_time(fit.histories))
        over.grid(alpha=0.25)
    loops.grid(alpha=0.25)
    if len(fit.histories) <= 8:
        loops.legend(fontsize=8, framealpha=0.8)
    with replacing(path) as temporary:
        figure.savefig(temporary, format="png", dpi=120)


def _first_time(histories: Sequence[History]) -> float:
    clocks = [h.record.times for h in histories if h.record.times is not None]
    return max(min(float(np.median(np.diff(c))) for c in clocks), 1e-9)


def _draw(axes: Sequence[Axes], history: History, fit: MemoryFit, colour: str) -> None:
    record, stress = history.record, fit.stress(history)
    points: dict[str, Any] = {"ls": "", "marker": "o", "ms": 3, "mfc": "none", "color": colour}
    axes[0].plot(record.stretch, 1e3 * record.stress, **points)
    axes[0].plot(record.stretch, 1e3 * stress, color=colour, lw=1.4, label=record.name)
    if record.times is None or len(axes) < 2:
        return
    times = record.times - record.times[0]
    if not fit.question.by_stretch:
        axes[1].plot(times, 1e3 * record.stress, **points)
        axes[1].plot(times, 1e3 * stress, color=colour, lw=1.4)
        return
    axes[1].plot(times, record.stretch, **points)
    axes[1].plot(times, record.stretch - fit.short(history), color=colour, lw=1.4)

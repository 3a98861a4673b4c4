"""The tables of the page: every published figure, whatever became of its run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from published.figures import BOUNDS, Figure, Run, Source
from published.results import COMPLETE, FAILED, NO_EQUILIBRIUM, STOPPED, Outcome

NOT_COMPUTED = "not computed"
_ENDED = {COMPLETE: "all steps", NO_EQUILIBRIUM: "exit 4", FAILED: "failed"}


def lines(sources: Sequence[Source], known: Mapping[str, Outcome]) -> Iterator[str]:
    """The part of the page, line by line."""
    figures = [figure for source in sources for figure in source.figures]
    yield f"{len(figures)} figures; {_counted(sources, known)}."
    for source in sources:
        yield from ("", f"### {source.name}", "", f"{source.source}.")
        if source.remark:
            yield from ("", source.remark)
        yield ""
        yield from table(
            ("figure", "published", "softact", "deviation", "run", "assumption"),
            (_row(figure, source, known) for figure in source.figures),
        )
        yield ""
        yield from table(
            ("run", "command", "outcome"),
            (
                (f"`{n}`", f"`{r.command()}`", _outcome(known.get(n), r))
                for n, r in source.runs.items()
            ),
        )


def listed(sources: Sequence[Source], known: Mapping[str, Outcome]) -> Iterator[str]:
    """A line for each run: its name and how it ended."""
    for source in sources:
        for name, run in source.runs.items():
            yield f"{name:28s} {_outcome(known.get(name), run)}"


def is_current(outcome: Outcome, run: Run, figures: Iterable[Figure]) -> bool:
    """Whether nothing is left to compute for a run: its input and all readings are as asked.

    A run that failed, or was stopped by us, is tried again only when it is asked for.
    """
    if not outcome.is_of(run):
        return False
    ended = outcome.status in (FAILED, STOPPED) and not outcome.taken_over
    return ended or all(outcome.reading(f) is not None for f in figures)


def table(titles: Iterable[str], rows: Iterable[Iterable[str]]) -> list[str]:
    """Lines of a Markdown table."""
    titles = list(titles)
    return [
        "| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |"
        for line in [titles, ["---"] * len(titles), *rows]
    ]


def _row(figure: Figure, source: Source, known: Mapping[str, Outcome]) -> tuple[str, ...]:
    kind = "computed there" if figure.kind == "computed" else figure.kind
    assumed = [figure.assumes, *(source.runs[name].assumes for name in figure.runs)]
    found = [_found(figure, name, source, known) for name in figure.runs]
    return (
        figure.what,
        f"{_published(figure)} ({kind}; {figure.where})",
        ", ".join(_value(reading, figure) for reading in found),
        _deviation(figure, found),
        ", ".join(f"`{name}`" for name in figure.runs),
        "; ".join(dict.fromkeys(text for text in assumed if text)),
    )


def _found(
    figure: Figure, name: str, source: Source, known: Mapping[str, Outcome]
) -> dict[str, Any] | None:
    """A reading, with "old" where the run has been written anew since; None: not computed."""
    outcome = known.get(name)
    if outcome is None:
        return None
    if outcome.status == FAILED:
        return {"value": None, "failed": True}
    reading = outcome.reading(figure)
    if reading is None:
        return None
    if outcome.status == STOPPED and not figure.read.at:
        reading = {"value": None, "stopped": reading["value"]}  # it could have gone further
    return {
        **reading,
        "old": not outcome.is_of(source.runs[name]),
        "taken_over": outcome.taken_over,
    }


def _published(figure: Figure) -> str:
    if figure.trend:
        trend = "largest inside" if figure.trend == "peak" else figure.trend
        return f"{trend}: {figure.said}" if figure.said else trend
    if figure.bound:
        number = f"{BOUNDS[figure.bound][0]} {getattr(figure, figure.bound):g}"
    else:
        number = f"{figure.value:g}"
    text = _with_unit(number, figure.unit)
    return f"{text}: {figure.said}" if figure.said else text


def _value(reading: Mapping[str, Any] | None, figure: Figure) -> str:
    if reading is None:
        return NOT_COMPUTED
    marks = " †" if reading.get("taken_over") else ""
    marks += " (of an older spec)" if reading.get("old") else ""
    if reading["value"] is not None:
        return _number(reading["value"], figure) + marks
    if "failed" in reading:
        return "failed"
    if reading.get("stopped") is not None:
        return f"stopped at {_number(reading['stopped'], figure)}{marks}"
    if "last" not in reading:
        return f"not reached{marks}"
    at, last = reading["last"]
    ((name, wanted),) = figure.read.at.items()
    here = "" if last is None else f": {_number(last, figure)}"
    there = "" if at is None else f" at {_readable(name, at)}{here}"
    return f"ended before {_readable(name, wanted)}{there}{marks}"


def _deviation(figure: Figure, found: Sequence[Mapping[str, Any] | None]) -> str:
    values = [reading["value"] for reading in found if reading is not None]
    if len(values) < len(found):
        return ""
    if any(value is None for value in values):
        return "not reached"
    if figure.value is None:
        return "holds" if figure.holds(values) else "**does not hold**"
    return f"{100 * (values[0] / figure.value - 1):+.0f} %".replace("-", "−")


def _outcome(outcome: Outcome | None, run: Run) -> str:
    if outcome is None:
        return f"{NOT_COMPUTED}: {run.large}" if run.large else NOT_COMPUTED
    words = [_ENDED.get(outcome.status, outcome.status)]
    if outcome.cause:
        words[0] += f": {outcome.cause}"
    if outcome.unknowns:
        words.append(f"{outcome.unknowns:,} unknowns")
    if outcome.seconds is not None:
        words.append(f"{outcome.seconds:.0f} s")
    words.append(f"† taken over from {outcome.commit}" if outcome.taken_over else outcome.commit)
    if not outcome.is_of(run):
        words.append("of an older spec")
    return "; ".join(words)


def _counted(sources: Sequence[Source], known: Mapping[str, Outcome]) -> str:
    """How many figures stand where."""
    counts: dict[str, int] = {}
    for source in sources:
        for figure in source.figures:
            readings = [_found(figure, name, source, known) for name in figure.runs]
            text = _deviation(figure, readings) or NOT_COMPUTED
            text = "a number beside softact's" if text.endswith("%") else text.strip("*")
            counts[text] = counts.get(text, 0) + 1
    return ", ".join(f"{counts[text]} {text}" for text in sorted(counts))


def _readable(column: str, value: float) -> str:
    """A column and its value in words: pressure_cavity_1_kPa, 200 -> 200 kPa."""
    unit = column.rsplit("_", 1)[-1]
    return f"{value:.4g} {unit}" if unit in ("kPa", "MPa", "deg", "mm", "N") else f"{value:.4g}"


def _number(value: float, figure: Figure) -> str:
    return _with_unit(f"{value:.3g}", figure.unit)


def _with_unit(number: str, unit: str) -> str:
    return number + unit if unit == "°" else f"{number} {unit}".rstrip()

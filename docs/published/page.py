"""The tables of the page, one for each kind of rows; every published figure is in one of them,
whatever became of its runs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from published.figures import AIM, BOUNDS, CLAIM, DRAWN, MODEL, TEST, Figure, Run, Source
from published.results import COMPLETE, FAILED, NO_EQUILIBRIUM, STOPPED, Outcome

NOT_COMPUTED, NOT_REACHED, NOT_HELD = "not computed", "not reached", "does not hold"
NO_NUMBER = "nothing to compare"
NEAR, FAR = "within 10 %", "farther off"
KINDS = {
    TEST: "Against a test",
    MODEL: "Against the paper's own model",
    CLAIM: "What the paper claims",
    AIM: "What the paper aims at",
    DRAWN: "What the paper draws, with no number in its text",
}
TITLES = ("figure", "published", "softact", "deviation", "cause", "run", "assumption")
CLOSE = 10.0  # percent of deviation from which on a row says its cause
_ENDED = {COMPLETE: "all steps", NO_EQUILIBRIUM: "exit 4", FAILED: "failed"}


def lines(sources: Sequence[Source], known: Mapping[str, Outcome]) -> Iterator[str]:
    """The part of the page, line by line."""
    yield from table(("row", "rows", "how they stand"), _counted(sources, known))
    for source in sources:
        yield from ("", f"### {source.name}", "", f"{source.source}.")
        if source.remark:
            yield from ("", source.remark)
        for kind, title in KINDS.items():
            groups = [group for group in source.groups if group[0].row == kind]
            if groups:
                yield from ("", f"**{title}**", "")
                yield from table(TITLES, (_row(group, source, known) for group in groups))
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


def causes_lacking(source: Source, known: Mapping[str, Outcome]) -> list[str]:
    """Names of the figures that are off by more than ``CLOSE``, or fail, without a cause."""
    return [
        group[0].id
        for group in source.groups
        if not group[0].cause and any(_is_off(f, source, known) for f in group)
    ]


def _is_off(figure: Figure, source: Source, known: Mapping[str, Outcome]) -> bool:
    return _standing(figure, source, known) in (FAR, NOT_HELD, NOT_REACHED)


def _standing(figure: Figure, source: Source, known: Mapping[str, Outcome]) -> str:
    """In a few words how a figure stands."""
    text = _deviation(figure, _readings(figure, source, known)) or NOT_COMPUTED
    if not text.endswith("%"):
        return text.strip("*")
    percent = abs(float(text.removesuffix(" %").replace("−", "-")))
    return NEAR if percent <= CLOSE else FAR


def _readings(
    figure: Figure, source: Source, known: Mapping[str, Outcome]
) -> list[dict[str, Any] | None]:
    return [_found(figure, name, source, known) for name in figure.runs]


def _row(group: Sequence[Figure], source: Source, known: Mapping[str, Outcome]) -> tuple[str, ...]:
    """Of a figure and its variants: one row, with the spread over what is assumed."""
    first, runs = group[0], [name for figure in group for name in figure.runs]
    kind = "computed there" if first.kind == "computed" else first.kind
    assumed = [f.assumes for f in group] + [source.runs[name].assumes for name in runs]
    found = [_readings(figure, source, known) for figure in group]
    values = [
        ", ".join(_value(reading, figure) for reading in readings)
        for figure, readings in zip(group, found, strict=True)
    ]
    if len(group) > 1:
        values = [f"{v} ({f.differs or 'as assumed'})" for v, f in zip(values, group, strict=True)]
    return (
        first.what,
        f"{_published(first)} ({kind}; {first.where})",
        "; ".join(values),
        _spread([_deviation(f, readings) for f, readings in zip(group, found, strict=True)]),
        first.cause,
        ", ".join(f"`{name}`" for name in dict.fromkeys(runs)),
        "; ".join(dict.fromkeys(text for text in assumed if text)),
    )


def _spread(deviations: Sequence[str]) -> str:
    """Of several deviations the least and the largest, and how often there is none."""
    if len(deviations) == 1:
        return deviations[0]
    numbers = sorted(
        int(text.removesuffix(" %").replace("−", "-")) for text in deviations if text.endswith("%")
    )
    words = [text or NOT_COMPUTED for text in deviations if not text.endswith("%")]
    told = [f"{words.count(text)} × {text}" for text in dict.fromkeys(words)]
    if numbers:
        ends = dict.fromkeys((numbers[0], numbers[-1]))
        told.insert(0, " to ".join(f"{n:+d}" for n in ends).replace("-", "−") + " %")
    return "; ".join(told)


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
    if figure.row == DRAWN:
        return figure.said or "a curve"
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
        return NOT_REACHED
    if figure.row == DRAWN:
        return NO_NUMBER
    if figure.value is None:
        return "holds" if figure.holds(values) else f"**{NOT_HELD}**"
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


def _counted(
    sources: Sequence[Source], known: Mapping[str, Outcome]
) -> Iterator[tuple[str, str, str]]:
    """For each kind of rows, how many there are and how they stand as the specs are."""
    for kind, title in KINDS.items():
        rows = [(g[0], source) for source in sources for g in source.groups if g[0].row == kind]
        stand = [_standing(figure, source, known) for figure, source in rows]
        counts = ", ".join(f"{stand.count(text)} {text}" for text in sorted(set(stand)))
        yield title, str(len(rows)), counts


def _readable(column: str, value: float) -> str:
    """A column and its value in words: pressure_cavity_1_kPa, 200 -> 200 kPa."""
    unit = column.rsplit("_", 1)[-1]
    return f"{value:.4g} {unit}" if unit in ("kPa", "MPa", "deg", "mm", "N") else f"{value:.4g}"


def _number(value: float, figure: Figure) -> str:
    return _with_unit(f"{value:.3g}", figure.unit)


def _with_unit(number: str, unit: str) -> str:
    return number + unit if unit == "°" else f"{number} {unit}".rstrip()

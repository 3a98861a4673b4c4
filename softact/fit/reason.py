"""Why a law is first among those that were fitted: one sentence in plain words."""

from collections.abc import Sequence

from softact.fit.fit import Fit

CLEARLY = 0.98  # of another error: below it a law is said to be better


def reason(fits: Sequence[Fit]) -> str:
    """Return the sentence. fits: as ``ranked`` has them, two or more.

    The first is set against the law that Bayes' criterion would put first, or, where it is that
    itself, against the second; against one that is not sound only where there is no other.
    """
    best = fits[0]
    others = [f for f in fits if f.sound] if best.sound and fits[1].sound else fits
    by_bayes = min(others, key=lambda f: f.information.bic)
    rival = fits[1] if by_bayes is best else by_bayes
    follows = ""
    if rival.worth.fitted < CLEARLY * best.worth.fitted:
        follows = (
            f", though {rival.name} follows the data more closely "
            f"({_percent(rival.worth.fitted)} off instead of {_percent(best.worth.fitted)})"
        )
    return f"{best.name} is first: {_because(best, rival)}{follows}."


def _because(best: Fit, rival: Fit) -> str:
    if best.sound and rival.failures:
        mode, stretch = rival.failures[0]
        return (
            f"it is stable over the tested range, where {rival.name} is unstable in {mode} "
            f"deformation at a stretch of {stretch:.3g}"
        )
    if best.sound and not rival.sound:
        return f"the tests determine its constants, and do not determine those of {rival.name}"
    clauses = [*_errors(best, rival), *_constants(best, rival)]
    if not clauses:
        return f"its errors and its number of constants together are the smallest ({rival.name})"
    *more, last = clauses
    return f"it {', '.join(more)} and {last}" if more else f"it {last}"


def _errors(best: Fit, rival: Fit) -> list[str]:
    clauses = []
    mine, other = best.worth, rival.worth
    ahead, behind = mine.predicted, other.predicted
    if ahead is not None and behind is not None and ahead < CLEARLY * behind:
        what = "a mode" if mine.modes else "a part of the stretch"
        clauses.append(
            f"predicts {what} that was held out of the fit to {_percent(ahead)} "
            f"({rival.name} to {_percent(behind)})"
        )
    if mine.fitted < CLEARLY * other.fitted:
        clauses.append(
            f"follows the data to {_percent(mine.fitted)} ({rival.name} to "
            f"{_percent(other.fitted)})"
        )
    return clauses


def _constants(best: Fit, rival: Fit) -> list[str]:
    clauses = []
    mine, other = best.worth, rival.worth
    if mine.constants < other.constants:
        clauses.append(f"needs {_number(mine.constants)} instead of {other.constants}")
    if mine.loose < other.loose:
        poor = f"{other.loose} of {rival.name}'s {'are' if other.loose > 1 else 'is'} not"
        fewer = f"has fewer that are poorly determined ({mine.loose}, not {other.loose})"
        clauses.append(fewer if mine.loose else f"has them determined, where {poor}")
    return clauses


def _number(count: int) -> str:
    return f"{count} constant{'s' if count > 1 else ''}"


def _percent(part: float) -> str:
    return "more than 500 %" if part > 5 else f"{100 * part:.2g} %"

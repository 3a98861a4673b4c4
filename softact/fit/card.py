"""A fitted law as a material card, and the numbers of a fit as JSON."""

import numpy as np
import yaml

from softact.files.text import json_text
from softact.fit.broken import of_card
from softact.fit.fit import Fit
from softact.fit.reason import reason
from softact.materials import Law

DIGITS = 9


def card_text(fit: Fit, density: float | None, strength: float | None) -> str:
    """Return the YAML of a card, in the words of a spec; it can stand under ``materials:`` too.

    density: tonne/mm³ or None for the default. strength: MPa or None, nominal.
    Tests that say that their specimen broke give strength and elongation.
    """
    low, high = fit.stretch_range
    fields: dict[str, object] = {
        "stretch_range": [float(f"{low:.6g}"), float(f"{high:.6g}")],
        "test": "; ".join(_described(fit)),
        "source": f"softact fit, {', '.join(sorted({t.name for t in fit.problem.tests}))}",
    }
    if density is not None:
        fields["density"] = density
    fields |= of_card(fit.problem.tests)
    if strength is not None:
        fields["strength"] = strength
    if remarks := fit.remarks():
        fields["notes"] = "; ".join(remarks)
    rounded = np.array([float(f"{value:.{DIGITS}g}") for value in fit.vector])
    return card_of(fit.candidate.make(rounded, **fields), density is not None)


def card_of(law: Law, with_density: bool) -> str:
    """Return the YAML of a law. with_density: where it is not the default one."""
    data = law.model_dump(mode="json", exclude_defaults=True, exclude_none=True)
    data = {"law": law.law, **data}
    if not with_density:
        data.pop("density", None)
    head = "# A material card of softact. Use it as 'materials: {body: {...}}' or as a card.\n"
    return head + yaml.safe_dump(data, sort_keys=False, allow_unicode=True, width=100)


def _described(fit: Fit) -> list[str]:
    lines = []
    for mode in dict.fromkeys(t.mode for t in fit.problem.tests):
        group = [t for t in fit.problem.tests if t.mode == mode]
        low = min(float(np.min(t.stretch)) for t in group)
        high = max(float(np.max(t.stretch)) for t in group)
        count = f", {len(group)} curves" if len(group) > 1 else ""
        lines.append(f"{mode}, stretch {low:.3g} to {high:.3g}{count}")
    return lines


def numbers(fits: list[Fit]) -> str:
    """Return everything that is known about the fits as JSON, best first; MPa."""
    first = {"reason": reason(fits)} if len(fits) > 1 else {}
    found = [_numbers(fit) | (first if i == 0 else {}) for i, fit in enumerate(fits)]
    return json_text(found)


def _numbers(fit: Fit) -> dict[str, object]:
    names = fit.candidate.names
    return {
        "law": fit.candidate.law.model_fields["law"].default,
        "name": fit.name,
        "constants": dict(zip(names, map(float, fit.vector), strict=True)),
        "held": {k: v for k, v in fit.candidate.fixed.items()},
        "confidence_95": dict(zip(names, fit.certainty.interval, strict=True)),
        "identifiable": fit.certainty.identifiable,
        "tests": [vars(q) for q in fit.qualities],
        "aicc": fit.information.aicc,
        "bic": fit.information.bic,
        "merit": None if fit.merit is None else vars(fit.merit),
        "reduced_chi_square": fit.chi_square,
        "normalised_error": fit.error,
        "stable_between": {s.mode: [s.below, s.above] for s in fit.stability},
        "stable_over_the_tests": not fit.failures,
        "spread": [vars(s) for s in fit.spreads],
        "specimens": {
            s.name: dict(zip(names, map(float, s.vector), strict=True)) for s in fit.specimens
        },
        "stretch_range": fit.stretch_range,
        "remarks": fit.remarks(),
        "evaluations": fit.solution.evaluations,
    }

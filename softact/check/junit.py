"""Outcomes as JUnit XML, which CI servers show."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree import ElementTree

from softact.check.compare import Outcome

#: By what softact knows a file of its own.
SIGN = b'<testsuite name="softact check"'


def junit(outcomes: Sequence[Outcome]) -> bytes:
    """One suite with a test for each case; a deviation is a failure, a broken run an error."""
    failed = sum(bool(o.differences) and not o.fault for o in outcomes)
    broken = sum(bool(o.fault) for o in outcomes)
    suite = ElementTree.Element(
        "testsuite",
        name="softact check",
        tests=str(len(outcomes)),
        failures=str(failed),
        errors=str(broken),
        time=f"{sum(o.seconds for o in outcomes):.3f}",
    )
    for outcome in outcomes:
        test = ElementTree.SubElement(
            suite,
            "testcase",
            classname="softact.check",
            name=outcome.case.name,
            file=str(outcome.case.path),
            time=f"{outcome.seconds:.3f}",
        )
        if not outcome.passed:
            lines = outcome.lines()
            kind = "error" if outcome.fault else "failure"
            entry = ElementTree.SubElement(test, kind, message=lines[0])
            entry.text = "\n".join(lines)
    return ElementTree.tostring(suite, encoding="utf-8", xml_declaration=True)

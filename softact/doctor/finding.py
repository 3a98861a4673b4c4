"""What the doctor says of one thing, and of all of them."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Literal

State = Literal["ok", "slow", "absent", "broken"]


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at.

    state: "ok"; "slow" where softact works but could be faster; "absent" where something is
        missing that only a part of softact needs; "broken" where no spec can be solved.
    mend: the command or the advice that mends it; empty when there is nothing to mend.
    """

    name: str
    state: State
    detail: str
    mend: str = ""


def missing_module(name: str, error: Exception, mend: str) -> Finding:
    """A finding for a module that cannot be imported, with the first line of the reason."""
    reason = str(error).splitlines()[0] if str(error) else type(error).__name__
    return Finding(name, "broken", f"cannot be imported: {reason}", mend)


def usable(findings: Iterable[Finding]) -> bool:
    """Whether a spec can be solved on this machine."""
    return all(finding.state != "broken" for finding in findings)


def as_text(findings: list[Finding]) -> str:
    """The findings as a table; under each that is not "ok" the command that mends it."""
    width = max(len(finding.name) for finding in findings)
    lines = []
    for finding in findings:
        lines.append(f"{finding.state:<7} {finding.name:<{width}}  {finding.detail}")
        if finding.mend:
            lines.append(f"{'':7} {'':{width}}  mend it with: {finding.mend}")
    faults = sum(finding.state == "broken" for finding in findings)
    lines.append(f"\nsoftact cannot run: {faults} broken" if faults else "\nsoftact can run")
    return "\n".join(lines)


def as_records(findings: list[Finding]) -> list[dict[str, str]]:
    """The findings as plain dictionaries with the keys name, state, detail and mend."""
    return [asdict(finding) for finding in findings]

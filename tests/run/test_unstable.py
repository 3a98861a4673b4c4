"""What is told of unstable equilibria: each change on the way, not the first and the last alone."""

import pytest

from softact.run.unstable import unstable_text
from softact.solve.progress import Attempt


def states(*modes, control="load"):
    """Accepted states at 10, 20, ... percent of a step, with so many unstable modes."""
    return [
        Attempt("pull", 0.1 * (i + 1), 3, True, [], "", count, control)
        for i, count in enumerate(modes)
    ]


WHY = "the potential energy falls in some direction, so the actuator would snap or buckle"


@pytest.mark.parametrize(
    "modes, changes",
    [((0, 1, 2), ["unstable from 20.00%"]),
     ((0, 1, 0, 0), ["unstable from 20.00%", "stable again from 30.00%"]),
     ((0, 2, 0, 2, 2), ["unstable from 20.00%", "stable again from 30.00%",
                        "unstable from 40.00%"]),
     ((1, 0, 1, 0, 1, 0), ["unstable from 10.00%", "stable again from 20.00%",
                           "unstable from 30.00%", "stable again from 40.00%"])],
)  # fmt: skip
def test_each_change_is_told(modes, changes):
    first, *more = (f"{change} of step 'pull' on" for change in changes)
    rest = ", and 2 changes more" if len(modes) == 6 else ""
    assert unstable_text(states(*modes), again=True) == "; ".join([f"{first}: {WHY}", *more]) + rest


def test_nothing_is_said_of_a_run_that_is_stable_throughout():
    assert unstable_text(states(0, 0), again=True) is None
    assert unstable_text([], again=True) is None


def test_with_friction_a_state_is_not_known_to_be_stable():
    assert unstable_text(states(0, 1, 0), again=False) == (
        f"unstable from 20.00% of step 'pull' on: {WHY}"
    )


def test_a_motion_is_not_stable_again():
    found = [*states(0, 1), *states(0, control="motion")]
    assert unstable_text(found, again=True) == f"unstable from 20.00% of step 'pull' on: {WHY}"

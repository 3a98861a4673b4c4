"""How loads go with time: amplitudes by hand, and pressures out of a file."""

import numpy as np
import pytest

from softact.errors import SpecError
from softact.loads.load_step import LoadStep
from softact.loads.pressure_file import read
from softact.loads.timing import History, Hold, Sine, Smooth, Steady, Timing, Triangle
from softact.materials import LAWS
from softact.model import Support
from tests.analytic.meshes import block
from tests.analytic.solving import CLAMP, ROLLERS, build, solve


@pytest.mark.parametrize(
    "amplitude,parts,values,turns",
    [
        (Steady(), (0.0, 0.25, 1.0), (0.0, 0.25, 1.0), ()),
        (Smooth(), (0.0, 0.25, 0.5, 1.0), (0.0, 0.15625, 0.5, 1.0), ()),
        (Hold(), (0.0, 0.5, 1.0), (1.0, 1.0, 1.0), ()),
        (Sine(1.0), (0.0, 0.25, 0.5, 1.0), (0.0, 0.5, 1.0, 0.0), (0.5,)),
        (Sine(1.5), (1 / 3, 2 / 3, 1.0), (1.0, 0.0, 1.0), (1 / 3, 2 / 3)),
        (
            Triangle(2.0),
            (0.125, 0.25, 0.5, 0.75, 1.0),
            (0.5, 1.0, 0.0, 1.0, 0.0),
            (0.25, 0.5, 0.75),
        ),
    ],
)
def test_amplitude(amplitude, parts, values, turns):
    np.testing.assert_allclose([amplitude.at(p) for p in parts], values, atol=1e-14)
    assert amplitude.turns == pytest.approx(turns)
    assert Timing(2.0, amplitude).strokes == len(turns) + 1


def cube():
    return build(block((1, 1, 1)), LAWS["neo_hookean"].of(c10=0.1, bulk_modulus=10.0))


def test_increments_end_at_turns_and_loads_follow():
    """Three cycles of 40 kPa in 1.5 s: loads as the sine says, a state at each peak, and rest at
    the end, from which the next step begins."""
    cycles = LoadStep("cycles", timing=Timing(1.5, Sine(3.0)), traction={"x_max": [0.04, 0.0, 0.0]})
    more = LoadStep("more", traction={"x_max": [0.01, 0.0, 0.0]})
    solution = solve(cube(), [cycles, more], ROLLERS, 0.25)
    within = solution.path[1:-4]
    times = np.array([s.clock.now for s in within])
    pulls = np.array([s["traction"]["x_max"][0] for s in within])
    np.testing.assert_allclose(pulls, 0.02 * (1 - np.cos(4 * np.pi * times)), atol=1e-12)
    for peak in (0.25, 0.5, 0.75, 1.0, 1.25):
        assert np.isclose(times, peak, atol=1e-12).any()
    assert np.diff(times).max() <= 0.25 * 0.25 + 1e-12  # a quarter of a loading
    assert pulls[-1] == 0.0
    assert solution.path[-1].clock.now == 1.5
    assert [s["traction"]["x_max"][0] for s in solution.path[-4:]] == pytest.approx(
        [0.0025, 0.005, 0.0075, 0.01]
    )


def test_support_that_comes_back_stays():
    """Moved by 0.3 mm and back: a later step without supports does not move it again."""
    there = LoadStep(
        "there", [*ROLLERS, Support("x_max", {0: 0.3})], timing=Timing(1.0, Triangle(1.0))
    )
    later = LoadStep("later", gravity=(0.0, 0.0, -1.0))
    solution = solve(cube(), [there, later], ROLLERS, 0.25)
    moved = [s.x[solution.model.displacement_dofs[0]] for s in solution.path]
    assert np.abs(moved).max() >= 0.0
    tip = solution.model.displacement_dofs[solution.model.surfaces.nodes("x_max"), 0]
    assert max(s.x[tip].max() for s in solution.path) == pytest.approx(0.3)
    assert np.abs(solution.state.x[tip]).max() < 1e-12


def test_no_clock_no_time():
    """A step with a duration passes the states that one without it does."""
    ends = []
    for timing in (None, Timing(3.0)):
        step = LoadStep("pull", timing=timing, traction={"x_max": [0.02, 0.01, 0.0]})
        solution = solve(cube(), step, [CLAMP], 0.25)
        ends.append(solution.state.x)
        times = [s.clock.now for s in solution.path]
        assert times == ([0.0] * 5 if timing is None else [0.0, 0.75, 1.5, 2.25, 3.0])
    np.testing.assert_allclose(*ends, rtol=1e-9, atol=1e-13)


def test_pressures_from_a_file(tmp_path):
    """Peaks are turns, noise is not; the value between two rows is on the line."""
    file = tmp_path / "p.csv"
    file.write_text("Time [ms],pressure_left (kPa),pressure_right_bar\n" + TABLE)
    table = read(file)
    assert table.duration == pytest.approx(0.4)
    assert set(table.pressures) == {"left", "right"}
    assert table.pressures["left"][2] == pytest.approx(0.04)
    assert table.pressures["right"][3] == pytest.approx(0.02)
    assert list(table.faults(["left", "right"])) == []
    assert "no cavity 'right'" in next(iter(table.faults(["left"])))
    history = History(table.parts, table.for_cavities(["left", "right"]))
    assert history.turns == pytest.approx([0.5, 0.75])
    assert history.pressures(0.625) == pytest.approx({"left": 0.035, "right": 0.01})


TABLE = """100,0,0
200,20,0
300,40,0
400,30,0.2
450,30.2,0.1
500,0,0
"""


@pytest.mark.parametrize(
    "text,line",
    [
        ("time (s),pressure (kPa)\n0,0\n2,1\n1,3\n", "time runs back from 2 s to 1 s at row 4"),
        ("time (s),pressure (kPa)\n0,0\n0,1\n", "time runs back from 0 s to 0 s at row 3"),
        ("time,pressure\n0,0\n1,1\n", "'time' has no unit"),
        ("time (s),pressure (mm)\n0,0\n1,1\n", "'mm' is a length"),
        ("time (s),angle (deg)\n0,0\n1,1\n", "'angle (deg)' is neither"),
        ("time (s),pressure (kPa)\n0,0\n", "two rows are wanted"),
        ("time (s),pressure (kPa)\n0,0\n1,x\n", "row 3 holds '1,x', no numbers"),
        ("time (s),pressure (kPa)\n0,0\n1,nan\n", "row 3 holds a number that is not finite"),
        ("time (s),pressure (kPa)\n0,0\n1\n", "row 3 has 1 cells, and the header 2"),
        ("time (s),t (s)\n0,0\n1,2\n", "one time and pressures are wanted"),
    ],
)
def test_wrong_files(tmp_path, text, line):
    (tmp_path / "p.csv").write_text(text)
    with pytest.raises(SpecError) as raised:
        read(tmp_path / "p.csv")
    (told,) = raised.value.lines
    assert told.startswith("p.csv: ")
    assert line in told

"""Thousands of wrong calls, files and result folders: ``python -m benchmarks.fuzz --inputs 5000``.

Hypothesis draws what is called, by seed: the same seed gives the same inputs. Specs, studies, cards
and test data are changed in a few places, result folders damaged, options made odd. Most calls are
made in this process, with stand-ins for gmsh, the solver and the drawing; one of so many as a
program of its own, with all that is real. What is asked of each: ``benchmarks.fuzz_judge``. The
folder of one that fails is kept.
"""

from __future__ import annotations

import json
import random
import shlex
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from unittest import mock

import click
from hypothesis import HealthCheck, Phase, given, seed, settings

from benchmarks.fuzz_inputs import CUBE, FILES, Input, calls, commands, prepare
from benchmarks.fuzz_judge import Ended, as_program, faults, in_process, inside, listing
from benchmarks.fuzz_stand_ins import stand_ins
from softact.units import one_line

#: So many inputs are drawn of one command in turn. After ten Hypothesis mostly repeats itself with
#: small changes, which is good for finding one fault and bad for finding many.
BATCH = 5
LIMIT_S, LIMIT_OF_PROGRAM_S = 20.0, 180.0
#: What is called as a program: what takes seconds with all that is real.
AS_PROGRAM = ("run", "validate", "report", "compare", "schema", "list", "fit", "check", "mesh")
STUDIES = (
    ("run", "cube.yaml", "-o", "../other"),
    ("sweep", "sweep.yaml"),
    ("optimize", "opt.yaml"),
    ("converge", "cube.yaml", "-m", "elongation_mm", "--most", "2"),
    ("calibrate", "cube.yaml", "--data", "curve.csv", "--vary", "materials.body.c10",
     "--max-runs", "2"),
)  # fmt: skip


@dataclass(frozen=True)
class Fault:
    """An input that was not met as it should be."""

    number: int
    called: str
    files: list[str]
    what: list[str]
    ended: Ended

    def lines(self) -> list[str]:
        """What to tell of it."""
        last = [line for line in self.ended.err.strip().split("\n") if line][-2:]
        where = [line.strip() for line in self.ended.where.split("\n") if "softact" in line][-2:]
        return [
            f"#{self.number} {self.called}",
            f"   {'; '.join(self.files)}",
            f"   FAULT: {'; '.join(self.what)}",
            *(f"   | {line}"[:300] for line in last + where),
        ]


@dataclass
class Counts:
    """What became of the inputs."""

    codes: dict[str, Counter] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)
    programs: int = 0
    slowest: float = 0.0

    def lines(self) -> list[str]:
        """A table: a row for each command, a column for each exit code."""
        codes = sorted({code for counter in self.codes.values() for code in counter}, key=str)
        heads = [*(f"exit {code}" for code in codes), "inputs"]
        rows = [("command", *heads)]
        total: Counter = Counter()
        for command in sorted(self.codes):
            counter = self.codes[command]
            total += counter
            rows.append((command, *(str(counter[c]) for c in codes), str(counter.total())))
        rows.append(("all", *(str(total[code]) for code in codes), str(total.total())))
        return ["".join(cell.ljust(11) for cell in row).rstrip() for row in rows]


def make_template(folder: Path, solve: Callable[[Path], None]) -> None:
    """A result folder ``cube`` that is real, ``other`` of the same spec by the stand-in, and
    ``studies`` with what each study leaves.

    solve: makes the result folder that it is given, of ``fuzz_inputs.CUBE``.
    """
    solve(folder / "cube")
    studies = folder / "studies"
    studies.mkdir()
    for name, text in FILES.items():
        (studies / name).write_text(text, encoding="utf-8")
    with _replaced(folder):
        for call in STUDIES:
            ended = in_process(call, studies, 60.0)
            if ended.code not in (0, 1, 3):
                raise RuntimeError(f"{shlex.join(call)}: {ended.err}{ended.where}")


def _replaced(template: Path) -> AbstractContextManager[None]:
    cube = template / "cube"
    return stand_ins(cube / "restart.npz", json.loads((cube / "run.json").read_text())["spec_hash"])


def solved(folder: Path) -> None:
    """The result folder of the cube, without pictures."""
    from softact import spec as specs
    from softact.run.start import run

    run(specs.loads(CUBE), folder, report=False)


def fuzz(
    inputs: int,
    number: int,
    template: Path,
    every: int = 0,
    keep: Path | None = None,
    told: Callable[[str], None] = lambda line: None,
    first: int = 0,
) -> Counts:
    """Make so many inputs by a seed and judge how each ends.

    every: one of so many is called as a program; 0: none. keep: where the folders of inputs that
    fail go. told: hears of these, and of how far it is. first: number of the first input, some
    multiple of ``BATCH``: what one seed gives may be called in parts.
    """
    counts = Counts()

    def one(call) -> None:
        done = first + sum(counter.total() for counter in counts.codes.values())
        program = bool(every) and done % every == 0 and call[0] in AS_PROGRAM
        _one(call, (number, done), program, template, counts, keep, told)
        if (done + 1) % 500 == 0:
            told(f"{done + 1} inputs, {len(counts.faults)} faults")

    names = commands()
    with _replaced(template):
        for batch, start in enumerate(range(first, first + inputs, BATCH), first // BATCH):
            drawn = settings(
                max_examples=min(BATCH, first + inputs - start),
                database=None,
                deadline=None,
                phases=[Phase.generate],
                suppress_health_check=list(HealthCheck),
            )(given(calls(names[batch % len(names)]))(one))
            seed(number * 10**6 + batch)(drawn)()
    return counts


def _one(call, place, program, template, counts, keep, told) -> None:
    number = place[1]
    with tempfile.TemporaryDirectory(prefix="fuzz-") as name:
        reach = Path(name)
        box, scratch = reach / "a" / "b" / "work", reach / "tmp"
        box.mkdir(parents=True)
        scratch.mkdir()
        made = prepare(call, random.Random("{} {}".format(*place)), template, box)
        with mock.patch.object(tempfile, "tempdir", str(scratch)), inside(box):
            before, started = listing(reach), time.monotonic()
            if program:
                counts.programs += 1
                ended = as_program(made.arguments, box, LIMIT_OF_PROGRAM_S)
            else:
                ended = in_process(made.arguments, box, LIMIT_S)
                counts.slowest = max(counts.slowest, time.monotonic() - started)
            after = listing(reach)
        counts.codes.setdefault(made.command, Counter())[ended.code] += 1
        if keep:
            _log(keep / "inputs.txt", number, made, ended)
        wrong = faults(made.arguments, ended, before, after)
        left = [path.name for path in scratch.iterdir()]
        wrong += [f"leaves {left[:3]} in the temporary folder"] if left else []
        if wrong:
            fault = Fault(number, shlex.join(made.arguments), made.told, wrong, ended)
            counts.faults.append(fault)
            for line in fault.lines():
                told(line)
            if keep:
                shutil.copytree(box, keep / f"{number:05d}", symlinks=True, dirs_exist_ok=True)


def _log(path: Path, number: int, made: Input, ended: Ended) -> None:
    """Add a line on an input: its number, exit code, call, and the last that it said."""
    last = ended.err.strip().rpartition("\n")[2]
    call = f"{shlex.join(made.arguments)} ({'; '.join(made.told)})"
    line = one_line(f"{number} [{ended.code}] {call}: {last}") + "\n"
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8", errors="backslashreplace") as file:
        file.write(line)


@click.command()
@click.option("--inputs", type=click.IntRange(1), default=5000, show_default=True)
@click.option("--seed", "number", type=click.IntRange(0), default=1, show_default=True)
@click.option(
    "--every",
    type=click.IntRange(0),
    default=50,
    show_default=True,
    help="One of so many is called as a program, with all that is real; 0: none.",
)
@click.option("--first", type=click.IntRange(0), default=0, help="Number of the first input.")
@click.option("--keep", type=click.Path(path_type=Path), default=Path("results/fuzz"))
def main(inputs: int, number: int, every: int, first: int, keep: Path) -> None:
    """Call softact with wrong inputs, count how it ends; exit 1 where one ends as none should."""
    started = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="fuzz-template-") as name:
        make_template(Path(name), solved)
        counts = fuzz(inputs, number, Path(name), every, keep.absolute(), click.echo, first)
    for line in counts.lines():
        click.echo(line)
    click.echo(
        f"{counts.programs} as programs; {time.monotonic() - started:.0f} s in all, "
        f"{counts.slowest:.1f} s the slowest in this process"
    )
    click.echo(f"{len(counts.faults)} faults")
    sys.exit(1 if counts.faults else 0)


if __name__ == "__main__":
    main()

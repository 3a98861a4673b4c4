"""Kill a run at random moments and resume it: ``python -m benchmarks.resume --kills 20``; or kill a
report that is written anew: ``python -m benchmarks.resume --command report --kills 20``.

Each trial of a run starts ``softact run`` anew, kills it and its solver with SIGKILL at a moment
drawn uniformly over the time that an undisturbed run takes, resumes it, and compares the curve with
that of the undisturbed run. Exits with 1 where a figure differs by more than 1e-7 of its size: two
processes add up in another order each time, by which undisturbed runs differ by 1e-8.
After a killed report each of the results must be what it was to the last byte, the page and the
pictures whole, and the next report as the first.
"""

from __future__ import annotations

import csv
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import click

SPEC = """
name: tiny
geometry: {type: pneunet, chambers: 2, mesh_size: 6 mm}
materials: {body: elastosil-m4601}
steps:
  - {name: gravity, gravity: [0, 0, -1]}
  - {name: inflate, pressure: 20 kPa, max_increment: 0.02}
"""
TOLERANCE = 1e-7
REPORT = ("report.html", "curve.png", "states.png", "shape.png")


@click.command()
@click.option("--command", type=click.Choice(["run", "report"]), default="run", show_default=True)
@click.option("--kills", type=click.IntRange(1), default=20, show_default=True)
@click.option("--seed", type=int, default=20131103, show_default=True)
def main(command: str, kills: int, seed: int) -> None:
    """Kill, go on and compare."""
    draw = random.Random(seed)
    with tempfile.TemporaryDirectory(prefix="softact-") as scratch:
        folder = Path(scratch)
        (folder / "tiny.yaml").write_text(SPEC)
        for _ in range(2):  # the first compiles
            started = time.monotonic()
            if start(folder, "whole").wait():
                sys.exit("the undisturbed run failed")
            took = time.monotonic() - started
        if command == "report":
            _reports(folder / "whole", kills, draw)
            return
        wanted = rows(folder / "whole")
        resumed, worst = 0, 0.0
        for trial in range(kills):
            name = f"out{trial}"
            moment = draw.uniform(0, took)
            kill_after(start(folder, name), moment)
            kept = len(rows(folder / name))
            resumed += kept > 0
            again = start(folder, name, "--resume")
            if again.wait():
                said = (folder / "errors.txt").read_text(encoding="utf-8")
                sys.exit(f"kill {trial} after {moment:.2f} s: the resumed run failed: {said}")
            status = json.loads((folder / name / "run.json").read_text())["status"]
            found = rows(folder / name)
            gap = difference(wanted, found) if len(wanted) == len(found) else float("inf")
            worst = max(worst, gap)
            click.echo(
                f"kill {trial:2d} after {moment:5.2f} s: {kept:2d} rows, then {status}, "
                f"largest difference {gap:.1e}"
            )
        click.echo(f"{kills} kills, {resumed} after the first row; largest difference {worst:.1e}")
        sys.exit(int(worst > TOLERANCE))


def _reports(run: Path, kills: int, draw: random.Random) -> None:
    """Kill the report of a run again and again."""

    def state() -> dict[str, bytes]:
        return {path.name: path.read_bytes() for path in run.iterdir() if path.name[0] != "."}

    results = {name: data for name, data in state().items() if name not in REPORT}
    started = time.monotonic()
    assert _start(run.parent, "report", run.name).wait() == 0
    took = time.monotonic() - started
    page = state()["report.html"]
    for trial in range(kills):
        moment = draw.uniform(0, took)
        for name in REPORT[: draw.randrange(2) * len(REPORT)]:  # of every second one, all is gone
            (run / name).unlink(missing_ok=True)
        kill_after(_start(run.parent, "report", run.name), moment)
        found = state()
        written = [name for name in REPORT if name in found]
        assert {name: found[name] for name in results} == results, f"kill {trial}: results changed"
        assert found.keys() <= {*results, *REPORT}, f"kill {trial}: left {found.keys()}"
        for name in written:
            end = b"</html>" if name.endswith("html") else b"IEND"
            assert end in found[name][-12:], f"kill {trial}: {name} is cut off"
        click.echo(f"kill {trial:2d} after {moment:5.2f} s: {', '.join(written) or 'nothing'}")
    assert _start(run.parent, "report", run.name).wait() == 0
    assert state()["report.html"] == page, "the report after the kills is another"
    click.echo(f"{kills} kills; results untouched, no page or picture cut off")


def start(folder: Path, name: str, *options: str) -> subprocess.Popen:
    """``softact run`` in a session of its own."""
    return _start(folder, "run", "tiny.yaml", "-o", name, *options)


def _start(folder: Path, *words: str) -> subprocess.Popen:
    command = [sys.executable, "-m", "softact.cli.main", *words]
    with (folder / "errors.txt").open("w", encoding="utf-8") as errors:
        return subprocess.Popen(
            command, cwd=folder, start_new_session=True, stdout=subprocess.DEVNULL, stderr=errors
        )


def kill_after(process: subprocess.Popen, seconds: float) -> None:
    """Kill the command and the processes that it has started by then."""
    time.sleep(seconds)
    listing = ["pgrep", "-P", str(process.pid)]
    children = subprocess.run(listing, capture_output=True, text=True, check=False).stdout.split()
    for pid in (process.pid, *map(int, children)):
        for kill in (os.killpg, os.kill):
            try:
                kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                continue
    process.wait()


def rows(directory: Path) -> list[dict[str, str]]:
    """Rows of the curve so far."""
    try:
        with (directory / "curve.csv").open() as file:
            return list(csv.DictReader(file))
    except FileNotFoundError:
        return []


def difference(wanted, found) -> float:
    """Largest difference of a figure by the largest value in its column (mm, deg, MPa, ...), where
    that is not rounding (1e-6); inf where one has a figure that the other has not."""
    worst = 0.0
    for name in wanted[0]:
        if name in ("step", "control", "residual"):
            continue
        texts = [(a[name], b[name]) for a, b in zip(wanted, found, strict=True)]
        if any(bool(a) != bool(b) for a, b in texts):
            return float("inf")
        pairs = [(float(a), float(b)) for a, b in texts if a]
        size = max((abs(a) for a, _ in pairs), default=0.0)
        gap = max((abs(a - b) for a, b in pairs if a != b), default=0.0)
        worst = max(worst, gap / max(size, 1e-6))
    return worst


if __name__ == "__main__":
    main()

"""Damages files of a result folder in ways that are drawn: cut, zeroed, flipped, edited.

``python -m benchmarks.damaging --count 200`` damages the folder of a run that was killed and goes
on with ``softact run --resume``: each time either to the figures of the undisturbed run, or refused
with a line that names the file and says what to do.
"""

import csv
import io
import json
import random
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

import click
import h5py
import numpy as np

from benchmarks import resume

Damage = Callable[[bytearray, random.Random], bytearray]
TEXTS = ("run.json", "spec.yaml", "curve.csv", "summary.csv", "mesh_error.json")
#: What a run leaves, and what is read again.
FILES = (*TEXTS, "fields.h5", "restart.npz")


def cut(raw, draw):
    return raw[: draw.randrange(len(raw))]


def empty(raw, draw):
    return bytearray()


def zeroed(raw, draw):
    start = draw.randrange(len(raw))
    length = draw.choice((1, 16, 512, len(raw)))
    raw[start : start + length] = bytes(len(raw[start : start + length]))
    return raw


def bits(raw, draw):
    for _ in range(draw.choice((1, 1, 3, 20))):
        raw[draw.randrange(len(raw))] ^= 1 << draw.randrange(8)
    return raw


def noise(raw, draw):
    start, length = draw.randrange(len(raw)), draw.choice((1, 4, 64, 1000))
    raw[start : start + length] = draw.randbytes(length)
    return raw


def block_lost(raw, draw):
    start = draw.randrange(len(raw))
    del raw[start : start + draw.choice((1, 7, 100, 4096))]
    return raw


def block_twice(raw, draw):
    start, length = draw.randrange(len(raw)), draw.choice((1, 7, 100, 4096))
    raw[start:start] = raw[start : start + length]
    return raw


def line_lost(raw, draw):
    lines = raw.splitlines(keepends=True)
    del lines[draw.randrange(len(lines))]
    return bytearray(b"".join(lines))


def column_lost(raw, draw):
    rows = list(csv.reader(io.StringIO(raw.decode())))
    place = draw.randrange(len(rows[0]))
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(row[:place] + row[place + 1 :] for row in rows)
    return bytearray(out.getvalue().encode())


def cell_replaced(raw, draw):
    rows = list(csv.reader(io.StringIO(raw.decode())))
    row = draw.choice(rows)
    row[draw.randrange(len(row))] = draw.choice(
        ("", "nan", "inf", "-1e308", "1e400", "x", "\N{SNOWMAN}", "0x10", "1_0", '"', "1,2", "=1")
    )
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return bytearray(out.getvalue().encode())


def value_replaced(raw, draw):
    """Of JSON, anywhere in it."""
    data = json.loads(raw)
    at = data
    while True:
        keys = list(at) if isinstance(at, dict) else range(len(at))
        key = draw.choice(list(keys))
        if isinstance(at[key], dict | list) and at[key] and draw.random() < 0.8:
            at = at[key]
            continue
        at[key] = draw.choice((None, True, -1, 1e308, "x", [], {}, [1], {"a": 1}, 10**30))
        return bytearray(json.dumps(data).encode())


def key_lost(raw, draw):
    data = json.loads(raw)
    inner = [v for v in data.values() if isinstance(v, dict) and v]
    at = draw.choice([data, *inner])
    del at[draw.choice(list(at))]
    return bytearray(json.dumps(data).encode())


ANY = (cut, empty, zeroed, bits, bits, noise, noise, block_lost, block_twice)
KINDS = {
    "run.json": (*ANY, line_lost, value_replaced, value_replaced, key_lost),
    "mesh_error.json": (*ANY, line_lost, value_replaced, key_lost),
    "spec.yaml": (*ANY, line_lost),
    "curve.csv": (*ANY, line_lost, column_lost, column_lost, cell_replaced, cell_replaced),
    "summary.csv": (*ANY, line_lost, column_lost, cell_replaced),
    "fields.h5": ANY,
    "restart.npz": ANY,
}


def damage(folder: Path, draw: random.Random, files: Sequence[str] = FILES) -> tuple[str, str]:
    """Damage one of some files of a result folder; returns its name and how."""
    name = draw.choice([name for name in files if (folder / name).exists()])
    path = folder / name
    if draw.random() < 0.05:
        path.unlink()
        if draw.random() < 0.5:
            path.mkdir()
            return name, "a folder"
        return name, "missing"
    if name == "fields.h5" and draw.random() < 0.3:
        return name, rewritten(path, draw)
    kind = draw.choice(KINDS[name])
    path.write_bytes(kind(bytearray(path.read_bytes()), draw))
    return name, kind.__name__


def rewritten(path: Path, draw: random.Random) -> str:
    """Replace or remove a part of an HDF5 file, which stays sound as such."""
    with h5py.File(path, "a") as file:
        names: list[str] = []
        file.visit(names.append)
        name = draw.choice(names)
        how = draw.choice(("lost", "other numbers", "other shape", "text", "empty", "huge"))
        old = file[name]
        numbers = isinstance(old, h5py.Dataset) and old.dtype.kind in "iuf"
        data = old[()] if numbers else np.zeros((2, 3))
        del file[name]
        if how == "other numbers":
            file[name] = data * -(10**9) if data.dtype.kind == "f" else data + 10**6
        elif how == "other shape":
            file[name] = data.reshape(-1)[: data.size // 2]
        elif how == "text":
            file[name] = "not what it was"
        elif how == "empty":
            file[name] = np.zeros(0)
        elif how == "huge":
            file.create_dataset(name, (10**9, 3), "f8", chunks=(1000, 3))
    return f"{how}: {name}"


SPEC = """
name: cube
geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
steps: [{name: pull, traction: {surface: x_max, value: [20 kPa, 0 kPa, 0 kPa]}}]
solver: {initial_increment: 0.1, max_increment: 0.1}
"""


@click.command()
@click.option("--count", type=click.IntRange(1), default=200, show_default=True)
@click.option("--seed", type=int, default=1, show_default=True)
def main(count: int, seed: int) -> None:
    """Damage, go on and compare."""
    draw, ends = random.Random(seed), Counter()
    with tempfile.TemporaryDirectory(prefix="softact-") as scratch:
        folder = Path(scratch)
        (folder / "cube.yaml").write_text(SPEC)
        command = [sys.executable, "-m", "softact.cli.main", "run", "cube.yaml", "-n", "1", "-o"]

        def called(*words: str) -> subprocess.CompletedProcess:
            return subprocess.run(
                [*command, *words], cwd=folder, capture_output=True, text=True, check=False
            )

        assert called("whole").returncode == 0
        wanted = resume.rows(folder / "whole")
        _cut_short(folder, command)
        for number in range(count):
            shutil.rmtree(folder / "out", ignore_errors=True)
            shutil.copytree(folder / "begun", folder / "out")
            name, how = damage(folder / "out", draw)
            done = called("out", "--resume")
            lines = done.stderr.splitlines()
            if done.returncode == 0:
                rows = resume.rows(folder / "out")
                gap = resume.difference(wanted, rows) if len(rows) == len(wanted) else np.inf
                assert gap <= resume.TOLERANCE, f"{number}: {name} {how}: off by {gap:.1e}"
                ends[f"{name}: as undisturbed"] += 1
            else:
                said = len(lines) == 1 and name in lines[0] and done.returncode == 2
                assert said, f"{number}: {name} {how}: exit code {done.returncode}: {lines}"
                ends[f"{name}: refused"] += 1
    for end, times in sorted(ends.items()):
        click.echo(f"{times:4d} {end}")
    click.echo(f"{count} damaged files: each resumed to the same figures, or refused in one line")


def _cut_short(folder: Path, command: Sequence[str]) -> None:
    """The folder "begun" of a run that was killed after some increments."""
    process = subprocess.Popen(
        [*command, "begun"], cwd=folder, start_new_session=True, stdout=subprocess.DEVNULL
    )
    while process.poll() is None and len(resume.rows(folder / "begun")) < 5:
        pass
    resume.kill_after(process, 0.0)
    assert 5 <= len(resume.rows(folder / "begun")) < 11, "the run was not killed on its way"


if __name__ == "__main__":
    main()

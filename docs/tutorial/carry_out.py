"""Carries out a tutorial: writes its files, calls its commands, compares or renews what they print.

    .venv/bin/python docs/tutorial/carry_out.py PAGE [--write]

A line that is nothing but a name in backticks and a colon says what the block of code after it is
called. Each `sh` block is one script; a `text` block right after it is what it prints, less the lines
that tell of progress. `console` blocks are only shown. --write puts what was printed into the page.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

FILE = re.compile(r"^`([^`\n]+)`:\n\n```\w+\n(.*?)^```$", re.S | re.M)
CALL = re.compile(r"^```sh\n(.*?)^```$(?:\n\n```text\n(.*?)^```$)?", re.S | re.M)
PROGRESS = re.compile(r"^ +\d+\.\d s ")  # what `softact run` tells while it runs
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
TOLERANCE = 0.02  # of a figure: gmsh's meshes differ between its releases


def carry_out(page: Path, folder: Path) -> Iterator[tuple[re.Match[str], str]]:
    """Each call of the page and what it printed, in order."""
    text = page.read_text(encoding="utf-8")
    for name, content in FILE.findall(text):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(content, encoding="utf-8")
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for call in CALL.finditer(text):
        done = subprocess.run(
            ["sh", "-ec", call[1]],
            cwd=folder,
            env={**os.environ, "PATH": path, "COLUMNS": "100"},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="utf-8",
        )
        printed = "".join(
            line for line in done.stdout.splitlines(keepends=True) if not PROGRESS.match(line)
        )
        if done.returncode:
            raise AssertionError(f"{call[1]}ended with {done.returncode}:\n{done.stdout}")
        yield call, printed


def difference(shown: str, printed: str) -> str:
    """The first line that differs by more than figures may; empty where none does."""
    for one, other in zip((shown + "\0").split("\n"), (printed + "\0").split("\n"), strict=False):
        words = [" ".join(NUMBER.sub("#", line).split()) for line in (one, other)]
        figures = [[float(n) for n in NUMBER.findall(line)] for line in (one, other)]
        if words[0] != words[1] or any(
            abs(a - b) > TOLERANCE * max(abs(a), abs(b)) for a, b in zip(*figures, strict=True)
        ):
            return f"the page has {one!r}, the command prints {other!r}"
    return ""


def renewed(page: Path, calls: list[tuple[re.Match[str], str]]) -> str:
    """The page with what its calls printed, where it shows that."""
    text = page.read_text(encoding="utf-8")
    for call, printed in reversed(calls):
        if call[2] is not None:
            text = text[: call.start(2)] + printed + text[call.end(2) :]
    return text


def main() -> None:
    """Carry out one page."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("page", type=Path)
    parser.add_argument("--write", action="store_true", help="renew what the page shows")
    wanted = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        calls = list(carry_out(wanted.page, Path(folder)))
    for call, printed in calls:
        print(call[1] + printed)
        if call[2] is not None and (found := difference(call[2], printed)):
            print("!", found)
    if wanted.write:
        wanted.page.write_text(renewed(wanted.page, calls), encoding="utf-8")


if __name__ == "__main__":
    main()

"""Carries out a tutorial or a notebook, and compares or renews what it shows.

    .venv/bin/python docs/tutorial/carry_out.py PAGE [--write]

A line that is nothing but a name in backticks and a colon says what the block of code after it is
called. Each `sh` block is one script; a `text` block right after it is what it prints, less the
lines that tell of progress. `console` blocks are only shown. --write puts what was printed into
the page.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

FILE = re.compile(r"^`([^`\n]+)`:\n\n```\w+\n(.*?)^```$", re.S | re.M)
CALL = re.compile(r"^```sh\n(.*?)^```$(?:\n\n```text\n(.*?)^```$)?", re.S | re.M)
PROGRESS = re.compile(r"^ +\d+\.\d s ")  # what `softact run` tells while it runs
DURATION = re.compile(r"(?:\d+ min )?\d+(?:\.\d+)? s\b")
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
    texts = ((DURATION.sub("some s", text) + "\0").split("\n") for text in (shown, printed))
    for one, other in zip(*texts, strict=False):
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


def executed(path: Path, folder: Path) -> Any:
    """A notebook with what its cells put out in ``folder``, less warnings."""
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(path, as_version=4)
    resources = {"metadata": {"path": str(folder)}}
    NotebookClient(notebook, timeout=600, resources=resources).execute()
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)
        if "outputs" in cell:
            cell.outputs = [output for output in cell.outputs if output.get("name") != "stderr"]
    return notebook


def renew_notebook(path: Path) -> None:
    """Execute a notebook and keep what its cells put out."""
    import nbformat

    with tempfile.TemporaryDirectory() as folder:
        nbformat.write(executed(path, Path(folder)), path)


def main() -> None:
    """Carry out one page."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("page", type=Path)
    parser.add_argument(
        "--write", action="store_true", help="renew what the page shows; a notebook always is"
    )
    wanted = parser.parse_args()
    if wanted.page.suffix == ".ipynb":
        renew_notebook(wanted.page)
        return
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

"""One input of the fuzzer: a folder with files in it, and a call of softact in that folder.

Commands and their options are taken from the command line itself, so that a new one is fuzzed too.
"""

from __future__ import annotations

import random
import shutil
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import click
import yaml
from hypothesis import strategies as st

from benchmarks.fuzz_mutations import ODD_TEXTS, changed, damage, odd, paths_of
from softact.cli.main import softact

CONFIGS = Path(__file__).resolve().parent.parent / "configs"
TEMPLATE = "cube.yaml"
CUBE = """\
name: cube
geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 2 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps: [{name: pull, traction: {surface: x_max, value: [20 kPa, 0 kPa, 0 kPa]}}]
solver: {initial_increment: 0.2, max_increment: 0.2}
"""
SWEEP = """\
name: walls
base: cube.yaml
axes:
  - {name: length, path: geometry.length, values: [3 mm, 4 mm, 5 mm]}
  - {path: materials.body.c10, from: 0.1 MPa, to: 0.2 MPa, count: 2}
trends: [{measure: elongation_mm, axis: length, does: rise, source: by hand}]
"""
OPTIMISATION = """\
name: best
base: cube.yaml
parameters:
  - {path: geometry.length, name: length, from: 3 mm, to: 5 mm}
  - {path: geometry.width, values: [2 mm, 3 mm]}
objectives: [{measure: elongation_mm, goal: maximise}]
constraints: [{measure: max_principal_stress_MPa, below: 10}]
trials: 3
"""
CASE = f"""\
description: A cube that is pulled
spec: {yaml.safe_dump(yaml.safe_load(CUBE), default_flow_style=True, width=10**6).strip()}
values:
  - {{measure: elongation_mm, value: 0.1, tolerance: 0.5, kind: computed, source: softact itself}}
"""
TESTS = """\
tests:
  - {file: data.csv, mode: uniaxial, points: 10}
  - {file: data.csv, mode: planar, zero: true}
"""
TENSION = "stretch,nominal stress (kPa)\n" + "".join(
    f"{1 + n / 10:.1f},{100 * (1 + n / 10 - (1 + n / 10) ** -2):.4f}\n" for n in range(20)
)
MEASURED = "step_fraction,elongation (mm)\n0,0\n0.2,0.02\n0.6,0.06\n1,0.1\n"
FILES = {
    "cube.yaml": CUBE,
    "sweep.yaml": SWEEP,
    "opt.yaml": OPTIMISATION,
    "case.yaml": CASE,
    "tests.yaml": TESTS,
    "data.csv": TENSION,
    "curve.csv": MEASURED,
}
#: Values of options that make a call do something, and little of it.
FITTING = {
    "measured": ["curve.csv"], "data": ["curve.csv"], "columns": ["step_fraction, elongation mm"],
    "targets": ["glove", "index_finger"], "law": ["yeoh", "neo_hookean", "ogden_1", "gent"],
    "vary": ["materials.body.c10", "geometry.length=3 mm..5 mm"], "max_runs": ["2", "3"],
    "processes": ["1", "2"], "jobs": ["1", "2"], "trials": ["1", "3"], "most": ["2", "3"],
    "starts": ["1", "2"], "length": ["30 mm"], "width": ["10 mm"], "thickness": ["2 mm"],
    "area": ["20 mm^2"], "cycle": ["1", "last"], "toe": ["1 kPa"], "stretch_from": ["1.1"],
    "stretch_to": ["1.8"], "smooth": ["5"], "points": ["8"], "sigma": ["1 kPa"],
    "fix": ["c20=0 kPa"],
    "compare": ["ecoflex-00-30", "card.yaml"], "density": ["1000 kg/m^3"], "strength": ["1 MPa"],
    "method": ["least-squares", "Nelder-Mead", "COBYLA"], "name": ["mine"], "x": ["step_fraction"],
    "measures": ["elongation_mm", "max_principal_stress_MPa"], "tolerance": ["5 %", "0.1"],
    "factor": ["1.5", "2"], "into": ["other", "other", "cube"], "timeout": ["10"],
    "cache_folder": ["runs"],
    "junit_file": ["check.xml"], "reason": ["mended"], "seed": ["1"], "interface": ["lo"],
    "slurm_option": ["queue=short"], "output": ["out", "cube", "studies/results/walls", "x/y"],
}  # fmt: skip
#: Options that would reach beyond this machine.
BEYOND = ("slurm", "scheduler")
SPECS = ("cube.yaml", "cube.yaml", "spec.yaml")
ARGUMENTS = {
    "run": SPECS, "mesh": SPECS, "converge": SPECS, "calibrate": SPECS,
    "validate": ("spec.yaml", "spec.yaml", *FILES, "card.yaml", "cube", "cube/run.json"),
    "report": ("cube", "cube", "cube", "studies/results/walls", "studies"),
    "compare": ("cube", "other", "cube", "other", "studies/results/walls"),
    "fit": ("data.csv", "data.csv:planar", "data.csv:compression", "tests.yaml", "curve.csv"),
    "check": ("case.yaml", "case.yaml", "pulled"), "optimize": ("opt.yaml",),
    "sweep": ("sweep.yaml",),
    "list": ("yeoh", "ecoflex-00-30", "pneunet", "bending", "pressure"), "schema": (), "doctor": (),
}  # fmt: skip
#: How often each is called; those that read the most, the most.
WEIGHTS = {"run": 5, "validate": 8, "report": 5, "compare": 4, "sweep": 4, "fit": 4, "converge": 3,
           "optimize": 3, "calibrate": 3, "check": 3, "mesh": 3, "schema": 1, "list": 1,
           "doctor": 1}  # fmt: skip


@dataclass
class Input:
    """What is called, and in what folder. told: how the files there were made wrong."""

    command: str
    arguments: list[str]
    told: list[str] = field(default_factory=list)


def _safe(text: str) -> str:
    """The same, such that a path stays in the folder and a program can be called with it."""
    text = text.replace("\0", "")
    return f"x{text}" if text.startswith(("/", "~")) or "../.." in text else text


TEXTS = st.one_of(st.sampled_from(ODD_TEXTS), st.text(max_size=10)).map(_safe)


def commands() -> list[str]:
    """All commands that softact has: first each of them, in all as often as their weight says."""
    names = softact.list_commands(click.Context(softact))
    weights = [WEIGHTS.get(name, 2) for name in names]
    return [
        name
        for time in range(max(weights))
        for name, weight in zip(names, weights, strict=True)
        if time < weight
    ]


def _one_in(draw: Callable, count: int) -> bool:
    """True once in so many times; Hypothesis prefers the ends of a range."""
    return draw(st.integers(0, count - 1)) == count // 2


def _values(parameter: click.Parameter, paths: list[str]) -> st.SearchStrategy[str]:
    if isinstance(parameter.type, click.Choice):
        return st.sampled_from(parameter.type.choices)
    if parameter.name == "overrides":
        values = st.one_of(TEXTS, st.sampled_from(["1 mm", "2", "20 kPa", "[x]", "{a: 1}", "null"]))
        return st.builds("{}={}".format, st.sampled_from(paths), values)
    return st.sampled_from(FITTING.get(parameter.name, ["1"]))


def _drawn_options(draw: Callable, command: click.Command, paths: list[str]) -> list[str]:
    found = []
    known = [p for p in command.params if isinstance(p, click.Option) and p.name not in BEYOND]
    for option in known:
        if not (option.required or _one_in(draw, max(4, len(known) // 2))):
            continue
        found.append(option.opts[-1])
        if not option.is_flag:
            wrong = _one_in(draw, 15)
            found.append(draw(TEXTS if wrong else _values(option, paths)))
    return found


def _drawn_arguments(draw: Callable, name: str, command: click.Command) -> list[str]:
    found = []
    for argument in command.params:
        if not isinstance(argument, click.Argument):
            continue
        if isinstance(argument.type, click.Choice):
            found.append(draw(st.sampled_from(argument.type.choices)))
            continue
        many = argument.nargs == -1
        fewest = 1 if argument.required else 0
        count = draw(st.sampled_from((fewest, 1, 2, 2, 3) if many else (1,)))
        usual = st.sampled_from(ARGUMENTS.get(name) or ("cube.yaml", "cube"))
        rare = st.one_of(TEXTS, st.sampled_from([*FILES, "cube", "studies"]))
        for _ in range(count):
            found.append(draw(rare if _one_in(draw, 25) else usual))
    return found


@st.composite
def calls(draw: Callable, name: str) -> tuple[str, list[str]]:
    """A command and its arguments. name: of the command."""
    command = softact.get_command(click.Context(softact), name)
    arguments = _drawn_arguments(draw, name, command)
    options = _drawn_options(draw, command, paths_of(CUBE))
    if name == "run" and draw(st.booleans()):
        options += ["--resume", "-o", "cube"]
    if _one_in(draw, 40):
        options += draw(st.lists(TEXTS, min_size=1, max_size=2))
    return name, [*arguments, *options]


def prepare(call: tuple[str, list[str]], draw: random.Random, template: Path, box: Path) -> Input:
    """Fill a folder with the files that a call reads, some of them made wrong."""
    name, arguments = call
    made = Input(name, [name, *arguments])
    drawn = draw.choice(sorted(CONFIGS.glob("*.yaml")))
    cards = CONFIGS.parent / "softact" / "cards"
    texts = FILES | {
        "spec.yaml": drawn.read_text(encoding="utf-8"),
        "card.yaml": draw.choice(sorted(cards.glob("*.yaml"))).read_text(encoding="utf-8"),
    }
    if name == "check":  # those that it knows by name
        texts["configs/reference/pulled.yaml"] = CASE
    named = [n for n in texts if any(n in argument for argument in arguments)]
    named += ["configs/reference/pulled.yaml"] if "pulled" in arguments else []
    wrong = draw.choice(named) if named and draw.random() < 0.7 else None
    if wrong == "sweep.yaml" and draw.random() < 0.3:
        wrong = "cube.yaml"  # its base
    for file, text in texts.items():
        times = draw.choice((1, 1, 2, 4)) if file == wrong else 0
        (box / file).parent.mkdir(parents=True, exist_ok=True)
        (box / file).write_bytes(_content(file, text, times, draw))
        if times:
            made.told.append(f"{file} changed")
    roots = {argument.split("/")[0] for argument in arguments}
    folders = [folder for folder in ("cube", "other", "studies") if folder in roots]
    studies = name in ("sweep", "optimize", "converge", "calibrate") and draw.random() < 0.4
    for folder in folders:
        shutil.copytree(template / folder, box / folder)
    if studies:  # goes on with what an earlier call has left
        shutil.copytree(template / "studies" / "results", box / "results")
        folders.append("results")
    for folder in folders:
        for _ in range(draw.choice((0, 1, 1, 2))):
            made.told.append(f"{folder}/{damage(box / folder, draw)}")
    return made


def _content(file: str, text: str, times: int, draw: random.Random) -> bytes:
    if not times:
        return text.encode()
    if file.endswith(".yaml"):
        return changed(text, times, draw)
    lines = text.splitlines()
    for _ in range(times):
        row = draw.randrange(len(lines))
        cells = lines[row].split(",")
        cells[draw.randrange(len(cells))] = str(odd(draw))
        lines[row] = draw.choice((",", ",", ",", ";", "\t", " ")).join(cells)
    whole = draw.choice(("\n", "\n", "\r\n", "\r")).join(lines)
    code = draw.choice(("utf-8", "utf-8", "utf-16", "latin-1"))
    return whole.encode(code, "backslashreplace")

"""Writes how far estimates are from coarse runs into docs/estimate.md.

`.venv/bin/python docs/estimate_table.py`, called by `make docs`; `--fit` prints how well the two
fitted numbers meet their rows. The runs' figures stand in
docs/estimate_runs.yaml with what makes the runs again; the estimates are made anew.
"""

import math
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

import yaml

from softact import spec as specs
from softact.estimate import estimate, reach
from softact.report.labels import column, number

PAGE, DATA = (Path(__file__).with_name(name) for name in ("estimate.md", "estimate_runs.yaml"))
CONFIGS = PAGE.parents[1] / "configs"
BEGIN = "<!-- written by docs/estimate_table.py from docs/estimate_runs.yaml; do not edit -->"
END = "<!-- end of what docs/estimate_table.py writes -->"


def compared() -> Iterator[tuple[dict, float, list[str]]]:
    """Each run of the data, the estimate for it, and the reservations that come with that."""
    for run in yaml.safe_load(DATA.read_text(encoding="utf-8")):
        found = estimate(specs.load(CONFIGS / f"{run['spec']}.yaml", run["set"]))
        yield run, found.at(run["column"], run["pressure_kPa"]), list(found.reservations)


def lines(rows: Iterable[tuple[dict, float, list[str]]]) -> Iterator[str]:
    """The table."""
    yield "| spec | with | at | figure | run | estimate | off by | said to be poor |"
    yield "| --- | --- | --- | --- | --- | --- | --- | --- |"
    for run, value, reservations in rows:
        label = column(run["column"])
        changed = ", ".join(
            text.removeprefix("geometry.") for text in run["set"]
            if not text.startswith(("steps", "solver", "geometry.mesh_size"))
        ) or "as it is"  # fmt: skip
        yield (
            f"| `{run['spec']}` | {changed} | {run['pressure_kPa']:g} kPa | {label.name.lower()} | "
            f"{number(run['run'])} {label.unit} | {number(value)} {label.unit} | "
            f"{100 * (value / run['run'] - 1):+.0f} % | {'yes' if reservations else ''} |"
        )


def written(text: str, rows: Iterable[tuple[dict, float, list[str]]]) -> str:
    """The page's text with the part between the two marks made anew."""
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    return before + "\n".join([BEGIN, "", *lines(rows), "", END]) + after


def fit() -> Iterator[str]:
    """How far the rows to which two numbers were fitted are off, with these and others."""
    best, rows = (reach.GIVES, reach.SPREAD), []
    for run in yaml.safe_load(DATA.read_text(encoding="utf-8")):
        bellows = run["spec"] == "xavier_three_cavities" and "geometry.modules=3" in run["set"]
        spec = specs.load(CONFIGS / f"{run['spec']}.yaml", run["set"])
        if (bellows or run["spec"] == "pneunet_small") and not estimate(spec).reservations:
            rows.append((run, spec))
    gives, spread = best
    for pair in (best, (0.54, spread), (0.62, spread), (gives, 0.2), (gives, 0.4)):
        reach.GIVES, reach.SPREAD = pair
        found = (estimate(spec).at(run["column"], run["pressure_kPa"]) for run, spec in rows)
        off = [value / run["run"] - 1 for value, (run, _) in zip(found, rows, strict=True)]
        mean = math.sqrt(sum(part**2 for part in off) / len(off))
        yield f"{pair[0]}, {pair[1]}: root mean square {100 * mean:.1f} % of {len(off)} rows"


if __name__ == "__main__" and sys.argv[1:] == ["--fit"]:
    print(*fit(), sep="\n")
elif __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8"), compared()), encoding="utf-8")

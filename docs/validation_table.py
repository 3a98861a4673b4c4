"""Writes the published figures beside softact's into docs/validation.md; computes only on demand.

`.venv/bin/python docs/validation_table.py`. softact's figures come from
docs/published/results.json; `--compute` fills it: all runs that are not there or have changed, or
those that are named (`--compute xavier_3_one palacios_upper`, `--again` where they are there; large
ones only so).
Finished runs are kept in a sweep's cache ($SOFTACT_CACHE or results/.runs) and never done twice.
"""

import argparse
import sys
from pathlib import Path

from published import figures, page, results

PAGE = Path(__file__).with_name("validation.md")
BEGIN = "<!-- written by docs/validation_table.py from docs/published/; do not edit -->"
END = "<!-- end of what docs/validation_table.py writes -->"


def written(text: str) -> str:
    """The page's text with the part between the two marks made anew. Raises ValueError."""
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"{PAGE.name} lacks the line '{END if begin else BEGIN}'")
    part = "\n".join(page.lines(figures.read(), results.read()))
    return f"{before}{BEGIN}\n\n{part}\n\n{END}{after}"


def options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--compute", nargs="*", metavar="RUN", help="compute runs; without names all that lack")
    add("--again", action="store_true", help="compute the named runs although they are there")
    add("--limit", type=float, default=300.0, metavar="S", help="stop a run after S seconds (300)")
    add("--cache", metavar="DIR", help="folder of the finished runs")
    add("--list", action="store_true", help="list the runs and how they ended")
    return parser.parse_args()


def compute(names: list[str], again: bool, limit: float, cache_folder: str | None) -> None:
    """Compute runs and store what was read off them, each as soon as it has ended."""
    import os

    from published.compute import outcome_of

    from softact.sweep.cache import DEFAULT, Cache

    cache = Cache(Path(cache_folder or os.environ.get("SOFTACT_CACHE") or DEFAULT), warn=print)
    runs = {name: (source, run) for source in figures.read() for name, run in source.runs.items()}
    unknown = [name for name in names if name not in runs]
    if unknown:
        sys.exit(f"there is no run {unknown[0]} in {figures.DATA.name}; --list tells them")
    for name in names or runs:
        source, run = runs[name]
        read_off = [figure for figure in source.figures if name in figure.runs]
        known = results.read().get(name)
        if known and not again and page.is_current(known, run, read_off):
            continue
        if run.large and not names:
            continue
        print(f"{name}: {run.command()}", flush=True)
        found = outcome_of(run, read_off, cache, limit, lambda line: print(f"  {line}", flush=True))
        results.store(name, found)
        print(f"{name}: {found.status} {found.cause} ({found.seconds} s)", flush=True)


if __name__ == "__main__":
    given = options()
    if given.compute is not None:
        compute(given.compute, given.again, given.limit, given.cache)
    if given.list:
        print("\n".join(page.listed(figures.read(), results.read())))
    else:
        PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
        print(f"wrote {PAGE}")

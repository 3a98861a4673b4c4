"""Draws requirements.png, after Agarwal et al. 2016, Fig. 3g: the force that applications ask for
at a pressure (softact/report/targets.yaml), and what softact computed for the papers' actuators
(docs/published/results.json).

    .venv/bin/python docs/images/requirements.py
"""

import json
import re
from pathlib import Path

import yaml
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

ROOT = Path(__file__).resolve().parents[2]
# Name of a run in docs/published/figures.yaml -> its name in the picture, its pressure in kPa.
RUNS = {
    "glove_blocked_116": ("PneuNet of the glove", 43),
    "agarwal_linear_50mm_blocked": ("slit shell, linear", 50),
    "epfl_blocked": ("slow PneuNet, EPFL", 55),
    "xavier_4_one_blocked": ("omnidirectional, resin", 200),
    "xavier_4_one_ninjaflex_blocked": ("omnidirectional, NinjaFlex", 700),
    "finger_fiber_blocked": ("fibre-reinforced finger", 206),
    "finger_knit_blocked": ("knit finger", 206),
    "fabric_bending_blocked": ("woven, bending", 206),
    "fabric_elongating_blocked": ("woven stack", 206),
    "fabric_contracting_blocked": ("woven, contracting", 170),
    "knit_elongating_blocked": ("knit, elongating", 206),
}
FORCES = ("force", "pull")
# Where what is asked for at 40 kPa leaves no room on the left for a name, kPa.
CROWDED = 70


def computed(results: dict) -> list[tuple[str, float, float]]:
    """Name, pressure (kPa) and force (N) of each run that has one."""
    found = []
    for run, (name, pressure) in RUNS.items():
        readings = results.get(run, {}).get("readings", {})
        values = [
            reading["value"]
            for figure, reading in readings.items()
            if any(word in figure for word in FORCES) and reading.get("value") is not None
        ]
        if values:
            found.append((name, pressure, values[-1]))
    return found


def asked(targets: dict) -> list[tuple[str, float, float]]:
    """Title, pressure (kPa) and force (N) of each application that names both."""
    found = []
    for target in targets["targets"].values():
        for wanted in target["requirements"]:
            if wanted.get("figure") == "blocked_force_N" and "at" in wanted:
                force, pressure = (
                    float(re.match(r"[\d.]+", wanted[key])[0]) for key in ("at_least", "at")
                )
                found.append((target["title"], pressure, force))
    return found


def shared(entries: list[tuple[str, float, float]]) -> list[tuple[str, float, float]]:
    """Names of entries that lie at one place together."""
    places: dict[tuple[float, float], list[str]] = {}
    for name, pressure, force in entries:
        near = (p for p in places if p[0] == pressure and abs(p[1] / force - 1) < 0.2)
        places.setdefault(next(near, (pressure, force)), []).append(name)
    return [("\n".join(names), *place) for place, names in places.items()]


def main() -> None:
    """Draw it."""
    targets = yaml.safe_load((ROOT / "softact/report/targets.yaml").read_text())
    results = json.loads((ROOT / "docs/published/results.json").read_text())
    figure = Figure(figsize=(9.6, 5.6), dpi=100)
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    for entries, marker, colour, label in (
        (asked(targets), "_", "#d55e00", "asked for (Agarwal 2016, Fig. 1a): at least"),
        (computed(results), "o", "#0072b2", "computed by softact, blocked"),
    ):
        pressures, forces = [p for _, p, _ in entries], [f for *_, f in entries]
        size = 14 if marker == "_" else 6
        axes.plot(pressures, forces, marker, color=colour, markersize=size, markeredgewidth=2,
                  label=label)  # fmt: skip
        for name, pressure, force in shared(entries):
            right = marker == "o" or pressure == CROWDED
            axes.annotate(name, (pressure, force), xytext=(9 if right else -9, 0), color=colour,
                          textcoords="offset points", va="center", fontsize=8,
                          ha="left" if right else "right")  # fmt: skip
    axes.set(xscale="log", yscale="log", xlabel="Pressure (kPa)", ylabel="Force (N)")
    axes.set_xlim(10, 2500)
    axes.grid(color="#e3e7ea", which="both", linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, loc="upper left")
    figure.tight_layout()
    figure.savefig(Path(__file__).with_suffix(".png"))


if __name__ == "__main__":
    main()

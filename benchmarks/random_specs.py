"""Random valid specs, each run and looked over: ``python -m benchmarks.random_specs``.

Geometry, law, layers, loads and their sizes are drawn over wide ranges by a seeded generator; what
the spec's own checks refuse is drawn again. Every run has a process and a time limit of its own.
Afterwards its last state is taken from the restart file and its equilibrium and elements are looked
at anew. A run is good where it reaches its loads, or names the physical cause why it cannot.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import click
import numpy as np
import yaml

from softact.errors import SoftactError

SEED = 20131103
# What a message must say to name a physical cause.
PHYSICAL = re.compile(
    r"pressure cannot exceed|is unstable|limit of the load|is sucked flat|wrinkles|is stretched up"
    r"|has jumped|is crushed"
)
SILICONES = ("ecoflex-00-30", "elastosil-m4601", "dragon-skin-30", "smooth-sil-950")


class Draw:
    """One random spec; lengths in mm, stresses in MPa."""

    def __init__(self, seed: int):
        self.random = np.random.default_rng(seed)
        self.spec = self._spec()

    def between(self, low: float, high: float) -> float:
        return round(float(self.random.uniform(low, high)), 3)

    def scale(self, low: float, high: float) -> float:
        """Drawn evenly on a logarithmic scale."""
        return float(f"{np.exp(self.random.uniform(np.log(low), np.log(high))):.4g}")

    def one_of(self, *choices):
        return choices[self.random.integers(len(choices))]

    def _spec(self) -> dict:
        kind = self.one_of(*GEOMETRIES)
        geometry = {"type": kind, **GEOMETRIES[kind](self)}
        stiffness, law = self._law()
        spec = {
            "name": "drawn",
            "geometry": geometry,
            "materials": {"body": law},
            "steps": self._steps(kind, geometry, stiffness),
        }
        if kind == "fiber_reinforced":
            spec["materials"]["sleeve"] = {
                "law": "holzapfel",
                "c10": f"{stiffness / 2} MPa",
                "k1": f"{stiffness * self.scale(1, 1000)} MPa",
                "angle": f"{self.between(20, 85)} deg",
                "families": 2,
                "density": "1100 kg/m^3",
            }
        if kind == "pneunet" and self.random.random() < 0.4:
            modulus, thickness = self.scale(50, 5000), self.scale(0.05, 0.3)
            spec["layers"] = [self._layer("base", modulus, thickness)]
        if kind == "shell_reinforced":
            spec["layers"] = [self._layer("shell", self.scale(100, 4000), 0.1)]
        return spec

    @staticmethod
    def _layer(surface, modulus, thickness) -> dict:
        law = {"law": "linear", "youngs_modulus": f"{modulus} MPa", "poissons_ratio": 0.3}
        law["density"] = "1000 kg/m^3"
        return {"surface": surface, "thickness": f"{thickness} mm", "material": law}

    def _law(self) -> tuple[float, dict | str]:
        """Shear modulus in MPa and the law."""
        if self.random.random() < 0.15:
            return 0.05, self.one_of(*SILICONES)
        mu = self.scale(0.01, 1.0)
        law = self.one_of(*LAWS)
        constants = LAWS[law](self, mu)
        bulk = f"{mu * self.scale(50, 5000):.4g} MPa"
        if law == "linear":
            return mu, {"law": law, **constants, "density": "1100 kg/m^3"}
        return mu, {"law": law, **constants, "bulk_modulus": bulk, "density": "1100 kg/m^3"}

    def _steps(self, kind, geometry, mu) -> list[dict]:
        steps = []
        if self.random.random() < 0.5:
            direction = [0, 0, 0]
            direction[2 if kind != "block" else self.one_of(0, 1, 2)] = self.one_of(-1, 1)
            steps.append({"name": "gravity", "gravity": direction})
        size = mu * self.scale(0.01, 3.0)
        if kind == "block":
            value = [_mpa(size), "0 MPa", _mpa(size * self.between(-0.3, 0.3))]
            steps.append({"name": "pull", "traction": {"surface": "x_max", "value": value}})
        elif self.random.random() < 0.15:
            steps.append({"name": "vacuum", "pressure": f"{-min(size, 0.1):.4g} MPa"})
        elif self.random.random() < 0.15:
            steps.append({"name": "inject", "inject": f"{self.scale(10, 3000)} mm^3"})
        else:
            steps.append({"name": "inflate", "pressure": f"{size:.4g} MPa"})
            if self.random.random() < 0.2:
                steps.append({"name": "release", "pressure": "0 MPa"})
        return steps


def _mm(**lengths) -> dict:
    return {name: f"{value:.4g} mm" for name, value in lengths.items()}


def _pneunet(d: Draw) -> dict:
    scale = d.scale(0.3, 4)
    lengths = dict(
        chamber_height=d.between(8, 20), chamber_width=d.between(8, 20),
        chamber_length=d.between(3, 8), gap=d.between(0.8, 3), outer_wall=d.between(0.8, 2.5),
        inner_wall=d.between(0.7, 2), roof=d.between(0.8, 2.5), base=d.between(2.5, 5),
    )  # fmt: skip
    lengths |= dict(mesh_size=6, channel_width=3, channel_height=1.2, clamp_plug=4, tip_plug=4)
    lengths |= dict(channel_roof=1.5, layer_height=lengths["base"] / 2)
    return {"chambers": int(d.random.integers(1, 6))} | _mm(
        **{n: v * scale for n, v in lengths.items()}
    )


def _slow_pneunet(d: Draw) -> dict:
    scale = d.scale(0.3, 4)
    lengths = dict(
        chamber_height=d.between(5, 12), chamber_width=d.between(5, 12),
        chamber_length=d.between(2, 6), inner_wall=d.between(2, 7), outer_wall=d.between(2, 7),
        roof=d.between(2, 7), clamp_wall=5, tip_wall=5, tunnel_width=2, tunnel_height=2,
        mesh_size=6,
    )  # fmt: skip
    kind = d.one_of("bending", "linear")
    return {"kind": kind, "chambers": int(d.random.integers(1, 5))} | _mm(
        **{n: v * scale for n, v in lengths.items()}
    )


def _sphere(d: Draw) -> dict:
    inner = d.scale(2, 50)
    ratio = d.between(1.1, 2.5)
    return _mm(
        inner_radius=inner, outer_radius=inner * ratio, mesh_size=inner * d.between(0.4, 0.7)
    )


def _omnidirectional(d: Draw) -> dict:
    lengths = _mm(
        top_wall=d.between(1, 2), side_wall=d.between(0.8, 1.5), inner_wall=d.between(0.8, 1.5)
    )
    count = {"cavities": d.one_of(3, 4), "modules": int(d.random.integers(1, 4))}
    return count | lengths | _mm(mesh_size=5)


def _block(d: Draw) -> dict:
    return _mm(length=d.scale(5, 50), width=d.scale(5, 20), height=d.scale(5, 20), mesh_size=5)


def _fiber_reinforced(d: Draw) -> dict:
    return _mm(
        length=d.between(30, 60), radius=d.between(7, 12), wall=d.between(1.5, 3), mesh_size=6
    )


def _shell_reinforced(d: Draw) -> dict:
    kind = d.one_of("bending", "linear")
    return {"kind": kind, "cuts": int(d.random.integers(1, 5))} | _mm(
        length=d.between(35, 60), mesh_size=6
    )


GEOMETRIES = {
    "pneunet": _pneunet,
    "slow_pneunet": _slow_pneunet,
    "thick_sphere": _sphere,
    "omnidirectional": _omnidirectional,
    "block": _block,
    "fiber_reinforced": _fiber_reinforced,
    "shell_reinforced": _shell_reinforced,
}


def _mpa(value: float) -> str:
    return f"{value:.4g} MPa"


LAWS = {
    "neo_hookean": lambda d, mu: {"c10": _mpa(mu / 2)},
    "mooney_rivlin": lambda d, mu: {"c10": _mpa(0.4 * mu), "c01": _mpa(0.1 * mu)},
    "yeoh": lambda d, mu: {"c10": _mpa(mu / 2), "c20": _mpa(mu * d.scale(0.01, 0.2))},
    "gent": lambda d, mu: {"mu": _mpa(mu), "jm": d.scale(5, 100)},
    "arruda_boyce": lambda d, mu: {"mu": _mpa(mu), "lambda_m": d.between(2, 7)},
    "ogden": lambda d, mu: {
        "mu": [_mpa(mu), _mpa(mu / 50)],
        "alpha": [d.between(1.3, 2.5), d.between(4, 9)],
    },
    "linear": lambda d, mu: {"youngs_modulus": _mpa(2.98 * mu), "poissons_ratio": 0.49},
}


def draw(number: int, seed: int) -> tuple[dict, int]:
    """A valid spec and how many were refused before it."""
    from softact import spec as specs

    for refused in range(200):
        data = Draw(hash((seed, number, refused)) % 2**63).spec
        with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
            yaml.safe_dump(data, file)
            file.flush()
            try:
                specs.load(file.name)
            except SoftactError:
                continue
        return data, refused
    raise SoftactError(f"number {number}: nothing drawn is valid")


def look(folder: Path) -> dict:
    """Residual and smallest Jacobian of the last state of a result folder, computed anew."""
    from mpi4py import MPI

    from softact import spec as specs
    from softact.geometry.base import make_mesh
    from softact.run.from_spec import build_model, supports_of
    from softact.solve import checkpoint
    from softact.solve.newton import Loaded, Newton

    spec = specs.load(str(folder / "spec.yaml"))
    make_mesh(spec.geometry, folder / "again.msh", curved=spec.solver.curved)
    model = build_model(MPI.COMM_SELF, spec, folder / "again.msh")
    found = checkpoint.read(model, folder)
    if found is None:
        return {}
    state = found.state
    model.make_room(state.loads)
    model.contacts.resume(state)
    newton = Newton(model, spec.solver.tolerance, 15)
    newton.set_supports(supports_of(spec.supports), state)
    return {
        "residual": newton.imbalance(Loaded(state, newton.held(state).start)),
        "jacobian": float(model.smallest_jacobian(state.x)),
        "tolerance": spec.solver.tolerance,
    }


def judge(number: int, seed: int, limit: float, keep: Path) -> dict:
    """Draw one spec, run it, and say how it went."""
    data, refused = draw(number, seed)
    folder = keep / f"{number:03d}"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "drawn.yaml").write_text(yaml.safe_dump(data, sort_keys=False))
    told = {"number": number, "refused": refused, "type": data["geometry"]["type"]}
    told["law"] = law["law"] if isinstance(law := data["materials"]["body"], dict) else law
    command = [sys.executable, "-m", "benchmarks.random_specs", "--one", str(folder)]
    started = time.monotonic()
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return told | {"verdict": "hangs", "seconds": limit}
    told["seconds"] = round(time.monotonic() - started, 1)
    if "Traceback" in done.stderr or done.returncode:
        return told | {"verdict": "crashes", "message": done.stderr.strip()[-400:]}
    return told | json.loads(done.stdout.splitlines()[-1])


def one(folder: Path) -> dict:
    """Run the spec of a folder in this process and judge it."""
    from softact import spec as specs
    from softact.run.start import run

    spec = specs.load(str(folder / "drawn.yaml"))
    try:
        outcome = run(spec, folder / "out", report=False, threads=1)
    except SoftactError as error:
        return {"verdict": f"exit {error.exit_code}", "message": error.lines[0]}
    seen = look(folder / "out")
    told = {"message": outcome.message, **seen}
    sound = seen and seen["residual"] <= seen["tolerance"] and seen["jacobian"] > 0
    if outcome.status == "complete":
        told["verdict"] = "arrives"
    else:
        named = PHYSICAL.search(outcome.message or "")
        told["verdict"] = "names the cause" if named else "gives up"
    if not sound and (seen or outcome.status == "complete"):
        told["verdict"] = "unsound state"  # or none that could be looked at
    return told


GOOD = ("arrives", "names the cause")


@click.command()
@click.option("--count", type=click.IntRange(1), default=100, show_default=True)
@click.option("--first", type=click.IntRange(0), default=0, show_default=True)
@click.option("--seed", type=int, default=SEED, show_default=True)
@click.option("-j", "--jobs", type=click.IntRange(1), default=2, show_default=True)
@click.option("--limit", default=600.0, show_default=True, help="Seconds for one run.")
@click.option("--keep", type=click.Path(path_type=Path), default=Path("results/random_specs"))
@click.option("--one", "only", type=click.Path(path_type=Path), hidden=True)
def main(count, first, seed, jobs, limit, keep, only) -> None:
    """Run random specs and count how they end."""
    if only:
        click.echo(json.dumps(one(only)))
        return
    results = []
    with ThreadPoolExecutor(jobs) as pool:
        numbers = range(first, first + count)
        for told in pool.map(lambda n: judge(n, seed, limit, keep), numbers):
            results.append(told)
            click.echo(
                f"{told['number']:3d} {told['type']:17s} {told['law']:15s} "
                f"{told['seconds']:6.1f} s  {told['verdict']}: {told.get('message') or ''}"
            )
    for verdict, number in Counter(t["verdict"] for t in results).most_common():
        click.echo(f"{number:4d} {verdict}")
    worst = max((t["residual"] for t in results if "residual" in t), default=0.0)
    least = min((t["jacobian"] for t in results if "jacobian" in t), default=1.0)
    click.echo(f"largest residual {worst:.1e}, smallest Jacobian {least:.2e}")
    (keep / "results.json").write_text(json.dumps(results, indent=1) + "\n")
    sys.exit(int(sum(t["verdict"] in GOOD for t in results) < 0.98 * len(results)))


if __name__ == "__main__":
    main()

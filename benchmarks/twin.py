"""How fast a module's twin runs in MuJoCo: ``python -m benchmarks.twin [SPEC]``.

Makes the table of a spec's module, writes the MuJoCo model of it, and lets that move for two
seconds of its own time, the largest pressure switched on at their start. Prints the median of three
ratios of that time to processor time (above 1: faster than real time), and the size of the model.
Needs the package mujoco.
"""

from __future__ import annotations

import runpy
import statistics
import tempfile
import time
from pathlib import Path

import click
import mujoco

from softact.export import FORMATS
from softact.modules import rod_run, table_file, twin
from softact.spec import load

SPEC = Path(__file__).with_name("rods") / "swing.yaml"
SECONDS, ROUNDS, STATES = 2.0, 3, 10


@click.command()
@click.argument("path", metavar="[SPEC]", type=click.Path(path_type=Path), default=SPEC)
def main(path: Path) -> None:
    """Write it, load it, run it."""
    spec = load(path)
    with tempfile.TemporaryDirectory(prefix="softact-") as scratch:
        folder = Path(scratch)
        made = table_file.made_or_read(spec, folder / "none", False, lambda text: None)
        chain = rod_run.Chain(spec, made.table)
        job = twin.prepare(chain, rod_run.run(chain, STATES))
        for name, content in FORMATS["mujoco"].files(job).items():
            assert isinstance(content, str)
            (folder / name).write_text(content)
        drive = runpy.run_path(str(folder / f"{job.name}_mujoco.py"))
        model = mujoco.MjModel.from_xml_path(str(folder / f"{job.name}.xml"))
    actuator, ratios = drive["Actuator"](model), []
    for _ in range(ROUNDS):
        data = mujoco.MjData(model)
        actuator.set_pressure(data, 1e3 * float(made.table.high[0]))
        started = time.process_time()
        while data.time < SECONDS:
            mujoco.mj_step(model, data)
        ratios.append(data.time / (time.process_time() - started))
    click.echo(f"{model.njnt} joints, steps of {1e3 * model.opt.timestep:g} ms")
    click.echo(f"ratio time_vs_processor_time {statistics.median(ratios):.1f}")


if __name__ == "__main__":
    main()

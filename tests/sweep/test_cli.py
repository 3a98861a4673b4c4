"""`softact sweep` as its user calls it, with the solver; and its page in headless Chromium."""

import csv
import os
import signal
import subprocess
import sys
import time

import pytest

from softact.cli import main as cli
from softact.sweep import cluster
from tests.browsing import DESK, PHONE, assert_quiet_and_fits
from tests.sweep.folders import CUBE

SWEEP = (
    CUBE
    + """
axes:
  - {path: materials.body.c10, values: [0.1 MPa, 0.2 MPa]}
  - {path: geometry.length, values: [4 mm, 0 mm]}
trends: [{measure: elongation_mm, axis: materials.body.c10, does: fall}]
"""
)


def call(folder, *options, wait=True):
    command = [sys.executable, "-m", "softact.cli.main", "sweep", "cube.yaml", *options]
    started = subprocess.Popen(
        command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    if not wait:
        return started
    out, err = started.communicate(timeout=300)
    return started.returncode, out, err


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A sweep that was killed in its first run, called again, and called a third time."""
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "cube.yaml").write_text(SWEEP)
    first = call(folder, "-j", "2", wait=False)
    end = time.monotonic() + 120
    while not list((folder / "results/.runs/tmp").glob("*/softact-*/mesh.msh")):
        assert time.monotonic() < end
        time.sleep(0.01)
    os.kill(first.pid, signal.SIGKILL)
    first.communicate()
    return folder


def test_nothing_outlives_a_killed_sweep(folder):
    end = time.monotonic() + 10
    while any(str(folder) in line for line in commands()):
        assert time.monotonic() < end, commands()
        time.sleep(0.05)


def commands():
    found = []
    for entry in os.listdir("/proc"):
        try:
            with open(f"/proc/{entry}/cmdline", "rb") as file:
                found.append(file.read().replace(b"\0", b" ").decode(errors="replace"))
        except OSError:
            continue
    return found


def test_second_call_computes_what_is_missing_and_the_third_nothing(folder):
    code, out, err = call(folder, "-j", "2")
    assert (code, err) == (0, "")
    assert "2 complete, 2 invalid spec; 2 computed now" in out
    assert "trend: elongation_mm falls with materials.body.c10: so it is" in out
    with open(folder / "results/cube/sweep.csv") as file:
        rows = list(csv.DictReader(file))
    # Small strain: 20 kPa over E = 6 c10 stretches 4 mm by 0.13 and 0.07 mm, less at the clamp.
    long, short = (float(row["elongation_mm"]) for row in rows if row["status"] == "complete")
    assert long == pytest.approx(4 * 0.02 / 0.6, rel=0.2)
    assert long / short == pytest.approx(2.0, rel=0.05)
    before = (folder / "results/.runs/journal.csv").read_text()
    code, out, err = call(folder)
    assert (code, err) == (0, "")
    assert "0 computed now" in out
    assert (folder / "results/.runs/journal.csv").read_text() == before


def test_list_computes_nothing(folder):
    code, out, _ = call(folder, "--list")
    assert code == 0
    assert out.count("invalid spec") == 2


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--scheduler", "tcp://127.0.0.1:1"], "no Dask scheduler answers there"),
        (["--slurm", "--slurm-option", "queue"], "write name=value"),
        (["--cache", "cube.yaml"], "cube.yaml: cannot be written"),
        (["-o", "cube.yaml"], "cube.yaml: is a file; name another folder with -o DIR"),
    ],
)
def test_wrong_options_are_one_line(options, said, tmp_path, monkeypatch, capfd):
    """Called in this process, where a scheduler has half a second to answer instead of 30 s."""
    monkeypatch.setattr(cluster, "_SECONDS", 0.5)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cube.yaml").write_text(SWEEP)
    with pytest.raises(SystemExit) as stop:
        cli.main(["sweep", "cube.yaml", *options])
    err = capfd.readouterr().err
    assert (stop.value.code, len(err.splitlines())) == (2, 1)
    assert said in err
    assert [path.name for path in tmp_path.iterdir()] == ["cube.yaml"]


@pytest.fixture(params=[PHONE, DESK])
def page(request, folder, browser):
    return browser.open(folder / "results/cube/sweep.html", request.param)


def test_page_has_no_error_and_a_click_shows_the_shape(page):
    for box in ("front", "curves", "parallel"):
        assert page.run(f"return document.getElementById('{box}').data.length") > 0
    number = page.run("return document.getElementById('front').data[0].customdata[0]")
    page.click_point("front", trace=0, point=0)
    page.wait("return document.getElementById('oneshape')?.dataset.ready === 'yes'")
    assert page.run("return document.getElementById('onepoint').dataset.point") == str(number)
    x = page.run("return Array.from(document.getElementById('oneshape').data[0].x)")
    assert (min(x), max(x)) == (pytest.approx(0, abs=0.01), pytest.approx(4.1, abs=0.1))
    assert_quiet_and_fits(page)

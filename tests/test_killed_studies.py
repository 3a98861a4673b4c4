"""A sweep, an optimisation and a calibration that are killed, and called again until they end: as if
nobody had disturbed them."""

import random
import time

import pytest

from benchmarks.sweep_kills import faults_of, kill_once, processes_of, start, studies, undisturbed

STUDIES = studies(jobs=1, count=1)


@pytest.mark.parametrize("command", STUDIES)
def test_killed_twice_and_called_again(tmp_path, command):
    study, draw = STUDIES[command], random.Random(7)
    (tmp_path / "whole").mkdir()
    (tmp_path / "killed").mkdir()
    wanted, keys, took = undisturbed(study, tmp_path / "whole")
    folder = tmp_path / "killed"
    for whom in ("command", "solver"):
        kill_once(study, folder, draw.uniform(0.4, 0.9) * took, whom)
        end = time.monotonic() + 10
        while processes_of(folder):
            assert time.monotonic() < end  # children of the command end with it
            time.sleep(0.05)
    assert faults_of(study, folder, wanted, keys, start(study, folder).wait()) == []

"""Studies that are killed and called again end as if nobody had disturbed them; a sweep is killed
in tests/sweep/test_cli.py, all four fifty times in benchmarks."""

import dataclasses

import pytest

from benchmarks.sweep_kills import faults_of, kill_once, start, studies, survivors, undisturbed

STUDIES = studies(jobs=1, count=2)
FEWER = {
    "optimize": ("--trials", "3"), "calibrate": ("--max-runs", "3"), "converge": ("--most", "3")
}  # fmt: skip


@pytest.mark.parametrize(
    ("command", "whom"), [("optimize", "solver"), ("calibrate", "command"), ("converge", "solver")]
)
def test_killed_and_called_again(tmp_path, command, whom):
    study = STUDIES[command]
    study = dataclasses.replace(study, arguments=(*study.arguments, *FEWER[command]))
    whole, folder = tmp_path / "whole", tmp_path / "killed"
    whole.mkdir()
    folder.mkdir()
    wanted, keys, took = undisturbed(study, whole)
    assert len(keys) == 3
    kill_once(study, folder, 0.6 * took, whom)
    assert not survivors(folder)  # children of the command end with it
    assert faults_of(study, folder, wanted, keys, start(study, folder).wait()) == []

"""Films of a run: as many frames as promised, at even steps of the load, that move."""

import importlib.util
import sys
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from softact.errors import SpecError
from softact.report import animation, frames
from softact.results.folder import read
from softact.results.writer import ResultsWriter
from tests import bent_beam

SIZE = {"nx": 12, "ny": 2, "nz": 7}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    directory = tmp_path_factory.mktemp("film") / "beam"
    bent_beam.write(directory, 120.0, 4, size=SIZE)
    return directory


def curve_only(tmp_path, pressures):
    writer = ResultsWriter(tmp_path / "r", "", {})
    for pressure in pressures:
        writer.increment({"pressure_kPa": float(pressure)})
    results = read(tmp_path / "r")
    object.__setattr__(results, "increments", tuple(map(str, range(len(pressures)))))
    return results


def test_moments_are_at_even_loads(tmp_path):
    # Two states at rest (gravity), then steps of 10, 30 and 20 kPa.
    results = curve_only(tmp_path, [0, 0, 10, 40, 60])
    found = animation.moments(results, 7)
    loads = np.interp(found, np.arange(5), [0, 0, 10, 40, 60])
    assert loads == pytest.approx([0, 10, 20, 30, 40, 50, 60])
    assert found[0] == 1 and found[-1] == 4


def test_moments_go_up_and_down_again(tmp_path):
    results = curve_only(tmp_path, [0, 20, 40, 10])
    found = animation.moments(results, 8)
    loads = np.interp(found, np.arange(4), [0, 20, 40, 10])
    assert loads == pytest.approx([0, 10, 20, 30, 40, 30, 20, 10])


def test_states_between_are_linear(folder):
    scene = frames.make_scene(read(folder))
    middle = (scene.points(2) + scene.points(3)) / 2
    assert scene.points(2.5) == pytest.approx(middle)
    assert np.abs(scene.points(2.5) - scene.points(2)).max() > 1


def test_the_gif_moves_and_stands_still_at_the_end(folder, monkeypatch):
    monkeypatch.setattr(animation, "_FRAMES", 6)
    path = animation.write_animation(folder, "gif")
    with Image.open(path) as film:
        assert film.n_frames == 6
        shots, durations = [], []
        for number in range(film.n_frames):
            film.seek(number)
            shots.append(np.asarray(film.convert("RGB"), float))
            durations.append(film.info["duration"])
    assert durations == [50] * 5 + [1000]
    moved = [np.abs(b - a).max(axis=2) > 60 for a, b in pairwise(shots)]
    assert all(m.mean() > 0.005 for m in moved)
    assert (np.ptp(shots[-1], axis=2) > 60).mean() > 0.02  # coloured


@pytest.mark.skipif(
    importlib.util.find_spec("imageio_ffmpeg") is None, reason="needs imageio-ffmpeg"
)
def test_the_mp4_has_all_frames(folder, monkeypatch):
    import imageio_ffmpeg

    monkeypatch.setattr(animation, "_FRAMES", 6)
    path = animation.write_animation(folder, "mp4")
    count, seconds = imageio_ffmpeg.count_frames_and_secs(str(path))
    assert count == 6 + 20
    assert seconds == pytest.approx(count / 20, abs=0.06)
    assert not list(folder.glob(".*part*"))


def test_mp4_without_its_package_is_one_clear_line(folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(SpecError, match=r"needs the package imageio-ffmpeg.*gif works"):
        animation.write_animation(folder, "mp4")


def test_nothing_to_animate_is_told(tmp_path):
    ResultsWriter(tmp_path / "r", "", {}).finish("complete")
    with pytest.raises(SpecError, match="no states"):
        animation.write_animation(tmp_path / "r", "gif")

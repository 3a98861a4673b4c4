"""The actuator in motion: ``animation.gif`` or ``animation.mp4``."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from softact.errors import SpecError
from softact.files.text import replacing, write_atomic
from softact.report import frames, pictures
from softact.results.folder import Results, load, read, rest_state

if TYPE_CHECKING:
    from PIL import ImageFont

KINDS = ("gif", "mp4")
_FRAMES, _HOLD = 40, 20  # of the motion, and of the last state standing still
_PER_SECOND = 20
_PIXELS = 560


def check(kind: str) -> None:
    """Raise SpecError where this kind of film cannot be written here."""
    if kind not in KINDS:
        raise SpecError(f"--animate {kind}: there are {' and '.join(KINDS)}")
    if kind == "mp4" and importlib.util.find_spec("imageio_ffmpeg") is None:
        raise SpecError(
            "--animate mp4 needs the package imageio-ffmpeg (pip install imageio-ffmpeg); "
            "--animate gif works without it"
        )


def write_animation(directory: str | Path, kind: str) -> Path:
    """Write the film of a result folder; returns its path.

    Frames are at even steps of the load, linear between accepted states. Raises SpecError where
    the folder has no states, the kind is not known or cannot be written here, or drawing failed.
    """
    check(kind)
    results = read(directory)
    if not results.increments:
        raise SpecError(f"{directory}: there are no states, so there is nothing to animate")
    shots = _shots(results)
    path = Path(directory) / f"animation.{kind}"
    if kind == "gif":
        write_atomic(path, _gif(shots))
    else:
        _write_mp4(path, shots)
    return path


def moments(results: Results, count: int) -> np.ndarray:
    """(count,) numbers of states, with fractions, at even steps of the load's way.

    From the last state at rest to the last one; where the load falls again, its way counts.
    """
    loads, first = load(results), max(rest_state(results), 0)
    last = len(results.increments) - 1
    states = np.arange(first, last + 1)
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(loads[first : last + 1])))])
    if last == first:
        return np.array([float(last)])
    if not way[-1] > 0:
        return np.linspace(first, last, count)
    moving = np.concatenate([[True], np.diff(way) > 0])
    return np.interp(np.linspace(0, way[-1], count), way[moving], states[moving])


def _shots(results: Results) -> list:
    """PIL images of all frames, with title, colour bar and axes."""
    from PIL import Image, ImageDraw

    scene = frames.make_scene(results)
    group = scene.group([float(n) for n in moments(results, _FRAMES)], ghost=True, pixels=_PIXELS)
    with frames.renderer() as renderer:
        renderer.draw(scene.job(group))
        try:
            (drawn,) = renderer.drawn()
        except frames.DrawingError as error:
            raise SpecError(f"{results.directory}: {error}") from None
    blank = np.full((1, *drawn.shape[1:]), 255, np.uint8)
    canvas = Image.fromarray(next(pictures.composed(scene, group, blank, 1, titles=[""])))
    # An odd line of pixels more than H.264 takes is cut off.
    canvas = canvas.crop((0, 0, canvas.width // 2 * 2, canvas.height // 2 * 2))
    font, shots = _font(), []
    left, top = pictures.CORNER
    for number, panel in zip(group.numbers, drawn, strict=True):
        shot = canvas.copy()
        shot.paste(Image.fromarray(panel), (left, top))
        title = pictures.state_title(results, number)
        place = (left + drawn.shape[2] / 2, top - 8)
        ImageDraw.Draw(shot).text(place, title, fill=pictures.INK, font=font, anchor="ms")
        shots.append(shot)
    return shots


def _font() -> ImageFont.FreeTypeFont:
    import matplotlib
    from PIL import ImageFont

    path = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"
    return ImageFont.truetype(str(path), 22)


def _gif(shots: Sequence) -> bytes:
    from PIL import Image

    # One palette for all, that of the state with the most colours, or colours would flicker.
    palette = shots[-1].quantize(255)
    flat = [shot.quantize(palette=palette, dither=Image.Dither.NONE) for shot in shots]
    durations = [1000 // _PER_SECOND] * len(flat)
    durations[-1] = 1000 * _HOLD // _PER_SECOND
    out = BytesIO()
    flat[0].save(
        out, format="GIF", save_all=True, append_images=flat[1:], duration=durations, loop=0,
        optimize=False,
    )  # fmt: skip
    return out.getvalue()


def _write_mp4(path: Path, shots: Sequence) -> None:
    import imageio_ffmpeg

    with replacing(path, ".mp4") as part:
        film = imageio_ffmpeg.write_frames(
            str(part), shots[0].size, fps=_PER_SECOND, codec="libx264", pix_fmt_out="yuv420p",
            quality=8, macro_block_size=2, ffmpeg_log_level="error",
        )  # fmt: skip
        film.send(None)
        for shot in [*shots, *[shots[-1]] * _HOLD]:
            film.send(np.ascontiguousarray(np.asarray(shot)))
        film.close()

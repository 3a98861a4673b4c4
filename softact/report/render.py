"""Draws deformed surfaces off screen with VTK: ``python -P render.py FOLDER``.

In FOLDER, 0.npz, 1.npz ... are drawn as they appear, until there is a file ``end`` and no further
job, or its standard input has ended, as it does with the process that started this one.

A process of its own, since a missing graphics library can end the process that draws; and a file
that imports nothing but numpy and the few modules of VTK that it needs, since that is most of the
time a small picture takes.

The arrays of a job, for k states seen alike: points (k, n, 3) mm; values (k, n) for the colours;
triangles (t, 3); edges (e, 2) vertices of creases; ghost (g, 3) or (0, 3): points of the same
edges to draw in grey behind each; bodies (k, m, 3) and body_triangles (b, 3): rigid bodies beside
each; limits (2,) of the values; colours (c, 3) in 0..1, from low to
high; right, up, eye (3,): unit vectors of the parallel projection; low, high (2,): corners of the
frame, mm in the picture; size (2,): pixels; front (), where it is given: what stands further toward
the eye is not drawn, mm. 0.npy is then (k, height, width, 4) uint8: the colours on white, and how
much of each pixel is covered.
"""

import itertools
import select
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 (registers the drawing)
from vtkmodules.util.numpy_support import (
    numpy_to_vtk,
    numpy_to_vtkIdTypeArray,
    vtk_to_numpy,
)
from vtkmodules.vtkCommonCore import vtkLookupTable, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkLightKit,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkWindowToImageFilter,
)

_FINER = 2  # drawn so many times as large, then averaged
_INK, _GREY = (0.11, 0.165, 0.2), (0.54, 0.58, 0.61)


class Shown(NamedTuple):
    """What is drawn, and the data whose points move."""

    actor: vtkActor
    data: vtkPolyData


def render(job: dict, window: vtkRenderWindow) -> np.ndarray:
    """The pictures of a job, drawn in ``window``."""
    renderer = _renderer(job, window)
    surface, outline = _surface(job), _lines(job, _INK, 0.6)
    for shown in (surface, outline):
        renderer.AddActor(shown.actor)
    if len(job["ghost"]):
        ghost = _lines(job, _GREY, 1.0)
        _place(ghost, job["ghost"])
        renderer.AddActor(ghost.actor)
    bodies = _bodies(job)
    renderer.AddActor(bodies.actor)
    pictures = []
    for points, values, beside in zip(job["points"], job["values"], job["bodies"], strict=True):
        _place(bodies, beside)
        _place(surface, points, values)
        _place(outline, points)
        _aim(renderer, job, points)
        pictures.append(_shot(window))
    window.RemoveRenderer(renderer)
    return np.array(pictures)


def _renderer(job: dict, window: vtkRenderWindow) -> vtkRenderer:
    window.SetSize(*(int(n) * _FINER for n in job["size"]))
    renderer = vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    renderer.SetBackgroundAlpha(0)
    kit = vtkLightKit()
    kit.AddLightsToRenderer(renderer)
    window.AddRenderer(renderer)
    return renderer


def _surface(job: dict) -> Shown:
    colours = job["colours"]
    table = vtkLookupTable()
    table.SetNumberOfTableValues(256)
    places = np.linspace(0, len(colours) - 1, 256)
    for number in range(256):
        at = np.arange(len(colours))
        red, green, blue = (float(np.interp(places[number], at, c)) for c in colours[:, :3].T)
        table.SetTableValue(number, red, green, blue)
    data = vtkPolyData()
    data.SetPolys(_cells(job["triangles"]))
    normals = vtkPolyDataNormals()
    normals.SetInputData(data)
    normals.SplittingOff()
    normals.ConsistencyOff()
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(normals.GetOutputPort())
    mapper.SetLookupTable(table)
    mapper.SetScalarRange(*job["limits"])
    mapper.InterpolateScalarsBeforeMappingOn()
    actor = vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetInterpolationToPhong()
    look.SetAmbient(0.5)
    look.SetDiffuse(0.58)
    look.SetSpecular(0.1)
    look.SetSpecularPower(20)
    return Shown(actor, data)


def _bodies(job: dict) -> Shown:
    data = vtkPolyData()
    data.SetPolys(_cells(job["body_triangles"]))
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(data)
    actor = vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetColor(*_GREY)
    look.SetOpacity(0.45)
    look.SetAmbient(0.4)
    look.SetInterpolationToFlat()
    return Shown(actor, data)


def _lines(job: dict, colour: tuple[float, float, float], opacity: float) -> Shown:
    data = vtkPolyData()
    data.SetLines(_cells(job["edges"]))
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(data)
    actor = vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetColor(*colour)
    look.SetOpacity(opacity)
    look.SetLineWidth(1.5 * _FINER)
    look.LightingOff()
    return Shown(actor, data)


def _cells(corners: np.ndarray) -> vtkCellArray:
    cells = vtkCellArray()
    count, each = corners.shape
    flat = np.ascontiguousarray(corners, np.int64).ravel()
    starts = np.arange(0, count * each + 1, each, dtype=np.int64)
    cells.SetData(
        numpy_to_vtkIdTypeArray(starts, deep=True), numpy_to_vtkIdTypeArray(flat, deep=True)
    )
    return cells


def _place(shown: Shown, points: np.ndarray, values: np.ndarray | None = None) -> None:
    """Move an actor's points, and colour it."""
    places = vtkPoints()
    places.SetData(numpy_to_vtk(np.ascontiguousarray(points, float), deep=True))
    shown.data.SetPoints(places)
    if values is not None:
        scalars = numpy_to_vtk(np.ascontiguousarray(values, np.float32), deep=True)
        shown.data.GetPointData().SetScalars(scalars)
    shown.data.Modified()


def _aim(renderer: vtkRenderer, job: dict, points: np.ndarray) -> None:
    """Parallel projection whose frame is the rectangle ``low`` to ``high``."""
    low, high, eye = job["low"], job["high"], job["eye"]
    middle = (low + high) / 2
    depth = points @ eye
    focus = middle[0] * job["right"] + middle[1] * job["up"] + depth.mean() * eye
    far = 10 * max(np.ptp(depth), *(high - low))
    camera = renderer.GetActiveCamera()
    camera.SetFocalPoint(*focus)
    camera.SetPosition(*(focus + far * eye))
    camera.SetViewUp(*job["up"])
    camera.ParallelProjectionOn()
    camera.SetParallelScale((high - low)[1] / 2)
    near = depth.mean() + far - float(job["front"]) if "front" in job else 0.1 * far
    camera.SetClippingRange(near, 3 * far)


def _shot(window: vtkRenderWindow) -> np.ndarray:
    """(height, width, 4) uint8: the picture, each pixel the mean of those drawn."""
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.SetInputBufferTypeToRGBA()
    grab.ReadFrontBufferOff()
    grab.Update()  # renders
    image = grab.GetOutput()
    wide, high, _ = image.GetDimensions()
    drawn = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(high, wide, 4)[::-1]
    mean = np.zeros((high // _FINER, wide // _FINER, 4), np.uint16)
    for row, column in np.ndindex(_FINER, _FINER):
        mean += drawn[row::_FINER, column::_FINER]
    return (mean // _FINER**2).astype(np.uint8)


def main(folder: Path) -> None:
    """Draw each job in a folder into a file of the same name in .npy, which appears whole."""
    window = vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(0)
    window.SetAlphaBitPlanes(1)
    for number in itertools.count():
        job_file = folder / f"{number}.npz"
        while not job_file.exists():
            ended = (folder / "end").exists() or select.select([sys.stdin], [], [], 0.01)[0]
            if ended and not job_file.exists():
                return
        with np.load(job_file) as arrays:
            job = dict(arrays)
        drawn = job_file.with_suffix(".drawn.npy")
        np.save(drawn, render(job, window))
        drawn.rename(job_file.with_suffix(".npy"))


if __name__ == "__main__":
    main(Path(sys.argv[1]))

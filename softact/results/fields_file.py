"""fields.h5: the mesh and the fields of each state. A change of it happens all or not at all, and
damage ends in one plain line: each array and text carries its CRC-32 as an attribute.
"""

from __future__ import annotations

import io
import json
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from softact.files.text import write_atomic
from softact.mesh.layout import Layout
from softact.results.journal import Overlay, journal_of
from softact.results.run_json import SOLVE_AGAIN, damaged

CHECKSUM = "crc32"

# What h5py and numpy raise where the bytes make no sense.
_NONSENSE = (
    ArithmeticError,
    AttributeError,
    KeyError,
    IndexError,
    MemoryError,
    NotImplementedError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
)


def write_array(group: h5py.Group, name: str, values: np.ndarray) -> None:
    """Write an array with its checksum."""
    values = np.ascontiguousarray(values)
    item = group.create_dataset(name, data=values)
    item.attrs[CHECKSUM] = np.uint32(zlib.crc32(values.data))


def write_text(group: h5py.Group, name: str, text: str) -> None:
    """Write a text with its checksum."""
    item = group.create_dataset(name, data=text)
    item.attrs[CHECKSUM] = np.uint32(zlib.crc32(text.encode()))


@contextmanager
def created(path: Path) -> Iterator[h5py.File]:
    """A new file, which takes the place of an old one when it is whole. Made in memory: on a full
    disk HDF5 leaves a file that it can neither write nor close. Raises OSError."""
    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as file:
        yield file
    write_atomic(path, buffer.getbuffer())
    journal_of(path).unlink(missing_ok=True)


@contextmanager
def changed(path: Path) -> Iterator[h5py.File]:
    """The file, to be changed; whoever reads or kills meanwhile finds it as it was. Raises
    DamagedResultError where it cannot be opened, OSError where the disk is full."""
    try:
        overlay = Overlay(path)
        file = h5py.File(overlay, "r+")
    except _NONSENSE as error:
        raise damaged(path, error) from None
    with overlay:
        with file:
            yield file
        overlay.commit()


@contextmanager
def opened(path: Path, remedy: str = SOLVE_AGAIN) -> Iterator[h5py.File]:
    """The file, to be read. Raises DamagedResultError for whatever goes wrong with it."""
    try:
        source = Overlay(path) if journal_of(path).exists() else path
        with h5py.File(source, "r") as file:
            yield file
    except _NONSENSE as error:
        raise damaged(path, error, remedy) from None


def array(item: h5py.Dataset, kinds: str = "iuf") -> np.ndarray:
    """The numbers of a dataset. Raises ValueError where they are not as they were written, or
    there are none."""
    if not isinstance(item, h5py.Dataset) or item.dtype.kind not in kinds:
        raise ValueError(f"{item.name} holds no numbers")
    # More than there is in the file would be made up, and could fill the memory.
    size, there = item.size * item.dtype.itemsize, item.file.id.get_filesize()
    if size > there:
        raise ValueError(f"{item.name} would take {size:.2g} bytes, and the file has {there:.2g}")
    if item.id.get_storage_size() != size:
        raise ValueError(f"{item.name} holds no array of its shape")
    values = np.ascontiguousarray(item[()])
    if CHECKSUM in item.attrs and zlib.crc32(values.data) != int(item.attrs[CHECKSUM]):
        raise ValueError(f"{item.name} is not as it was written")
    return values


def field(item: h5py.Dataset, counts: tuple[int, int], vector: bool) -> np.ndarray:
    """Values of a field. counts: of nodes and of cells, one of which it has. vector: whether it has
    three numbers in each, or one. Raises ValueError."""
    values = array(item)
    if values.shape[1:] != (3,) * vector or len(values) not in counts:
        raise ValueError(f"{item.name} has the shape {values.shape}")
    return values


def read_mesh(path: Path) -> dict:
    """The mesh as ``softact.results.folder.Results`` names its parts, and the names of the
    increments; empty where there is no file. Raises DamagedResultError."""
    if not path.is_file():
        return {}
    with opened(path) as file:
        mesh = file["mesh"]
        points, cells = array(mesh["points"], "f"), array(mesh["cells"], "iu")
        if points.shape[1:] != (3,) or not np.isfinite(points).all():
            raise ValueError("the nodes have no places")
        surfaces = {name: array(item, "iu") for name, item in mesh["surfaces"].items()}
        _check_indices(cells, len(points), (3, 6, 4, 10))
        for triangles in surfaces.values():
            _check_indices(triangles, len(points), (3, 6))
        region = array(mesh["region"], "iu")
        names = tuple(json.loads(_text(mesh["region_names"])))
        if region.shape != cells.shape[:1] or not all(isinstance(n, str) for n in names):
            raise ValueError("the cells have no regions")
        return {
            "points": points,
            "cells": cells,
            "region": region,
            "region_names": names,
            "surfaces": surfaces,
            "layout": read_layout(mesh),
            "increments": tuple(file["increments"]),
        }


def _check_indices(cells: np.ndarray, count: int, corners: tuple[int, ...]) -> None:
    known = cells.ndim == 2 and cells.shape[1] in corners
    if not known or cells.min(initial=0) < 0 or cells.max(initial=0) >= count:
        raise ValueError("cells or triangles have no such nodes")


def _text(item: h5py.Dataset) -> str:
    text = item.asstr()[()]
    if CHECKSUM in item.attrs and zlib.crc32(text.encode()) != int(item.attrs[CHECKSUM]):
        raise ValueError(f"{item.name} is not as it was written")
    return text


def read_layout(mesh: h5py.Group) -> Layout:
    """The layout of a mesh in the file; keys of a newer or older softact are left out."""
    data = json.loads(_text(mesh["layout"]))
    known = {item.name for item in fields(Layout)}
    tuples: dict[str, Any] = {
        k: tuple(v) if isinstance(v, list) else v for k, v in data.items() if k in known
    }
    tuples["cavities"] = {k: tuple(v) for k, v in data["cavities"].items()}
    return Layout(**tuples)


def sheets_of(mesh: h5py.Group) -> tuple[int, int] | None:
    """Shape of the triangles of the sheets beside a solid, of a mesh in the file; None: there are
    none."""
    shapes = [mesh["surfaces"][name].shape for name in read_layout(mesh).covers]
    return (sum(shape[0] for shape in shapes), shapes[0][1]) if shapes else None

"""The light half of the fields: which array of fields.h5 is what, in XDMF 3."""

from collections.abc import Mapping
from xml.etree import ElementTree

import numpy as np

_KIND = {(): "Scalar", (3,): "Vector", (6,): "Tensor6"}
_TOPOLOGY = {3: "Triangle", 6: "Triangle_6", 4: "Tetrahedron", 10: "Tetrahedron_10"}
_NUMBER = {3: 4, 6: 36, 4: 6, 10: 38}  # of the same, in a mixed topology


def mixed(*blocks: np.ndarray) -> np.ndarray:
    """Blocks of cells (m, n) as one list, each cell after the number of its type."""
    numbered = [np.insert(block, 0, _NUMBER[block.shape[1]], axis=1) for block in blocks]
    return np.concatenate([block.ravel() for block in numbered])


class Xdmf:
    """A temporal collection that grows by ``add``.

    points: number of nodes. cells: shape of the connectivity, (m, 4) or (m, 10), or of
        triangles (m, 3) or (m, 6). sheets: the same of the triangles beside tets, None where
        there are none; then ``mesh/mixed`` holds both, see ``mixed``, and ``mesh/part`` the
        number of each cell's region or sheet.

    Each grid of the collection names mesh and values in ``fields.h5`` directly, without
    XInclude or HyperSlab, because that is what both of ParaView's readers and meshio's
    TimeSeriesReader understand.
    """

    def __init__(self, points: int, cells: tuple[int, ...], sheets: tuple[int, ...] | None = None):
        self._points, self._cells, self._sheets = points, cells, sheets
        self._root = ElementTree.Element("Xdmf", Version="3.0")
        domain = ElementTree.SubElement(self._root, "Domain")
        self._collection = ElementTree.SubElement(
            domain, "Grid", Name="softact", GridType="Collection", CollectionType="Temporal"
        )

    def add(self, time: float, group: str, arrays: Mapping[str, np.ndarray]) -> None:
        """A further state: ``arrays`` stand under ``group`` of fields.h5."""
        grid = ElementTree.SubElement(
            self._collection, "Grid", Name=group.replace("/", "_"), GridType="Uniform"
        )
        ElementTree.SubElement(grid, "Time", Value=repr(float(time)))
        count = self._topology(grid)
        geometry = ElementTree.SubElement(grid, "Geometry", GeometryType="XYZ")
        self._item(geometry, "mesh/points", (self._points, 3), "Float", 8)
        part = "mesh/part" if self._sheets else "mesh/region"
        self._attribute(grid, "region", part, (count,), "Int", 4)
        for name, values in arrays.items():
            size = values.dtype.itemsize
            self._attribute(grid, name, f"{group}/{name}", values.shape, "Float", size)

    def _topology(self, grid: ElementTree.Element) -> int:
        """Add the cells to a grid; returns their number."""
        shapes = [shape for shape in (self._cells, self._sheets) if shape]
        count = sum(shape[0] for shape in shapes)
        kind = "Mixed" if self._sheets else _TOPOLOGY[self._cells[1]]
        topology = ElementTree.SubElement(
            grid, "Topology", TopologyType=kind, NumberOfElements=str(count)
        )
        if self._sheets:
            entries = sum(rows * (size + 1) for rows, size in shapes)
            self._item(topology, "mesh/mixed", (entries,), "Int", 8)
        else:
            self._item(topology, "mesh/cells", self._cells, "Int", 8)
        return count

    def _attribute(
        self,
        grid: ElementTree.Element,
        name: str,
        path: str,
        shape: tuple[int, ...],
        kind: str,
        precision: int,
    ) -> None:
        attribute = ElementTree.SubElement(
            grid,
            "Attribute",
            Name=name,
            AttributeType=_KIND.get(shape[1:], "Matrix"),
            Center="Node" if shape[0] == self._points and name != "region" else "Cell",
        )
        self._item(attribute, path, shape, kind, precision)

    @staticmethod
    def _item(
        parent: ElementTree.Element, path: str, shape: tuple[int, ...], kind: str, precision: int
    ) -> None:
        item = ElementTree.SubElement(
            parent,
            "DataItem",
            Dimensions=" ".join(map(str, shape)),
            DataType=kind,
            Precision=str(precision),
            Format="HDF",
        )
        item.text = f"fields.h5:/{path}"

    def text(self) -> str:
        """The document as a string."""
        ElementTree.indent(self._root)
        return '<?xml version="1.0"?>\n' + ElementTree.tostring(self._root, "unicode") + "\n"

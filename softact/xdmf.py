"""The light half of the fields: which array of fields.h5 is what, in XDMF 3."""

from collections.abc import Mapping
from xml.etree import ElementTree

import numpy as np

_KIND = {(): "Scalar", (3,): "Vector", (6,): "Tensor6"}
_TOPOLOGY = {3: "Triangle", 6: "Triangle_6", 4: "Tetrahedron", 10: "Tetrahedron_10"}


class Xdmf:
    """A temporal collection that grows by ``add``.

    points: number of nodes. cells: shape of the connectivity, (m, 4) or (m, 10), or of
        triangles (m, 3) or (m, 6).

    Each grid of the collection names mesh and values in ``fields.h5`` directly, without
    XInclude or HyperSlab, because that is what both of ParaView's readers and meshio's
    TimeSeriesReader understand.
    """

    def __init__(self, points: int, cells: tuple[int, int]):
        self._points = points
        self._cells = cells
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
        topology = ElementTree.SubElement(
            grid,
            "Topology",
            TopologyType=_TOPOLOGY[self._cells[1]],
            NumberOfElements=str(self._cells[0]),
        )
        self._item(topology, "mesh/cells", self._cells, "Int", 8)
        geometry = ElementTree.SubElement(grid, "Geometry", GeometryType="XYZ")
        self._item(geometry, "mesh/points", (self._points, 3), "Float", 8)
        self._attribute(grid, "region", "mesh/region", (self._cells[0],), "Int", 4)
        for name, values in arrays.items():
            size = values.dtype.itemsize
            self._attribute(grid, name, f"{group}/{name}", values.shape, "Float", size)

    def _attribute(self, grid, name, path, shape, kind, precision) -> None:
        attribute = ElementTree.SubElement(
            grid,
            "Attribute",
            Name=name,
            AttributeType=_KIND.get(shape[1:], "Matrix"),
            Center="Node" if shape[0] == self._points and name != "region" else "Cell",
        )
        self._item(attribute, path, shape, kind, precision)

    @staticmethod
    def _item(parent, path, shape, kind, precision) -> None:
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

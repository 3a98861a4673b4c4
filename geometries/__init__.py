"""The actuators that softact can mesh: one file each, one line each in the registry."""

from softact.geometries.pneunet import Pneunet

GEOMETRIES = {
    "pneunet": Pneunet,
}

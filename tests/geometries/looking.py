"""What softact says of the file that a geometry is made of."""

from softact.geometry.base import Geometry, look


def looked(geometry: Geometry) -> list[str]:
    """Its lines."""
    said: list[str] = []
    look(geometry, said)
    return said

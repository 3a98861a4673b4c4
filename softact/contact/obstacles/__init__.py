"""Obstacles, one kind a file; ``OBSTACLES`` holds them by the word after ``type`` in a spec."""

from softact.contact.obstacles.base import Shape, SpecObstacle
from softact.contact.obstacles.block import BlockObstacle
from softact.contact.obstacles.cylinder import CylinderObstacle
from softact.contact.obstacles.mesh import MeshObstacle
from softact.contact.obstacles.plane import PlaneObstacle
from softact.contact.obstacles.sphere import SphereObstacle

OBSTACLES: dict[str, type[SpecObstacle]] = {
    obstacle.kind: obstacle
    for obstacle in (PlaneObstacle, BlockObstacle, CylinderObstacle, SphereObstacle, MeshObstacle)
}

__all__ = ["OBSTACLES", "Shape", "SpecObstacle"]

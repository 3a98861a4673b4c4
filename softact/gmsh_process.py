"""The process in which gmsh runs: reads a job from stdin, writes one file, says faults on stdout.

Started by ``softact.geometry`` only. A fault is a line that starts with ``softact-fault:``.
"""

import importlib
import importlib.util
import json
import sys

import gmsh
import numpy as np

from softact.geometry import FAULT, Geometry


class Fault(Exception):
    """The mesh is not what the geometry promises."""


def main() -> int:
    job = json.load(sys.stdin)
    geometry = load(job)
    gmsh.initialize(readConfigFiles=False)
    gmsh.option.setNumber("General.NumThreads", 1)
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.model.add("softact")
    geometry.build(gmsh)
    geometry.mesh(gmsh)
    gmsh.write(job["path"])
    gmsh.finalize()
    return 0


def load(job: dict) -> Geometry:
    """The geometry object of a job. Its parameters were validated by the caller."""
    try:
        module = importlib.import_module(job["module"])
        if module.__name__ == "__main__":
            raise ImportError
    except ImportError:
        spec = importlib.util.spec_from_file_location("geometry_script", job["file"])
        module = importlib.util.module_from_spec(spec)
        sys.modules["geometry_script"] = module
        spec.loader.exec_module(module)
    kind = getattr(module, job["class"])
    return kind.model_construct(**job["parameters"])


if __name__ == "__main__":
    sys.exit(main())

"""The choice of a geometry by softact and by pydantic's discriminated union, beside each other:
``python -m benchmarks.choice`` prints times (processor, medians) and what is said of bad input.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from functools import reduce
from operator import or_
from typing import Annotated, Any

from pydantic import BaseModel, Discriminator, Tag, TypeAdapter, ValidationError

from softact.geometries import GEOMETRIES
from softact.spec.choice import GeometryChoice

GOOD = {"type": "pneunet", "chambers": 4, "mesh_size": "6 mm"}
BAD = (
    {"type": "pneunett"},
    {"chambers": 4},
    {"type": "pneunet", "chamberz": 4, "mesh_size": "2 kPa"},
)


def union() -> TypeAdapter:
    """Pydantic's own."""

    def tag(value: Any) -> str | None:
        return value.get("type") if isinstance(value, dict) else None

    members = tuple(Annotated[kind, Tag(name)] for name, kind in GEOMETRIES.items())
    return TypeAdapter(Annotated[reduce(or_, members), Discriminator(tag)])


def own() -> TypeAdapter:
    """Softact's."""
    return TypeAdapter(Annotated[BaseModel, GeometryChoice(lambda: GEOMETRIES)])


def milliseconds(action: Callable[[], object], count: int = 9) -> float:
    """Median processor time of one call."""
    times = []
    for _ in range(count):
        started = time.process_time()
        action()
        times.append(1e3 * (time.process_time() - started))
    return statistics.median(times)


def main() -> None:
    """Measure and print."""
    for make in (union, own):
        adapter = make()
        built = milliseconds(make)
        read = milliseconds(lambda a=adapter: [a.validate_python(GOOD) for _ in range(100)]) / 100
        print(f"{make.__name__}: built in {built:.2f} ms, a geometry read in {read:.2f} ms")
        for data in BAD:
            try:
                adapter.validate_python(data)
            except ValidationError as error:
                for found in error.errors():
                    place = ".".join(map(str, found["loc"])) or "(the geometry)"
                    print(f"    {data}: {place}: {found['msg']}")


if __name__ == "__main__":
    main()

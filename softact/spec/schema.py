"""The JSON schema of a spec, with which an editor completes and checks the YAML."""

from typing import Any

from softact.spec.models import Spec
from softact.units import DIMENSIONS, SCHEMA_KEY, Dimension

_DIMENSIONS = {dimension.name: dimension for dimension in DIMENSIONS}
_BOUNDS = {
    "gt": "exclusiveMinimum",
    "ge": "minimum",
    "lt": "exclusiveMaximum",
    "le": "maximum",
}


def json_schema() -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of a spec: values with units are texts there."""
    schema = _tidy(Spec.model_json_schema())
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def _tidy(node: Any) -> Any:
    """Return a schema with defaults as one writes them, and without what no editor knows."""
    if isinstance(node, list):
        return [_tidy(entry) for entry in node]
    if not isinstance(node, dict):
        return node
    dimension = _dimension(node)
    result = {key: _tidy(value) for key, value in node.items() if key != SCHEMA_KEY}
    for bound, keyword in _BOUNDS.items():
        # pydantic leaves its own words on what a validator of ours stands before.
        if isinstance(limit := result.get(bound), int | float):
            del result[bound]
            if result.get("type") == "number":
                result[keyword] = limit
    if dimension is not None and isinstance(result.get("default"), float):
        result["default"] = dimension.format(result["default"])
    if result.get("default", 0) is None:
        del result["default"]
    for key in ("type", "law"):
        # What tells one geometry or law from another has to be written.
        properties = result.get("properties")
        if isinstance(properties, dict) and "const" in properties.get(key, {}):
            result["required"] = [key, *result.get("required", [])]
    return result


def _dimension(node: dict[str, Any]) -> Dimension | None:
    for part in (node, *node.get("anyOf", ())):
        name = part.get(SCHEMA_KEY) if isinstance(part, dict) else None
        if isinstance(name, str):
            return _DIMENSIONS[name]
    return None

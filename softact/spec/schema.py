"""The JSON schemas of a spec and of other files, with which an editor completes and checks YAML."""

from typing import Any

from pydantic import BaseModel

from softact.spec.models import Spec
from softact.units import DIMENSIONS, SCHEMA_KEY, Dimension

_DIMENSIONS = {dimension.name: dimension for dimension in DIMENSIONS}
_BOUNDS = {
    "gt": "exclusiveMinimum",
    "ge": "minimum",
    "lt": "exclusiveMaximum",
    "le": "maximum",
}


DRAFT = "https://json-schema.org/draft/2020-12/schema"


def json_schema(model: type[BaseModel] = Spec, inside: str | None = None) -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of a file: values with units are texts there.

    inside: key under which the file may hold a spec, of which a part may be set elsewhere.
    """
    schema = _tidy(model.model_json_schema())
    if inside is not None:
        spec = _tidy(Spec.model_json_schema())
        parts = spec.pop("$defs")
        spec.pop("required")
        schema["$defs"] = {**schema.get("$defs", {}), **parts, "Spec": spec}
        described = schema["properties"][inside].get("description", "")
        either = [{"type": "string"}, {"$ref": "#/$defs/Spec"}]
        schema["properties"][inside] = {"anyOf": either, "description": described}
    return {"$schema": DRAFT, **schema}


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

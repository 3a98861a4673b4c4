"""Plain data as YAML that reads well and reads back equal."""

from typing import Any

import yaml

from softact.files.document import Loader


class _Dumper(yaml.SafeDumper):
    """Short lists of scalars stand in one line; what any YAML could misread is quoted."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


# Text is quoted where YAML 1.1 or our own loader would take it for something else.
_Dumper.yaml_implicit_resolvers = {
    first: list(resolvers) for first, resolvers in yaml.SafeDumper.yaml_implicit_resolvers.items()
}
_Dumper.yaml_implicit_resolvers[None] = list(Loader.yaml_implicit_resolvers[None])


def _sequence(dumper: _Dumper, data: list[Any]) -> yaml.Node:
    flat = all(not isinstance(entry, dict | list) for entry in data)
    short = flat and sum(len(str(entry)) for entry in data) < 60
    return dumper.represent_sequence("tag:yaml.org,2002:seq", data, flow_style=short)


def _string(dumper: _Dumper, data: str) -> yaml.Node:
    # PyYAML loses the line breaks of Unicode in any style that does not escape them.
    style = '"' if any(line_break in data for line_break in "\x85\u2028\u2029") else None
    return dumper.represent_scalar("tag:yaml.org,2002:str", data, style=style)


_Dumper.add_representer(list, _sequence)
_Dumper.add_representer(str, _string)


def to_text(data: dict[str, Any] | list[Any]) -> str:
    """Return plain data as YAML text, keys in their order."""
    return yaml.dump(data, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=90)

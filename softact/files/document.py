"""A YAML text as plain data, with the line of each value. Hostile text ends in a plain error."""

import copy
import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Self

import yaml

from softact.errors import SpecError
from softact.files.text import read_file
from softact.units import is_utf8, one_line, show

MAX_BYTES = 1_000_000
MAX_VALUES = 20_000
MAX_DEPTH = 30
WANTED = "the YAML file of a spec"

Place = tuple[str | int, ...]


@dataclass
class Document:
    """Plain data (dict, list, str, int, float, bool, None) and where each value stands.

    name: of the file, for messages.
    lines: place of a value, such as ``("steps", 1, "pressure")``, -> its line, counted from 1.
    overridden: place of a value set from outside the file -> where that was, as a message begins.
    folder: where the relative file names in it count from.
    """

    name: str
    data: Any
    lines: dict[Place, int] = field(default_factory=dict)
    overridden: dict[Place, str] = field(default_factory=dict)
    folder: Path = Path()

    def where(self, place: Place) -> str:
        """Return the start of a message about ``place``: file and line, or the override."""
        for length in range(len(place), -1, -1):
            if place[:length] in self.overridden:
                return self.overridden[place[:length]]
            if place[:length] in self.lines:
                return f"{self.name}:{self.lines[place[:length]]}"
        return self.name

    def has(self, place: Place) -> bool:
        """Whether the data holds a value at ``place``."""
        try:
            self.value(place)
        except LookupError:
            return False
        return True

    def value(self, place: Place) -> Any:
        """Return the value at ``place``. Raises LookupError where there is none."""
        value = self.data
        for key in place:
            value = item(value, key)
        return value

    def within(self, key: str) -> Self:
        """Return what stands under a key of the file as a document of its own."""
        lines = {place[1:]: line for place, line in self.lines.items() if place[:1] == (key,)}
        return replace(self, data=copy.deepcopy(self.data[key]), lines=lines, overridden={})

    def copy(self) -> Self:
        """Return a copy that may be changed."""
        data, lines = copy.deepcopy(self.data), dict(self.lines)
        return replace(self, data=data, lines=lines, overridden=dict(self.overridden))


def item(value: Any, key: str | int) -> Any:
    """Return an entry of a mapping or list. Raises LookupError where there is none."""
    if isinstance(value, dict):
        return value[key]
    if isinstance(value, list) and isinstance(key, int) and key >= 0:
        return value[key]
    raise LookupError(key)


class Loader(yaml.SafeLoader):
    """YAML 1.2's idea of a scalar: 1e-4 is a number, 1:30 is no time, 010 no octal, yes a word.

    It stops at the first value too many: a megabyte of them would take PyYAML ten seconds.
    """

    def __init__(self, text: str):
        super().__init__(text)
        self.composed, self.depth = 0, 0

    def compose_node(self, parent: Any, index: Any) -> yaml.Node:
        """See PyYAML."""
        mark = self.peek_event().start_mark
        self.composed, self.depth = self.composed + 1, self.depth + 1
        if self.composed > 2 * MAX_VALUES:  # keys are counted here too
            raise _TooMuchError(mark, f"more than {MAX_VALUES} values, so no spec")
        if self.depth > MAX_DEPTH + 1:
            raise _TooMuchError(mark, "values are nested too deeply for a spec")
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node


class _TooMuchError(yaml.MarkedYAMLError):
    """A text that no spec can be."""

    def __init__(self, mark: yaml.Mark, fault: str):
        super().__init__(problem=fault, problem_mark=mark)


Loader.yaml_implicit_resolvers = {}
for _tag, _pattern in {
    "bool": r"(true|True|TRUE|false|False|FALSE)\Z",
    "null": r"(~|null|Null|NULL|)\Z",
    "int": r"[-+]?[0-9]{1,300}\Z",
    "float": r"([-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?"
    r"|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN))\Z",
}.items():
    Loader.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(_pattern), None)


def read(path: Path) -> Document:
    """Read a YAML file. Raises SpecError where it is no readable text file with one mapping."""
    name = one_line(str(path))
    content = read_file(path, MAX_BYTES, WANTED)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = "\0"
    if "\0" in text:
        raise SpecError(f"{name}: this is not a text file in UTF-8; give {WANTED}")
    return parse(text, name, path.parent)


def parse(text: str, name: str, folder: Path = Path()) -> Document:
    """Parse YAML text whose top is a mapping; ``folder``: where files in it count from.

    Raises SpecError with the line of each fault.
    """
    node = _compose(text, name)
    if node is None:
        raise SpecError(f"{name}: the file is empty; 'softact schema' says what a spec holds")
    walk = _Walk(name)
    data = walk.value(node, ())
    if walk.faults:
        raise SpecError(*walk.faults)
    if not isinstance(data, dict):
        raise SpecError(
            f"{name}:{node.start_mark.line + 1}: a spec is a mapping, 'key: value' on each line"
        )
    return Document(name, data, walk.lines, folder=folder)


def scalar(text: str) -> Any:
    """Return the value of YAML text given on a command line, such as ``30 kPa`` or ``[x, y]``."""
    walk = _Walk("")
    try:
        node = _compose(text, "")
        value = None if node is None else walk.value(node, ())
    except SpecError as error:
        walk.faults += error.lines
    if walk.faults:
        raise SpecError(*(re.sub(r"^(:\d+)?: ", "", fault) for fault in walk.faults))
    return value


def _compose(text: str, name: str) -> yaml.Node | None:
    try:
        loader = Loader(text)
        try:
            return loader.get_single_node()
        finally:
            loader.dispose()
    except _TooMuchError as error:
        line = error.problem_mark.line + 1
        raise SpecError(f"{name}:{line}: {error.problem}") from None
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f":{mark.line + 1}" if mark else ""
        raise SpecError(f"{name}{line}: {_yaml_fault(error)}") from None
    except yaml.reader.ReaderError as error:
        line = text[: error.position].count("\n") + 1
        raise SpecError(f"{name}:{line}: a control character; is this a text file?") from None


def _yaml_fault(error: yaml.MarkedYAMLError) -> str:
    problem = " ".join(str(error.problem).split())
    if "'\\t'" in problem:
        return "a tab cannot indent in YAML; use spaces"
    if "single document" in str(error.context or ""):
        return "a second document starts here ('---'); a spec is one document"
    if problem == "mapping values are not allowed here":
        problem += " (a second ': ' on the line, or wrong indentation)"
    context = f" {error.context}" if error.context else ""
    return f"this is not valid YAML{context}: {problem}"


class _Walk:
    """Builds plain data from YAML nodes, noting lines and collecting faults."""

    def __init__(self, name: str):
        self.name = name
        self.lines: dict[Place, int] = {}
        self.faults: list[str] = []
        self.count = 0
        self.open: list[int] = []

    def value(self, node: yaml.Node, place: Place) -> Any:
        line = node.start_mark.line + 1
        self.lines.setdefault(place, line)
        self.count += 1
        if self.count > MAX_VALUES:
            # Aliases multiply: some hundred bytes can stand for a billion values.
            fault = f"{self.name}: aliases expand to more than {MAX_VALUES} values, so no spec"
            raise SpecError(fault)
        if id(node) in self.open:
            raise SpecError(f"{self.name}:{line}: an alias that holds itself")
        if len(place) > MAX_DEPTH:
            raise SpecError(f"{self.name}:{line}: values are nested too deeply for a spec")
        if isinstance(node, yaml.ScalarNode):
            return self._scalar(node, place)
        self.open.append(id(node))
        try:
            if isinstance(node, yaml.SequenceNode):
                self._known_tag(node, place, "seq")
                return [self.value(item, (*place, i)) for i, item in enumerate(node.value)]
            self._known_tag(node, place, "map")
            return self._mapping(node, place)
        finally:
            self.open.pop()

    def _mapping(self, node: yaml.MappingNode, place: Place) -> dict[str, Any]:
        result: dict[str, Any] = {}
        for key_node, value_node in node.value:
            line = key_node.start_mark.line + 1
            if not isinstance(key_node, yaml.ScalarNode):
                self._fault(line, place, "a key must be a word, not a list or mapping")
                continue
            key = self._text(key_node, place)
            if key in result:
                first = self.lines[(*place, key)]
                self._fault(line, (*place, key), f"given twice, first in line {first}; keep one")
                continue
            if key == "<<":
                self._fault(line, (*place, key), "merge keys are not supported; repeat the values")
                continue
            self.lines[(*place, key)] = line
            result[key] = self.value(value_node, (*place, key))
        return result

    def _scalar(self, node: yaml.ScalarNode, place: Place) -> Any:
        kind = node.tag.removeprefix("tag:yaml.org,2002:")
        text = self._text(node, place)
        try:
            if kind == "str":
                return text
            if kind == "null":
                return None
            if kind == "bool":
                return text.lower() == "true"
            if kind == "int":
                return int(text)
            if kind == "float":
                return float(text.lower().replace(".inf", "inf").replace(".nan", "nan"))
        except ValueError:
            pass
        self._fault(node.start_mark.line + 1, place, f"a value with the tag {show(node.tag)}")
        return None

    def _text(self, node: yaml.ScalarNode, place: Place) -> str:
        if not is_utf8(node.value):
            fault = "half of a character (a surrogate), which no file can hold"
            self._fault(node.start_mark.line + 1, place, fault)
        return node.value

    def _known_tag(self, node: yaml.Node, place: Place, kind: str) -> None:
        if node.tag != f"tag:yaml.org,2002:{kind}":
            fault = f"the tag {show(node.tag)} is not allowed; write plain values"
            self._fault(node.start_mark.line + 1, place, fault)

    def _fault(self, line: int, place: Place, fault: str) -> None:
        at = f"{dotted(place)}: " if place else ""
        self.faults.append(f"{self.name}:{line}: {at}{fault}")


def dotted(place: Place) -> str:
    """Return a place as ``steps.1.pressure``, on one line."""
    return ".".join(show(key)[1:-1] for key in place)

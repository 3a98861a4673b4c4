"""The examples of docs/load_cases.md are specs."""

import re
from pathlib import Path

import pytest

from softact import spec as specs

PAGE = Path(__file__).resolve().parents[2] / "docs" / "load_cases.md"
EXAMPLES = re.findall(r"```yaml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)


@pytest.mark.parametrize("text", EXAMPLES)
def test_each_example_is_a_spec(text):
    spec = specs.loads(text)
    assert specs.loads(spec.to_yaml()) == spec


def test_there_are_as_many_as_the_page_has_sections():
    assert len(EXAMPLES) == PAGE.read_text(encoding="utf-8").count("\n## ")

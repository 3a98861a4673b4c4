"""Fast tests first: see ``tests/conftest.py``."""

from pathlib import Path
from types import SimpleNamespace

from tests.conftest import SLOW, pytest_collection_modifyitems

TESTS = Path(__file__).parents[1]


def test_every_slow_module_is_there_once():
    assert len(set(SLOW)) == len(SLOW)
    assert [name for name in SLOW if not (TESTS / f"{name}.py").is_file()] == []


def test_slow_modules_come_last_and_the_others_stay_as_they_are():
    names = ["run/test_run", "units", "run/test_run", "house/test_killed_studies", "run/test_held"]
    items = [SimpleNamespace(path=TESTS / f"{name}.py", n=n) for n, name in enumerate(names)]
    pytest_collection_modifyitems(items)
    assert [item.n for item in items] == [1, 4, 3, 0, 2]

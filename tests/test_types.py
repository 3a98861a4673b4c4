"""What has no type yet gets less, and no module joins those that mypy excuses.

`make lint` runs mypy itself. The two numbers are of the last time that somebody lowered them; one
who mends more lowers them again.
"""

from benchmarks.house import excused, files, parameters

UNTYPED = 639
EXCUSED = 78


def test_parameters_without_a_type_get_fewer():
    found = [parameters(file.read_text(encoding="utf-8"))[0] for file in files().values()]
    assert sum(found) <= UNTYPED


def test_modules_that_mypy_excuses_get_fewer():
    # mypy knows the two mapped packages by their folders.
    mapped = ("softact.cli", "softact.geometries")
    known = {name.removeprefix("softact.") if name.startswith(mapped) else name for name in files()}
    assert len(excused()) <= EXCUSED
    assert set(excused()) <= known, "no such module: take it out of pyproject.toml"


def test_what_a_parameter_without_a_type_is():
    source = "class A:\n def f(self, a, b: int, *c, d=1, **e: str): ...\ng = lambda x: x"
    assert parameters(source) == (3, 5)

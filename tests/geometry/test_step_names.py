"""What is read out of the text of a STEP file."""

import re

import pytest

from softact.errors import MeshError
from softact.geometry.step_names import StepFile, decoded
from tests import step_files


@pytest.fixture(scope="module")
def text(tmp_path_factory):
    """A block with named ends and room on a plate, two solids."""
    path = tmp_path_factory.mktemp("step") / "two.step"
    step_files.write(
        path, step_files.on_a_plate(), step_files.ends_and_room, solids=("rubber", "base")
    )
    return path.read_text()


@pytest.mark.parametrize("unit", ["mm", "cm", "m", "in"])
def test_the_unit_is_that_of_the_header(text, unit):
    assert StepFile(step_files.in_unit(text, unit)).units() == [unit]


def test_names_of_solids_and_faces(text):
    rubber, base = StepFile(text).bodies()
    assert (rubber.name, base.name) == ("rubber", "base")
    assert [face.name for face in rubber.faces].count("cavity") == 6
    assert sorted(filter(None, (face.name for face in base.faces))) == ["clamp", "tip"]
    # Without names of their own they have those of their products, not of the assembly's.
    bare = text.replace("BREP_WITH_VOIDS('rubber'", "BREP_WITH_VOIDS('NONE'")
    assert StepFile(bare).bodies()[0].name.endswith(".1")


def test_strings_hold_semicolons_quotes_and_letters_of_any_alphabet(text):
    odd = text.replace("'rubber'", r"'it''s; \X2\00E400DF\X0\ /* no comment */'")
    odd = odd.replace("DATA;", "DATA;\n/* don't read; this */")
    assert StepFile(odd).bodies()[0].name == "it's; äß /* no comment */"
    assert decoded(r"\X\E4 \S\d a\\b") == "ä ä a\\b"


def test_damaged_text_is_read_as_far_as_it_goes(text):
    """Cut anywhere, or with an entity missing: no error of Python's."""
    for part in range(1, 20):
        cut = text[: len(text) * part // 20]
        if "DATA;" in cut:
            StepFile(cut).bodies()
    for number in re.findall(r"^#(\d+) =", text, re.MULTILINE)[::37]:
        StepFile(re.sub(rf"^#{number} =.*?;", "", text, flags=re.MULTILINE | re.DOTALL)).bodies()
    with pytest.raises(MeshError, match="no STEP file"):
        StepFile("solid ascii\nendsolid")

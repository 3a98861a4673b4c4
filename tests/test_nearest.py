"""What is told of unknown words: the one that was meant, or all that there are."""

import pytest

from softact.nearest import MOST_SHOWN, nearest
from softact.spec.models import Spec, Step

MEANT = {
    "presure": "pressure",  # a letter left out
    "preessure": "pressure",  # one too many
    "pressurd": "pressure",  # another one
    "rpessure": "pressure",  # two swapped
    "Pressure": "pressure",
    "tractoin": "traction",
    "supports_": "supports",
    "surface_presure": "surface_pressure",
    "max": "max_increment",  # its beginning
    "increment": "max_increment",  # a part of it
}


@pytest.mark.parametrize("word", MEANT)
def test_a_word_that_is_really_near_is_suggested(word):
    assert nearest(word, Step.model_fields) == f"did you mean '{MEANT[word]}'?"


@pytest.mark.parametrize("word", ["pause", "time", "x", "", "stepp", "sure", "load"])
def test_of_a_word_that_is_near_to_none_all_are_told(word):
    """'duration' and 'traction' have a ratio of difflib of 0.75."""
    assert nearest(word, Step.model_fields) == f"known: {', '.join(Step.model_fields)}"


@pytest.mark.parametrize("word", ["trials", "values", "parameters", "duration"])
def test_keys_of_other_files_are_no_misspelt_keys_of_a_spec(word):
    assert nearest(word, Spec.model_fields).startswith("known: name, description, ")


def test_short_words_are_near_only_by_one_letter_of_several():
    assert nearest("c1", ["c10", "density"]) == "did you mean 'c10'?"
    assert nearest("yeo", ["yeoh", "ogden"]) == "did you mean 'yeoh'?"
    assert nearest("b", ["a"]) == "known: a"


def test_several_parts_and_many_words():
    assert nearest("wall", ["inner_wall", "roof", "outer_wall"]) == (
        "did you mean 'inner_wall' or 'outer_wall'?"
    )
    assert nearest("x", []) == "none is known here"
    many = [f"number_{i}" for i in range(MOST_SHOWN + 1)]
    assert nearest("x", many).endswith(f"number_{MOST_SHOWN - 1}, ...")

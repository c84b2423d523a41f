"""A sentence is in one language, and who copies it copies that too."""

import copy
import pickle

from autodb.errors import UnusableInput
from autodb.wording import (
    Presentation,
    Worded,
    amount_words,
    day,
    language_of,
    listed,
    localized,
    phrase,
    phrase_many,
    presented,
)

GERMAN = Presentation("de")


def test_sentences_are_english_where_nobody_chose() -> None:
    assert phrase("cut {number}", number=3) == "cut 3"
    assert language_of(phrase("cut {number}", number=3)) == "en"
    assert amount_words(12345.678, "N", ".7g") == "12345.68 N"


def test_a_sentence_is_looked_up_with_its_numbers() -> None:
    with presented(GERMAN):
        assert phrase("cut {number}", number=3) == "Schnitt 3"
        assert [
            phrase_many("{count} mismatch", "{count} mismatches", count) for count in (1, 2)
        ] == [
            "1 Abweichung",
            "2 Abweichungen",
        ]
    assert phrase("cut {number}", number=3) == "cut 3"


def test_what_the_catalogue_has_not_is_said_in_english_and_says_so() -> None:
    with presented(GERMAN):
        assert language_of(phrase("nobody says this")) == "en"
        assert language_of(phrase_many("this", "these {count}", 2)) == "en"


def test_a_sentence_with_a_part_in_english_alone_is_english_throughout() -> None:
    with presented(GERMAN):
        inner = UnusableInput("a.csv, line 3: no number")
        said = phrase("cut {number}: {problem}", number=1, problem=inner)
        assert (said, said.language) == ("cut 1: a.csv, line 3: no number", "en")
        assert UnusableInput(said).language == "en"
        german = UnusableInput(phrase("the token is not valid"))
        assert phrase("cut {number}: {problem}", number=1, problem=german).startswith("Schnitt 1: ")
        assert listed([phrase("yes"), Worded("kept", "en")]).language == "en"
        assert listed([phrase("yes"), "lathe-1"]).language == "de"


def test_copies_know_their_language() -> None:
    with presented(GERMAN):
        said = phrase("yes")
    assert pickle.loads(pickle.dumps(said)).language == "de"
    assert copy.deepcopy(said).language == "de"


def test_numbers_have_the_marks_of_the_language() -> None:
    assert localized("12345.5") == "12345.5"
    with presented(GERMAN):
        assert localized("1234.5") == "1234,5"
        assert localized("12345.678") == "12\u202f345,678"
        assert localized("0.0001234567") == "0,0001234567"
        assert localized("−1234567") == "−1\u202f234\u202f567"
        assert amount_words(2500.0, "rpm") == "2500 1/min"
        assert day("2026-03-01T07:30:12+00:00") == "01.03.2026 07:30"
        assert day("2026-03-01") == "01.03.2026"

"""What was said in English while a command worked knows what it was made of."""

import copy
import pickle

from autodb.errors import UnusableInput, together
from autodb.files.units import presentation_of
from autodb.wording import language_of, listed, phrase, presented
from autodb.wording.kept import said_again


def _refused() -> UnusableInput:
    inner = phrase("{file}: no cut {cut}; it has {numbers}", file="a.csv", cut="3", numbers="1, 2")
    line = phrase("mismatch {number} stays open: {error}", number=4, error=UnusableInput(inner))
    return UnusableInput(line)


def test_a_refusal_in_a_refusal_is_said_again_with_the_same_numbers() -> None:
    error = _refused()
    assert str(error) == "mismatch 4 stays open: a.csv: no cut 3; it has 1, 2"
    with presented(presentation_of("de", "si")):
        said = said_again(error.line)
    assert said == "Abweichung 4 bleibt offen: a.csv: kein Schnitt 3; sie hat 1, 2"
    assert language_of(said) == "de"


def test_several_problems_amounts_and_days_are_said_again() -> None:
    size = phrase("{what}, started from version {parent}", what="4.4482216 N", parent=2)
    day = phrase("{decided} on {day}", decided=phrase("confirmed"), day="2026-03-01 07:30")
    both = together("a.csv", [size, listed([day, phrase("passed")], phrase(" and "))])
    with presented(presentation_of("de", "inch")):
        said = said_again(both.line)
    assert said.startswith("a.csv: 2 Fehler: (1) 1 lbf, ausgehend von Fassung 2; (2) bestätigt am ")
    assert said.endswith("01.03.2026 07:30 und bestanden")


def test_a_copy_is_the_text_in_its_language() -> None:
    said = _refused().line
    for made in (copy.deepcopy(said), pickle.loads(pickle.dumps(said))):
        assert made == said
        assert language_of(made) == "en"

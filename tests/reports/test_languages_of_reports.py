"""The report of an explanation in another language: every sentence of it is looked up.

What explaining itself states is in English and says so.
"""

import re
from gettext import NullTranslations

import pytest

from autodb.explain.axis.apart import NOISE, NONE_TELLS
from autodb.explain.axis.moves import LIBRARY, Reach
from autodb.explain.cuts.distinguishing import SCATTER, THINNER
from autodb.explain.engine.telling import Separation, sentence
from autodb.explain.waves.answers import APART
from autodb.reports.explanation import explanation_fragment, move_words, term_words
from autodb.terms.vocabulary import all_terms
from autodb.wording import Presentation, catalogues, language_of, presented
from tests.helpers.explanations import channel, explained, friction
from tests.helpers.marked_words import Marked, Read, unmarked

DATA = re.compile(r"\b[xyz]\.[a-z_.]+|\brms\b|\bmm\b|^\(P\d .*\)$")
"""Channels, units, and where what to check is from."""


def _left(language: NullTranslations, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return what a German report says without looking it up."""
    monkeypatch.setattr(catalogues, "catalogue", lambda _language: language)
    found = explained(channel(friction(), friction(term="gain", confidence=0.7)))
    with presented(Presentation("de")):
        made = explanation_fragment(found)
    texts = Read(f'<html lang="de">{made}</html>').texts
    rest = [DATA.sub(" ", unmarked(text)) for text, shown in texts if shown == "de"]
    return [text for text in rest if re.search(r"[A-Za-z]{2,}", text)]


def test_every_sentence_of_an_explanation_is_looked_up(monkeypatch: pytest.MonkeyPatch) -> None:
    assert _left(Marked(), monkeypatch) == []


def test_what_is_not_looked_up_would_show(monkeypatch: pytest.MonkeyPatch) -> None:
    """The marks are what the other test goes by: without them everything is left."""
    assert len(_left(NullTranslations(), monkeypatch)) > 10


PAIR = ("tool_wear", "gain")
AXIS = Reach(low_mm=-20.0, high_mm=380.0, top_mm_s=400.0, top_mm_s2=2500.0)


def _to_be_done() -> list[str]:
    """Return sentences on what would tell two effects apart, of every kind."""
    noise = (NOISE.format(size="0.02 A"), SCATTER.format(size="3.1 N", count="5.2"))
    moves = [Separation(move.words(AXIS), 1.0, 1.0, 1234.5) for move in LIBRARY]
    terms = [term.distinguished_by for term in all_terms() if term.distinguished_by]
    said = [sentence(move, PAIR, "A", noise[k % 2]) for k, move in enumerate(moves)]
    none = NONE_TELLS.format(one=PAIR[0], other=PAIR[1])
    thin = THINNER.format(size="0.03 mm", one=PAIR[0], other=PAIR[1])
    return [*said, none, thin, *terms, *APART.values(), f"{none} {terms[0]}"]


def test_what_tells_causes_apart_is_said_in_the_readers_language() -> None:
    for text in _to_be_done():
        assert "e+" not in text
        with presented(Presentation("de")):
            said = move_words(PAIR[0], PAIR[1:], text, term_words)
        assert language_of(said) == "de", text
        assert not re.search(r"\b(the|and|there|tool wear|tool_wear)\b", said)
    with presented(Presentation("de")):
        unknown = move_words(PAIR[0], PAIR[1:], "Ask tool_wear and gain.", term_words)
    assert (language_of(unknown), unknown) == ("en", "Ask tool wear and a changed scale.")

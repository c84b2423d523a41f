"""The report of an explanation in another language: every sentence of it is looked up.

What explaining itself states is in English and says so.
"""

import re
from gettext import NullTranslations

import pytest

from autodb.explain.answer import IntervalValue
from autodb.explain.axis.apart import NOISE, NONE_TELLS
from autodb.explain.axis.moves import LIBRARY, Reach
from autodb.explain.cuts.distinguishing import SCATTER, THINNER
from autodb.explain.engine.telling import Separation, sentence
from autodb.explain.several_recordings import (
    SHOWS,
    SWAPPED,
    WITH_SEVERAL,
    ExplainedTogether,
    Located,
    RecordingSetup,
    Seat,
)
from autodb.explain.waves.answers import APART
from autodb.files.units import presentation_of
from autodb.reports.explanation import explanation_fragment, move_words, term_words
from autodb.reports.together_page import render_together
from autodb.terms.vocabulary import all_terms
from autodb.wording import Presentation, catalogues, language_of, presented
from tests.helpers.explanations import channel, explained, friction, readable
from tests.helpers.marked_words import Marked, Read, left_of_page, unmarked

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


def _together() -> ExplainedTogether:
    """Return what two recordings say of an effect that may sit in tool or machine."""
    setups = tuple(
        RecordingSetup(recording=f"r{k}.csv", machine="M1", tool=f"T{k}", material=None,
                       sensor=None, calibration=None)
        for k in (1, 2)
    )  # fmt: skip
    shown = SHOWS.format(channel="force.y", causes="tool wear", count=1, n=2)
    first = {"causes": "tool", "causes_other": "machine"}
    effect = Located(
        channel="force.y",
        term="tool_wear",
        quantity="size",
        values=(IntervalValue(value=1234.5, low=1200.0, high=1300.0, unit="N"), None),
        sits_in=(Seat(factor="tool", confidence=0.7), Seat(factor="machine", confidence=0.2)),
        statement=WITH_SEVERAL.format(found=shown, **first),
        to_tell_apart=SWAPPED.format(one="r1.csv", other="r2.csv", **first),
    )
    return ExplainedTogether(recordings=setups, effects=(effect,))


def test_the_page_of_several_recordings_is_german_throughout() -> None:
    with presented(presentation_of("de", "inch")):
        page = render_together(_together())
    assert '<html lang="de">' in page
    assert 'lang="en"' not in page
    text = readable(page)
    for said in (
        "force.y: Werkzeugverschleiß zeigt sich in 1 von 2 Aufnahmen und geht mit: Werkzeug; oder",
        "nur eins tauschen (Werkzeug, wie bei r2.csv)", "Maschine: eine Vermutung, 20 %",
        "278 lbf",
    ):  # fmt: skip
        assert said in text, said


def test_every_sentence_of_that_page_is_looked_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(catalogues, "catalogue", lambda _language: Marked())
    with presented(Presentation("de")):
        page = render_together(_together())
    names = re.compile(r"r\d\.csv|\b[MT]\d\b|\blbf\b")
    assert [names.sub("", one) for one in left_of_page(page) if names.sub("", one).strip()] == []


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

"""The report of an explanation in another language: every sentence of it is looked up.

What explaining itself says, statements and moves that tell causes apart, is in English and says so.
"""

import re
from gettext import NullTranslations

import pytest

from autodb.reports.explanation import explanation_fragment
from autodb.wording import Presentation, catalogues, presented
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

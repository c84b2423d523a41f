"""What is advised for a term: one sentence with its source for each, and nothing else."""

import re

import pytest

from autodb.explain.answer.advice import advice, book
from autodb.explain.engine.candidates import UNKNOWN
from autodb.reports.explanation import TERM_WORDS, render_explanation
from autodb.terms.vocabulary import VOCABULARY
from tests.helpers.explanations import channel, explained, friction, readable


def test_every_term_has_advice_and_nothing_else_has() -> None:
    assert set(book()) == {*VOCABULARY, UNKNOWN} == set(TERM_WORDS)


@pytest.mark.parametrize("term", sorted(book()))
def test_advice_is_one_sentence_to_check_with_its_source(term: str) -> None:
    entry = advice(term)
    assert entry.check.startswith("Check ")
    assert re.findall(r"[.!?](?=\s|$)", entry.check) == ["."]
    assert re.search(r"P[0124] section|ISO \d|\(\d{4}\)|section \d", entry.source)


def test_no_two_terms_are_advised_alike() -> None:
    assert len({entry.check for entry in book().values()}) == len(book())


def test_the_report_says_what_to_check_beside_the_cause() -> None:
    cause = friction()
    page = readable(render_explanation(explained(channel(cause))))
    entry = advice(cause.term)
    assert f"{entry.check} ({entry.source})" in page
    assert "Check" not in readable(render_explanation(explained(channel())))

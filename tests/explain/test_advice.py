"""What is advised for a term: one sentence with its source for each, and nothing else."""

import re

import pytest

from autodb.explain.engine.candidates import UNKNOWN
from autodb.reports.explanation import render_explanation
from autodb.terms.vocabulary import effect_called, vocabulary
from tests.helpers.explanations import channel, explained, friction, readable

NAMES = sorted((*vocabulary(), UNKNOWN))


@pytest.mark.parametrize("term", NAMES)
def test_advice_is_one_sentence_to_check_with_its_source(term: str) -> None:
    entry = effect_called(term)
    assert entry.title
    assert entry.check.startswith("Check ")
    assert re.findall(r"[.!?](?=\s|$)", entry.check) == ["."]
    assert re.search(r"P[0124] section|ISO \d|\(\d{4}\)|section \d", entry.check_source)


def test_no_two_terms_are_advised_alike() -> None:
    assert len({effect_called(name).check for name in NAMES}) == len(NAMES)


def test_the_report_says_what_to_check_beside_the_cause() -> None:
    cause = friction()
    page = readable(render_explanation(explained(channel(cause))))
    entry = effect_called(cause.term)
    assert f"{entry.check} ({entry.check_source})" in page
    assert "Check" not in readable(render_explanation(explained(channel())))

"""The summary quotes what the page of all figures has, and nothing else has a number in it."""

import re

import pytest

from docs.make import standing, summary
from docs.make.summary import CHOSEN, NoSuchFigure

MADE = re.compile(r"<!-- (counts|results) -->.*?<!-- end of \1 -->", re.DOTALL)


def test_the_summary_is_what_the_summaries_of_proofs_say() -> None:
    text = summary.PAGE.read_text("utf-8")
    assert summary.filled(text) == text


def test_no_result_is_typed() -> None:
    typed = MADE.sub("", summary.PAGE.read_text("utf-8"))
    assert re.findall(r"\d+(?:\.\d+)? ?%|\d\.\d+", typed) == []
    assert len(re.findall(r'<p class="equation">', typed)) == 5


def test_every_job_is_quoted_and_each_that_misses_has_a_miss_quoted() -> None:
    every = standing.figures()
    chosen = [one for one in every if one.what in CHOSEN]
    assert {one.job for one in chosen} == {one.job for one in every}
    assert {one.job for one in chosen if one.missed} == {one.job for one in every if one.missed}


def test_a_figure_that_is_gone_is_named() -> None:
    with pytest.raises(NoSuchFigure, match="no figure 'Phases of the moon'"):
        summary.results(("Phases of the moon",))

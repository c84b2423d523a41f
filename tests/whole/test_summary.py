"""The summary quotes what the page of all figures has, and nothing else has a number in it."""

import re
import shutil
from pathlib import Path

import pytest

from docs.make import standing, summary
from docs.make.summary import CHOSEN, NoSuchFigure

CHROMIUM = shutil.which("chromium")
SHEET_PX = 680
"""What a sheet of A4 leaves between margins of 15 mm, at 96 pixels an inch."""

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


@pytest.mark.pages
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on the path")
def test_the_summary_is_two_sheets_and_nothing_is_cut_off(site: Path) -> None:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": SHEET_PX, "height": 1000})
        page.goto((site / "summary.html").as_uri())
        printed = page.pdf(prefer_css_page_size=True)
        page.emulate_media(media="print")
        cut_off = page.evaluate(
            "[...document.querySelectorAll('table')].map(one => one.scrollWidth - innerWidth)"
        )
        browser.close()
    assert len(re.findall(rb"/Type\s*/Page\b", printed)) == 2
    assert len(cut_off) == 1
    assert max(cut_off) <= 0

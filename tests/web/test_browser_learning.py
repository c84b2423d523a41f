"""Learning now in a browser: begun by keyboard, followed, read on a telephone, without scripts."""

import sys
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, expect

from autodb.agent.ingest.importing import import_file
from autodb.web.receive import children
from tests.helpers.browsing import CHROMIUM, MACHINE, Site, Watched, sign_in

pytestmark = [
    pytest.mark.pages,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on the path"),
]
LONG_MS = 60_000
SAYS_AND_WAITS = (
    "import sys, time; sys.stdin.readline();"
    'print(\'{"progress": "updating steel bar / carbide insert: 2 of 5"}\', flush=True);'
    "time.sleep(2)"
)


def test_it_is_begun_by_keyboard_and_followed_to_what_was_learnt(
    browser: Browser, page: Page, site: Site, watched: Watched, sample_jobs: Path
) -> None:
    week = sample_jobs / "stepped_shaft/recordings/shop-week-2.csv"
    import_file(site.store, week, machine="lathe-1")
    sign_in(page, site)
    page.goto(MACHINE)
    button = page.get_by_role("button", name="Learn now")
    expect(page.get_by_text("A refresh is not taken back as a whole")).to_be_visible()
    page.get_by_label("calibrate the currents first").check()
    button.focus()
    page.keyboard.press("Enter")
    expect(page.get_by_text("lathe-1 is learning").first).to_be_visible(timeout=LONG_MS)
    expect(page.locator("#learn .said.good")).to_contain_text("Learnt in", timeout=LONG_MS)
    expect(page.get_by_text("The same cuts gave the same calibrations.")).to_be_visible()
    expect(page.locator("#learn tbody tr").first).to_contain_text("steel bar / carbide insert")
    page.reload()
    expect(page.locator("#learn .said.good")).to_contain_text("Learnt in")

    context = browser.new_context(
        base_url=site.at, locale="de-DE", viewport={"width": 390, "height": 800},
        color_scheme="dark",
    )  # fmt: skip
    watched.watch(context)
    phone = context.new_page()
    phone.goto(MACHINE)
    expect(phone.locator("#learn .said.good")).to_contain_text("Gelernt in")
    assert phone.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
    found = Axe().run(phone).response["violations"]
    assert [one["id"] for one in found if one["impact"] in ("serious", "critical")] == []
    context.close()


def test_without_scripts_it_begins_and_a_reload_shows_how_far_it_is(
    browser: Browser, site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(children, "COMMAND", (sys.executable, "-c", SAYS_AND_WAITS))
    context = browser.new_context(base_url=site.at, java_script_enabled=False)
    page = context.new_page()
    sign_in(page, site)
    page.goto(MACHINE)
    page.get_by_role("button", name="Learn now").click()
    expect(page.get_by_text("lathe-1 is learning").first).to_be_visible()
    page.reload()
    expect(page.get_by_text("lathe-1 is learning, pair 2 of 5")).to_be_visible()
    page.wait_for_timeout(2500)
    page.reload()
    expect(page.locator("#learn .said.bad")).to_contain_text("learning broke off")
    expect(page.get_by_role("button", name="Learn now")).to_be_visible()
    context.close()

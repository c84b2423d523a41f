"""An edge change in a browser: recorded and taken back, on a telephone, without scripts."""

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, expect

from tests.helpers.browsing import CHROMIUM, MACHINE, Site, Watched, sign_in

pytestmark = [
    pytest.mark.pages,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on the path"),
]
TARGET_PX = 44


def test_an_edge_change_is_recorded_and_taken_back_on_a_telephone(
    browser: Browser, site: Site, watched: Watched
) -> None:
    context = browser.new_context(
        base_url=site.at, locale="de-DE", viewport={"width": 390, "height": 800}
    )
    watched.watch(context)
    page = context.new_page()
    sign_in(page, site)
    page.goto(MACHINE)
    edges = page.locator("#edges")
    expect(edges).to_contain_text("nicht festgehalten")
    edges.get_by_role("textbox", name="Wer").fill("Maria")
    edges.get_by_label("Grund").fill("ausgebrochen")
    edges.get_by_role("button", name="Schneide gewechselt").click()
    expect(edges.locator("tbody")).to_contain_text("Maria (ausgebrochen)")
    assert page.url.endswith("#edges")
    assert page.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
    for button in edges.get_by_role("button").all():
        box = button.bounding_box()
        assert box is not None
        assert box["height"] >= TARGET_PX - 0.5
    found = Axe().run(page).response["violations"]
    assert [one["id"] for one in found if one["impact"] in ("serious", "critical")] == []
    edges.get_by_role("button", name="Zurücknehmen").click()
    expect(edges).to_contain_text("nicht festgehalten")
    context.close()
    assert watched.wrong == []


def test_without_scripts_too(browser: Browser, site: Site) -> None:
    context = browser.new_context(base_url=site.at, java_script_enabled=False)
    page = context.new_page()
    sign_in(page, site)
    page.goto(MACHINE)
    edges = page.locator("#edges")
    edges.get_by_label("When, if not now").fill("2026-01-01T07:30")
    edges.get_by_role("button", name="Edge changed").click()
    expect(edges.locator("tbody")).to_contain_text("2026-01-01")
    edges.get_by_role("button", name="Undo").click()
    expect(edges).to_contain_text("not recorded")
    context.close()

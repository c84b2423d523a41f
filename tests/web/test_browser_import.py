"""The import page in a browser: a foreign log is looked at, chosen of, and imported."""

import time
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, expect

from autodb.store import Store, models
from tests.helpers.browsing import CHROMIUM, MACHINE, Site, Watched, sign_in

pytestmark = [
    pytest.mark.pages,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on the path"),
]
LONG_MS = 60_000
ROWS = (
    "Nr;Bearbeitung;Werkstoff;Werkzeug;Vorschub;Schnitttiefe;Durchmesser;Drehzahl;Strom Z;Wert 7\n"
    "1;Längsdrehen;steel bar;carbide insert;0,28;1,75;69;940;2891,3;12\n"
    "2;Längsdrehen;steel bar;carbide insert;0,24;1,25;71;1050;2577,7;14\n"
    "3;Längsdrehen;steel bar;carbide insert;0,13;1,00;49;1570;1884,1;19\n"
)


@pytest.fixture
def foreign(tmp_path: Path) -> Path:
    """Return a table of cuts as a German shop writes it, of no file that is there."""
    path = tmp_path / "Woche.csv"
    path.write_text(ROWS.replace("steel bar", f"steel {time.time_ns()}"), encoding="cp1252")
    return path


def _drop(page: Page, site: Site, *files: Path) -> None:
    sign_in(page, site)
    page.goto(f"{MACHINE}/import")
    page.get_by_label("Drop files here").set_input_files(files)


def _recordings(store: Store) -> list[str]:
    with store.reading() as session:
        return [row.path for row in session.query(models.StoredRecording)]


def test_a_foreign_log_is_looked_at_chosen_of_and_imported(
    page: Page, site: Site, foreign: Path, watched: Watched
) -> None:
    watched.expected = ("422",)
    before = _recordings(site.store)
    _drop(page, site, foreign)
    expect(page.get_by_text("It can be imported like this.")).to_be_visible(timeout=LONG_MS)
    expect(page.get_by_label("Strom Z: unit")).to_have_value("mA")
    page.get_by_label("Wert 7: channel").fill("z.curent")
    importing = page.get_by_role("button", name="Import", exact=True)
    expect(importing).to_be_disabled()
    expect(page.get_by_text("It can be imported like this.")).to_be_hidden()
    page.get_by_role("button", name="Check my choices").click()
    expect(page.get_by_text("did you mean z.current")).to_be_visible(timeout=LONG_MS)
    page.get_by_label("Wert 7: channel").fill("z.temperature")
    page.get_by_label("Strom Z: sign reversed").check()
    assert _recordings(site.store) == before
    page.get_by_role("button", name="Check my choices").click()
    expect(page.get_by_text("12 to 19 °C")).to_be_visible(timeout=LONG_MS)
    importing.click()
    expect(page.get_by_text("3 new cuts")).to_be_visible(timeout=LONG_MS)
    (made,) = {*_recordings(site.store)} - {*before}
    side = Path(made).with_suffix(".toml").read_text(encoding="utf-8")
    assert '"z.temperature" = "Wert 7"' in side
    assert '{column = "Strom Z", unit = "mA", sign = -1}' in side


def test_it_is_done_by_keyboard_alone_and_left_out(page: Page, site: Site, foreign: Path) -> None:
    before = _recordings(site.store)
    _drop(page, site, foreign)
    expect(page.get_by_text("It can be imported like this.")).to_be_visible(timeout=LONG_MS)
    for key, name in (("Wert 7: channel", "z.temperature"), ("Check my choices", "")):
        for _ in range(80):
            page.keyboard.press("Tab")
            said = "document.activeElement.ariaLabel ?? document.activeElement.textContent"
            if page.evaluate(said) == key:
                break
        if name:
            page.keyboard.type(name)
    page.keyboard.press("Enter")
    expect(page.get_by_text("12 to 19 °C")).to_be_visible(timeout=LONG_MS)
    assert page.evaluate("document.activeElement.tagName") == "H3"
    page.get_by_role("button", name="Leave it out").click()
    expect(page.get_by_text("left out; nothing of it was kept")).to_be_visible()
    assert _recordings(site.store) == before


def test_what_an_import_refuses_can_be_looked_at(
    page: Page, site: Site, foreign: Path, tmp_path: Path
) -> None:
    side = tmp_path / "Woche.toml"
    side.write_text('[channels]\n"cut" = "Nr"\n"z.current" = "Strom"\n')
    _drop(page, site, foreign, side)
    expect(page.locator("[data-imports] .said.bad")).to_contain_text("Strom", timeout=LONG_MS)
    page.get_by_role("button", name="Look at its columns").click()
    expect(page.get_by_text("One thing keeps it out:")).to_be_visible(timeout=LONG_MS)
    expect(page.get_by_role("button", name="Import", exact=True)).to_be_disabled()


def test_on_a_telephone_in_german_anyone_can_use_it(
    browser: Browser, site: Site, watched: Watched, foreign: Path
) -> None:
    context = browser.new_context(
        base_url=site.at, locale="de-DE", viewport={"width": 390, "height": 800},
        color_scheme="dark",
    )  # fmt: skip
    watched.watch(context)
    page = context.new_page()
    page.goto("/sign-in")
    page.locator("input[name=token]").fill(site.token)
    page.locator("main button").click()
    page.goto(f"{MACHINE}/import")
    page.locator("input[type=file]").set_input_files(foreign)
    expect(page.get_by_text("So kann sie importiert werden.")).to_be_visible(timeout=LONG_MS)
    page.get_by_text("Wie die Datei geschrieben ist").click()
    page.get_by_text("Begleitdatei", exact=True).click()
    found = Axe().run(page).response["violations"]
    serious = [one["id"] for one in found if one["impact"] in ("serious", "critical")]
    assert serious == [], [one["nodes"][0]["html"] for one in found]
    assert page.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
    low = page.evaluate(
        """() => [...document.querySelectorAll(".looked :is(button, select, summary, textarea),"
          + " .looked input:not([type=checkbox])")].filter(one => one.checkVisibility()
          && one.getBoundingClientRect().height < 43.5).map(one => one.outerHTML)"""
    )
    assert low == []
    context.close()
    assert watched.wrong == []

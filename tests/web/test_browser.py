"""The pages in a browser: each one's main job, by hand and by keyboard, and what anyone can use.

Every page is watched: an error on its console, or a request to anywhere but the service, fails.
"""

from pathlib import Path
from typing import Literal

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, expect

from tests.helpers.browsing import CHROMIUM, MACHINE, Site, Watched, sign_in
from tests.helpers.campaigns import first

pytestmark = [
    pytest.mark.pages,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on the path"),
]
TARGET_PX = 44
NOT_SERIOUS = ("minor", "moderate")


def _shown(page: Page, path: str) -> None:
    """Go to a page and wait until its plots are drawn."""
    page.goto(path)
    if page.locator(".plotly-graph-div").count():
        page.wait_for_selector("body.drawn")


# Each page's main job


def test_from_machines_to_what_a_machine_senses(page: Page) -> None:
    page.goto("/")
    page.get_by_label("Part of a name").fill("LATHE")
    page.get_by_role("button", name="Find").click()
    expect(page.locator(".machines li")).to_have_count(1)
    page.get_by_role("link", name="lathe-1").click()
    expect(page.get_by_role("heading", name="Force sensors")).to_be_visible()
    expect(page.locator(".js-plotly-plot .main-svg").first).to_be_visible()
    assert page.locator(".js-plotly-plot").count() == 3
    page.get_by_role("link", name="z.current").click()
    expect(page.get_by_role("heading", name="Effort over place and velocity")).to_be_visible()
    expect(page.locator(".js-plotly-plot .heatmaplayer image").first).to_be_attached()


def test_a_pair_is_shown_over_feed_and_depth(page: Page, site: Site) -> None:
    page.goto(f"{MACHINE}/pairs")
    page.get_by_role("link", name=site.pair["material"]).click()
    expect(page.get_by_role("heading", name="Over feed and depth")).to_be_visible()
    expect(page.locator("#map-1 .contour path").first).to_be_attached()
    page.get_by_text("Another cut").click()
    page.get_by_role("textbox", name="Depth").fill("1,5")
    page.get_by_role("button", name="Show it").click()
    expect(page.get_by_text("depth 1.5 mm")).to_be_visible()


def test_a_recording_is_found_and_drawn_with_its_cut(page: Page) -> None:
    page.goto(f"{MACHINE}/recordings")
    page.get_by_role("button", name="Length").click()
    expect(page.get_by_role("columnheader", name="Length")).to_have_attribute(
        "aria-sort", "ascending"
    )
    assert page.locator("tbody tr").first.inner_text().split("\t")[1] == "standard-cut-raw.parquet"
    with page.expect_download() as saved:
        page.get_by_role("button", name="Download as CSV").click()
    text = saved.value.path().read_text("utf-8-sig").splitlines()
    assert text[0].startswith("No.,File,Recorded (UTC),Length,Rate [Hz]")
    assert len(text) == 6
    page.get_by_role("link", name="2", exact=True).click()
    expect(page.get_by_text("the cut, 2.")).to_be_visible(timeout=60_000)
    expect(page.locator(".js-plotly-plot .main-svg").first).to_be_visible()


def test_health_leads_to_its_evidence(page: Page, site: Site) -> None:
    page.goto(f"{MACHINE}/health")
    expect(page.get_by_role("link", name=f"Decide on mismatch {site.mismatch}")).to_be_visible()
    expect(page.locator("#course-z .main-svg").first).to_be_visible(timeout=60_000)
    page.locator("section section", has_text="Z axis").get_by_text("What it rests on").click()
    page.get_by_role("link", name="recording 4").first.click()
    expect(page.get_by_role("heading", name="shop-week-1.csv")).to_be_visible()


def test_a_job_is_planned_by_hand(page: Page) -> None:
    page.goto(f"{MACHINE}/plan")
    page.get_by_role("button", name="Add a cut").click()
    second = page.locator("[data-cuts] fieldset").nth(1)
    second.get_by_label("Name").fill("finish")
    second.get_by_label("Depth [mm]").fill("0.5")
    expect(second.get_by_label("Width")).to_be_hidden()
    second.get_by_label("Operation").select_option("slot")
    expect(second.get_by_label("Diameter [mm]", exact=True)).to_be_hidden()
    second.get_by_label("Operation").select_option("turn")
    second.get_by_label("Diameter [mm]", exact=True).fill("40")
    second.get_by_label("Feed [mm/rev]").fill("0.12")
    page.get_by_role("button", name="Predict", exact=True).click()
    expect(page.get_by_role("row", name="finish")).to_be_visible()
    expect(page.locator("#predicted .main-svg").first).to_be_visible()
    page.locator("[data-cuts] fieldset").nth(1).get_by_role("button", name="Take out").click()
    page.get_by_label("Depth [mm]").fill("3")
    page.get_by_label("Feed [mm/rev]").fill("0.35")
    page.get_by_role("button", name="what to cut next").click()
    expect(page.get_by_role("alert").first).to_contain_text("exceed")
    expect(page.get_by_role("heading", name="What to cut next")).to_be_visible()


def test_a_job_is_planned_by_keyboard_alone(page: Page) -> None:
    page.goto(f"{MACHINE}/plan")
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.textContent") == "Skip to content"
    page.keyboard.press("Enter")
    for _ in range(40):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.name") == "depth_mm":
            break
    page.keyboard.press("Control+A")
    page.keyboard.type("1.25")
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name="What it will take")).to_be_visible()
    assert "depth_mm=1.25" in page.url


def test_a_job_is_planned_in_german_and_in_inches(page: Page, site: Site) -> None:
    page.goto(site.pages["plan"])
    page.get_by_role("button", name="Deutsch").click()
    page.get_by_role("button", name="Einheiten: inch, lbf").click()
    expect(page.locator("html")).to_have_attribute("lang", "de")
    expect(page.get_by_label("Schnitttiefe [in]")).to_have_value("0,0984252")
    page.get_by_role("button", name="Schnitt hinzufügen").click()
    expect(page.get_by_text("Schnitt 2", exact=True)).to_be_visible()
    page.get_by_label("Schnitttiefe [in]").nth(1).fill("0,125")
    page.get_by_role("button", name="Vorhersagen", exact=True).click()
    expect(page.get_by_text("Schnitttiefe 0,125 in").first).to_be_attached()
    page.goto(site.pages["recordings"])
    with page.expect_download() as saved:
        page.get_by_role("button", name="Als CSV speichern").click()
    assert "Nr.;Datei;Aufgenommen (UTC);Länge" in saved.value.path().read_text("utf-8-sig")


def test_a_mismatch_is_decided_on(page: Page, site: Site) -> None:
    page.goto(f"{MACHINE}/mismatches")
    number = site.mismatch
    page.get_by_role("link", name=str(number), exact=True).click()
    page.get_by_role("link", name="Signed in").click()
    page.get_by_label("Token").fill(site.token)
    page.get_by_role("button", name="Sign in").click()
    page.get_by_role("button", name="Reject").click()
    expect(page.get_by_text("Rejected by operator")).to_be_visible()
    page.get_by_role("button", name="Sign out").click()
    expect(page.get_by_text("not signed in")).to_be_visible()


def test_a_mismatch_shows_its_recording(page: Page, site: Site) -> None:
    page.goto(f"/mismatches/{site.mismatch}")
    page.get_by_role("button", name="Show it").click()
    expect(page.get_by_role("heading", name="where it shows").first).to_be_visible(timeout=60_000)
    expect(page.locator("[data-piece] .js-plotly-plot .main-svg").first).to_be_visible()
    expect(page.locator("[data-piece] [role=status]")).to_have_text("")


def test_a_job_is_planned_by_dropping_its_program(page: Page, sample_jobs: Path) -> None:
    page.goto(f"{MACHINE}/plan")
    page.get_by_text("Or drop an NC program").click()
    page.get_by_label("Bar diameter").fill("60,0")
    page.get_by_label("Face of the bar").fill("2")
    page.get_by_label("Drop the program here").set_input_files(sample_jobs / "nc_profile/part.nc")
    page.get_by_role("button", name="Predict the program").click()
    expect(page.get_by_role("row", name="line 14")).to_be_visible(timeout=60_000)
    expect(page.locator("#predicted .main-svg").first).to_be_visible()


def test_a_program_that_cannot_be_read_is_said(
    page: Page, watched: Watched, tmp_path: Path
) -> None:
    watched.expected = ("422",)
    path = tmp_path / "part.nc"
    path.write_text("G1 X what\n")
    page.goto(f"{MACHINE}/plan")
    page.get_by_text("Or drop an NC program").click()
    page.get_by_label("Bar diameter").fill("60")
    page.get_by_label("Drop the program here").set_input_files(path)
    page.get_by_role("button", name="Predict the program").click()
    expect(page.locator("[data-program] [role=status]")).to_contain_text("part.nc", timeout=60_000)


MILLED = """G21 G90 G17 (T9 in words)
T3 M6
S1000 M3
G0 X-10 Y10 Z5
G1 Z-2 F200
X60
M30
"""


def test_a_mill_s_program_is_planned_with_its_block_and_tools(page: Page, tmp_path: Path) -> None:
    """Its tools are named from it; two of one name are refused before anything is sent."""
    path = tmp_path / "plate.nc"
    path.write_text(MILLED)
    page.goto(f"{MACHINE}/plan")
    page.get_by_text("Or drop an NC program").click()
    page.get_by_label("It is").select_option("block")
    page.get_by_label("Drop the program here").set_input_files(path)
    called = page.get_by_label("Number or name in the program")
    expect(called).to_have_value("3")
    for field, text in zip(
        page.locator("[name=block_mm]").all(), ("0", "50", "0", "50", "-10,5", "0"), strict=True
    ):
        field.fill(text)
    page.locator("[data-tools]").get_by_label("Diameter").fill("10")
    page.get_by_label("Teeth").fill("4")
    page.get_by_role("button", name="Add a tool").click()
    called.nth(1).fill("3")
    page.get_by_role("button", name="Predict the program").click()
    expect(page.locator("[data-program] [role=status]")).to_contain_text("tool 3: stated twice")
    page.get_by_role("button", name="Take out").nth(1).click()
    page.get_by_role("button", name="Predict the program").click()
    expect(page.get_by_role("row", name="line 6")).to_be_visible(timeout=60_000)
    asked = page.locator("#of-program .on-paper").inner_text()
    assert "a block: x 0 mm to 50 mm, y 0 mm to 50 mm, z -10.5 mm to 0 mm" in asked
    assert "tool 3: end mill, diameter 10 mm, 4 teeth" in asked


def test_a_job_file_beside_a_program_states_it(page: Page, sample_jobs: Path) -> None:
    page.goto(f"{MACHINE}/plan")
    page.get_by_text("Or drop an NC program").click()
    folder = sample_jobs / "nc_profile"
    page.get_by_label("Drop the program here").set_input_files(
        [folder / "job.toml", folder / "part.nc"]
    )
    expect(page.get_by_label("Bar diameter")).to_be_disabled()
    page.get_by_label("Drop the program here").set_input_files(folder / "job.toml")
    page.get_by_role("button", name="Predict the program").click()
    expect(page.locator("[data-program] [role=status]")).to_contain_text("drop one program")
    page.get_by_label("Drop the program here").set_input_files(
        [folder / "part.nc", folder / "job.toml"]
    )
    page.get_by_role("button", name="Predict the program").click()
    expect(page.get_by_role("row", name="line 14")).to_be_visible(timeout=60_000)


def test_lobes_are_drawn_of_typed_modes_and_of_a_file(page: Page, tmp_path: Path) -> None:
    page.goto(f"{MACHINE}/plan")
    page.get_by_label("Depth [mm]").fill("1.75")
    page.get_by_role("button", name="To what depth it is stable").click()
    expect(page.get_by_role("heading", name="Stability")).to_be_visible()
    expect(page.get_by_label("Depth [mm]")).to_have_value("1.75")
    page.get_by_role("button", name="Add a mode").click()
    second = page.locator("[data-modes] fieldset").nth(1)
    expect(second.get_by_text("Mode 2 of the tool point")).to_be_visible()
    second.get_by_role("button", name="Take out").click()
    for called, text in (("Frequency", "603"), ("Damping", "0,039"), ("Stiffness", "5590")):
        page.get_by_label(called).fill(text)
    page.keyboard.press("Enter")
    expect(page.get_by_text("1.75 mm at")).to_be_visible(timeout=60_000)
    expect(page.locator("#lobes-1 .main-svg").first).to_be_visible()
    path = tmp_path / "tip.toml"
    path.write_text(
        '[[mode]]\naxis = "x"\nfrequency_Hz = 603\ndamping_ratio = 0.04\nstiffness_N_m = 6e6\n'
    )
    page.get_by_text("Or drop a file").click()
    page.get_by_label("Drop the file here").set_input_files(path)
    page.get_by_role("button", name="Draw the lobes of the file").click()
    expect(page.locator("#of-file #lobes-1 .main-svg").first).to_be_visible(timeout=60_000)
    expect(page.locator("#answer")).to_have_count(0)


def test_recordings_are_imported_by_dropping_them(
    page: Page, site: Site, sample_jobs: Path, tmp_path: Path
) -> None:
    recordings = sample_jobs / "stepped_shaft/recordings"
    other = tmp_path / "picture.csv"
    other.write_bytes(b"\x89PNG")
    files = [recordings / "shop-week-2.csv", recordings / "shop-week-1.csv", other]
    sign_in(page, site)
    page.goto(f"{MACHINE}/import")
    page.get_by_label("Drop files here").set_input_files(files)
    said = page.locator("[data-imports] .said")
    expect(said).to_have_count(3, timeout=100_000)
    texts = said.all_inner_texts()
    assert "36 new cuts" in texts[2]
    assert "already there as recording" in texts[1]
    assert "no table in it" in texts[0]
    assert page.locator("[data-imports] .said.good").count() == 2


def test_a_token_that_is_not_valid_is_said(page: Page, watched: Watched) -> None:
    watched.expected = ("401",)
    page.goto("/sign-in")
    page.get_by_label("Token").fill("guess")
    page.get_by_role("button", name="Sign in").click()
    expect(page.get_by_role("alert")).to_have_text("the token is not valid")


# For anyone, on anything


@pytest.mark.parametrize("scheme", first(1, ["dark", "light"]))
def test_anyone_can_use_every_page(
    browser: Browser, site: Site, watched: Watched, scheme: str
) -> None:
    watched.expected = ("404",)
    chosen: Literal["dark", "light"] = "dark" if scheme == "dark" else "light"
    context = browser.new_context(base_url=site.at, color_scheme=chosen)
    watched.watch(context)
    page = context.new_page()
    sign_in(page, site)
    for name, path in site.pages.items():
        _shown(page, path)
        found = Axe().run(page).response["violations"]
        serious = [one["id"] for one in found if one["impact"] not in NOT_SERIOUS]
        assert serious == [], (name, [one["nodes"][0]["html"] for one in found])
    context.close()
    assert watched.wrong == []


@pytest.mark.parametrize(
    ("locale", "width_px"), first(1, [("de-DE", 390), ("en-US", 390), ("de-DE", 1280)])
)
def test_what_is_pressed_is_large_enough_and_nothing_runs_off_the_screen(
    browser: Browser, site: Site, locale: str, width_px: int
) -> None:
    """In German first: its words are longer."""
    context = browser.new_context(
        base_url=site.at, locale=locale, viewport={"width": width_px, "height": 800}
    )
    page = context.new_page()
    sign_in(page, site)
    for name, path in site.pages.items():
        _shown(page, path)
        page.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
        small = page.evaluate(
            """least => [...document.querySelectorAll(
              "button, input:not([type=hidden]), select, summary, nav a, td a, th a, .button, h2 a"
            )].filter(one => one.checkVisibility()
                && !one.closest(".skip, p") && one.getBoundingClientRect().height < least - 0.5
            ).map(one => one.outerHTML.slice(0, 90))""",
            TARGET_PX,
        )
        assert small == [], name
        wider = page.evaluate("document.documentElement.scrollWidth - innerWidth")
        assert wider <= 0, name
    context.close()


def test_pages_print_without_what_is_pressed(page: Page, site: Site, tmp_path: Path) -> None:
    _shown(page, site.pages["plan"])
    page.emulate_media(media="print")
    expect(page.get_by_role("button", name="Predict", exact=True)).to_be_hidden()
    expect(page.locator(".bar")).to_be_hidden()
    expect(page.get_by_role("heading", name="What it will take")).to_be_visible()
    expect(page.get_by_text("turn, diameter 56 mm, depth 2.5 mm")).to_be_visible()
    made = page.pdf(path=tmp_path / "plan.pdf", format="A4")
    assert made.startswith(b"%PDF")

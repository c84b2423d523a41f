"""`python -m benchmarks.walks`: from an empty folder to a prediction and an explanation, timed.

The notebook of the docs, ten commands, and the pages in a browser (where there is Chromium), each
once, of the sample job; by the wall, so of this computer as busy as it is.
"""

import os
import re
import runpy
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from urllib.parse import urlencode

from autodb.assets import kit
from benchmarks.serving import CHROMIUM, served

NOTEBOOK = Path("docs/notebook.py").absolute()
DATABASE = "sqlite:///autodb.sqlite3"
COMMANDS = (
    "init",
    "machine add lathe-1 --file machine.toml",
    "import standard-cuts.csv",
    "calibrate",
    "import shop-week-1.csv",
    "refresh",
    "predict job.toml",
    "import shop-week-2.csv",
    "refresh",
    "mismatch list",
)
LONG_MS = 120_000
PAIR = {"material": "steel bar", "tool": "carbide insert", "operation": "turn"}
CUT = {"diameter_mm": "56", "depth_mm": "2", "feed_mm_rev": "0.3", "speed_m_min": "220"}


def notebook() -> str:
    """Run the notebook of the docs."""
    cells = len(re.findall(r"^# %%", NOTEBOOK.read_text("utf-8"), re.MULTILINE))
    there = runpy.run_path(str(NOTEBOOK))
    (first, *_), explained = there["predicted"].answer.cuts, there["explained"].to_pandas()
    force = first.force_y_N
    return (
        f"{cells} cells; {force.value:.0f} N ({force.low:.0f} to {force.high:.0f}); "
        f"{explained['term'].iloc[0]}"
    )


def commands() -> str:
    """Run ten commands, each a process of its own."""
    said = ""
    for line in COMMANDS:
        start = time.perf_counter()
        said = _autodb(line)
        print(f"    autodb {line}: {time.perf_counter() - start:.1f} s", flush=True)
    return f"{len(COMMANDS)} commands; " + ("tool_wear" if "tool_wear" in said else said)


def in_browser() -> str:
    """Go the same way in the pages.

    Commands add the machine and a token.
    """
    from playwright.sync_api import expect, sync_playwright

    _autodb("init")
    _autodb("machine add lathe-1 --file machine.toml")
    token = _autodb("token add me --role operate").strip()
    with served(DATABASE, "--write") as (at, _), sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = browser.new_page(base_url=at)
        page.set_default_timeout(LONG_MS)
        expect.set_options(timeout=LONG_MS)
        page.goto("/sign-in")
        page.locator("input[name=token]").fill(token)
        page.locator("main button").click()
        for file in ("standard-cuts.csv", "shop-week-1.csv", "shop-week-2.csv"):
            page.goto("/machines/lathe-1/import")
            page.get_by_label("Drop files here").set_input_files(file)
            expect(page.get_by_text("new cuts").first).to_be_visible()
            page.goto("/machines/lathe-1")
            if file == "standard-cuts.csv":
                page.get_by_label("calibrate the currents first").check()
            page.get_by_role("button", name="Learn now").click()
            expect(page.get_by_text("lathe-1 is learning").first).to_be_visible()
            expect(page.locator("#learn .said.good")).to_contain_text("Learnt in")
        page.goto(f"/machines/lathe-1/plan?{urlencode(PAIR | CUT)}")
        expect(page.get_by_text("Cutting force").first).to_be_visible()
        page.goto("/machines/lathe-1/mismatches")
        found = page.locator("main table tbody tr td:nth-child(2)").all_inner_texts()
        browser.close()
    return "; ".join(" ".join(one.split()) for one in found)


def _autodb(line: str) -> str:
    """Run a command in a process of its own; return what it prints."""
    whole = [sys.executable, "-m", "autodb", *line.split()]
    return subprocess.run(whole, capture_output=True, text=True, check=True).stdout


def timed(what: str, walk: Callable[[], str]) -> None:
    """Walk from an empty folder that has the sample job's files; print how long it took."""
    job = kit("sample_jobs") / "stepped_shaft"
    before = Path.cwd()
    with tempfile.TemporaryDirectory(prefix="autodb-walk-") as folder:
        for file in (*job.glob("*.toml"), *(job / "recordings").glob("*.csv")):
            shutil.copy(file, folder)
        os.chdir(folder)
        start = time.perf_counter()
        found = walk()
        print(f"{what}: {time.perf_counter() - start:.0f} s; {found}", flush=True)
        os.chdir(before)


def main() -> None:
    """Walk all three."""
    os.environ.pop("AUTODB_DB", None)
    timed("notebook", notebook)
    timed("commands", commands)
    if CHROMIUM is not None:
        timed("browser", in_browser)


if __name__ == "__main__":
    main()

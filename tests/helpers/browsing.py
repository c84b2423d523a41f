"""A service that is browsed, and what watches its pages while tests use them.

Every page is watched: an error on its console, or a request to anywhere but the service, fails.
"""

import shutil
from dataclasses import dataclass, field
from urllib.parse import quote, urlencode

from playwright.sync_api import BrowserContext, Page, expect

from autodb.agent.operate.deciding import mismatches
from autodb.store import Store
from tests.helpers.site import STRANGE

CHROMIUM = shutil.which("chromium")
MACHINE = "/machines/lathe-1"
CUT = {"operation": "turn", "diameter_mm": "56", "depth_mm": "2.5", "feed_mm_rev": "0.3",
       "speed_m_min": "220"}  # fmt: skip

MODE = {"axis": "x", "frequency_Hz": "603", "damping_ratio": "0.039", "stiffness_N_m": "5590"}


@dataclass
class Site:
    """A service that may change something, the database behind it, and a token to operate it."""

    at: str
    store: Store
    token: str
    pair: dict[str, str]

    @property
    def mismatch(self) -> int:
        """A mismatch that waits."""
        with self.store.reading() as session:
            return mismatches(session, "lathe-1", decided=False)[0].id

    @property
    def pages(self) -> dict[str, str]:
        """Every page, by what it is."""
        return {
            "machines": "/",
            "sign in": "/sign-in",
            "machine": MACHINE,
            "machine of a strange name": f"/machines/{quote(STRANGE, safe='')}",
            "moved": f"{MACHINE}/moved",
            "drive": f"{MACHINE}/drives/z.current",
            "pairs": f"{MACHINE}/pairs",
            "pair": f"{MACHINE}/pair?{urlencode(self.pair | CUT)}",
            "plan": f"{MACHINE}/plan?{urlencode(self.pair | CUT | {'next': 'true'})}",
            "stability": f"{MACHINE}/stability?{urlencode(self.pair | CUT | MODE)}",
            "import": f"{MACHINE}/import",
            "mismatches": f"{MACHINE}/mismatches",
            "scores": f"{MACHINE}/scores",
            "recordings": f"{MACHINE}/recordings",
            "health": f"{MACHINE}/health",
            "a table of cuts": f"{MACHINE}/recordings/4",
            "mismatch": f"/mismatches/{self.mismatch}",
            "not there": "/machines/none",
        }


@dataclass
class Watched:
    """What the pages of a context did that they should not."""

    at: str
    wrong: list[str] = field(default_factory=list)
    expected: tuple[str, ...] = ()

    def watch(self, context: BrowserContext) -> None:
        """Listen to a context."""
        context.on("console", lambda said: self._said(said.type, said.text))
        context.on("weberror", lambda error: self.wrong.append(str(error.error)))
        context.on("request", lambda asked: self._asked(asked.url))

    def _said(self, kind: str, text: str) -> None:
        if kind in ("error", "warning") and not any(one in text for one in self.expected):
            self.wrong.append(text)

    def _asked(self, address: str) -> None:
        if not address.startswith((self.at, "data:", "blob:")):
            self.wrong.append(f"asked {address}")


def sign_in(page: Page, site: Site) -> None:
    """Sign in as who operates the machine."""
    page.goto("/sign-in")
    page.get_by_label("Token").fill(site.token)
    page.locator("main button").click()
    expect(page.get_by_text("operator (operate)")).to_be_visible()

"""Pages on the disk: small, drawn without a network, and moved with what they need."""

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from autodb.agent.matching.past_predictions import PastCut
from autodb.agent.matching.scoring import PredictionScores
from autodb.explain.answer import Explained, Explanation
from autodb.explain.several_recordings import RecordingSetup, explain_together
from autodb.forward.prediction import Interval
from autodb.forward.scored import Scored
from autodb.reports.explanation import explanation_fragment, render_explanation
from autodb.reports.explanation_files import write_answer, write_together
from autodb.reports.machine_page import machine_page
from autodb.reports.page import render_page
from autodb.reports.scored import render_scores
from autodb.reports.written import LIBRARY, write_page
from autodb.store import open_store
from tests.conftest import Cli
from tests.helpers.explanations import channel, explained, friction
from tests.helpers.screw_axis import screw_moves, write_moves

CHROMIUM = shutil.which("chromium")
MOST_BYTES = 500_000
JOB = (
    'name = "j"\nmaterial = "steel bar"\ntool = "carbide insert"\n[[cut]]\nname = "rough"\n'
    "diameter_mm = 50\ndepth_mm = 2\nfeed_mm_rev = 0.25\nspeed_m_min = 220\n"
)

SCORED = Scored("force.y", 1, 1, Interval(value=500.0, low=450.0, high=560.0), 510.0, 8.0)
PAST = PastCut(1, 1, "j", ("C45", "insert"), "rough", True, "job", 1, 1.0, (SCORED,))
NOTHING = {"machine": None, "tool": None, "material": None, "sensor": None, "calibration": None}


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Return a browser that has no network."""
    if CHROMIUM is None:
        pytest.skip("no Chromium on the path")
    with sync_playwright() as playwright:
        made = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield made
        made.close()


def _of_three_axes(recording: str) -> Explained:
    """An explanation of three long channels."""
    one = explained(channel(friction()), recording=recording)
    (answer,), (trace,) = one.explanation.channels.values(), one.traces.values()
    names = ("x.current", "y.current", "z.current")
    explanation = Explanation(recording=recording, channels=dict.fromkeys(names, answer))
    return Explained(explanation=explanation, traces=dict.fromkeys(names, trace), notes=())


def _pages(cli: Cli, cuts: Path) -> list[Path]:
    """Have every command write its page."""
    Path("job.toml").write_text(JOB, "utf-8")
    write_moves(Path("air.csv"), screw_moves(62, moves=4))
    for line in (
        ("predict", "job.toml", "--plot", "job.html"),
        ("identify", "air.csv", "--page", "axis.html"),
        ("reconstruct", "air.csv", "--moves", "air.csv", "--page", "load.html"),
        ("calibrate", cuts, "--card", "card.html"),
    ):
        done = cli(*line)
        assert done.code == 0, (line, done.err)
    store = open_store("sqlite:///autodb.sqlite3")
    fragment = explanation_fragment(explained(channel(friction())))
    write_page(Path("report.html"), render_page(machine_page(store, "lathe-1", 1), fragment))
    scores = PredictionScores("lathe-1", 0, (), (PAST,))
    write_page(Path("scores.html"), render_scores(scores))
    store.close()
    both = [explained(channel(), recording=name) for name in ("a.csv", "b.csv")]
    setups = [RecordingSetup(recording=one.explanation.recording, **NOTHING) for one in both]
    found = explain_together(setups, [one.explanation.channels for one in both])
    write_together(both, found, Path("both"))
    write_answer(_of_three_axes("a.csv"), Path("explained"))
    return sorted(Path().rglob("*.html"))


def _drawn(page: Page, path: Path) -> tuple[int, int]:
    """Open a page from the disk; return how many plots it has, and how many are drawn."""
    page.goto(path.resolve().as_uri())
    plots = page.locator(".plotly-graph-div")
    return plots.count(), page.locator(".js-plotly-plot .main-svg:first-child").count()


@pytest.mark.pages
def test_every_commands_page_is_small_and_shows_its_plots_without_a_network(
    standard_learnt: Cli, sample_jobs: Path, browser: Browser
) -> None:
    cuts = sample_jobs / "stepped_shaft/recordings/standard-cuts.csv"
    pages = _pages(standard_learnt, cuts)
    assert len(pages) == 10
    scripts = sorted(str(one) for one in Path().rglob("*.js"))
    assert scripts == sorted([LIBRARY, f"both/{LIBRARY}", f"explained/{LIBRARY}"])
    context = browser.new_context(offline=True)
    page, wrong = context.new_page(), []
    page.on("console", lambda said: wrong.append(said.text) if said.type == "error" else None)
    page.on("pageerror", lambda error: wrong.append(f"{page.url}: {error}"))
    for path in pages:
        assert path.stat().st_size < MOST_BYTES
        there, drawn = _drawn(page, path)
        assert there == drawn, path
        assert (there > 0) == (path.name != "together.html"), path
    context.close()
    assert wrong == []


@pytest.mark.pages
def test_a_page_without_its_script_says_what_it_lacks(browser: Browser, tmp_path: Path) -> None:
    html = render_explanation(explained(channel(friction())))
    write_page(tmp_path / "alone.html", html, self_contained=True)
    (tmp_path / "moved.html").write_text(html, "utf-8")
    assert [one.name for one in tmp_path.glob("*.js")] == []
    page = browser.new_page()
    there, drawn = _drawn(page, tmp_path / "alone.html")
    assert there == drawn > 0
    assert _drawn(page, tmp_path / "moved.html") == (there, 0)
    assert f"Put {LIBRARY} beside this page" in page.locator(".plot").first.inner_text()
    page.close()


def test_a_script_that_is_not_whole_is_written_again(tmp_path: Path) -> None:
    html = render_explanation(explained(channel(friction())))
    write_page(tmp_path / "a.html", html)
    whole = (tmp_path / LIBRARY).read_bytes()
    (tmp_path / LIBRARY).write_bytes(whole[:1000])
    write_page(tmp_path / "b.html", html)
    assert (tmp_path / LIBRARY).read_bytes() == whole


def test_an_answer_takes_the_place_of_one_with_another_version_of_the_script(
    tmp_path: Path,
) -> None:
    one = explained(channel(friction()))
    write_answer(one, tmp_path / "out")
    (tmp_path / "out" / LIBRARY).rename(tmp_path / "out" / "plotly-1.0.0.min.js")
    write_answer(one, tmp_path / "out", self_contained=True)
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"corrected.csv", "explanation.json", "report.html"}


@pytest.mark.parametrize(
    ("line", "option"),
    [
        (("predict", "job.toml"), "--plot"),
        (("predictions", "score"), "--plot"),
        (("identify", "air.csv"), "--page"),
        (("reconstruct", "air.csv", "--moves", "air.csv"), "--page"),
        (("calibrate", "cuts.csv"), "--card"),
    ],
)
def test_no_page_is_self_contained_that_is_not_asked_for(
    refused: Callable[..., str], line: tuple[str, ...], option: str
) -> None:
    Path("job.toml").write_text(JOB, "utf-8")
    assert f"--self-contained goes with {option} FILE.html" in refused(*line, "--self-contained")

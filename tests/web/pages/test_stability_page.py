"""The page of stability: modes that are typed, a file that is dropped, and what is refused."""

import re
from html import unescape
from urllib.parse import urlencode

import pytest
from fastapi.testclient import TestClient

from autodb.agent.answer.bounds.stable import stable_cuts
from autodb.agent.answer.looking_up import PairReader
from autodb.files.job import Job
from autodb.files.job_cut import JobCut
from autodb.forward.stability.dynamics import ModeSection, of_modes
from autodb.store import Store

PAGE = "/machines/lathe-1/stability"
CUT = {"operation": "turn", "diameter_mm": "56", "depth_mm": "2.5", "feed_mm_rev": "0.3",
       "speed_m_min": "220"}  # fmt: skip
MODE = {"axis": "x", "frequency_Hz": "603", "damping_ratio": "0.039", "stiffness_N_m": "5590",
        "share": "20"}  # fmt: skip
FILE = b'[[mode]]\naxis = "x"\nfrequency_Hz = 603.0\ndamping_ratio = 0.039\nstiffness_N_m = 5.59e6\nshare = 0.2\n'  # noqa: E501


def _text(html: str) -> str:
    shown = re.sub(r"<(script|style|title).*?</\1>", " ", html, flags=re.DOTALL)
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", shown)).replace("\u00a0", " ").split())


@pytest.fixture
def depth_mm(store: Store, pair: dict[str, str]) -> str:
    """Return what the library says of the cut, as a page writes it."""
    stated = MODE | {"stiffness_N_m": "5.59e6", "share": "0.2"}
    point = of_modes((ModeSection.model_validate(stated | {"axis": "x"}, strict=False),), source="")
    job = Job(
        name="j",
        material=pair["material"],
        tool=pair["tool"],
        cut=(JobCut.model_validate(CUT, strict=False),),
    )
    with store.reading() as session:
        basis = PairReader(session, "lathe-1").basis(job.material, job.tool)
        found = stable_cuts(basis, job, point)[0].stable.depth_mm
    assert found is not None
    return f"{found.value:.3g} mm ({found.low:.3g} to {found.high:.3g})"


def test_lobes_of_typed_modes_and_of_a_file_are_those_of_the_library(
    client: TestClient, pair: dict[str, str], depth_mm: str
) -> None:
    """The question is printed with the answer; German and inches are the reader's alone."""
    page = client.get(f"{PAGE}?{urlencode(pair | CUT | MODE)}").text
    text = _text(page)
    assert f"Stable up to {depth_mm}" in text
    assert "x gives way at 603 Hz, damping ratio 0.039, stiffness 5590 N/mm" in text
    assert "largest depth within 100 % of each limit" in text.lower()
    assert "stability lobes of cut 1" in page
    piece = client.post(
        f"{PAGE}?{urlencode(pair | CUT)}", files={"dynamics": ("tip.toml", FILE)}
    ).text
    assert f"Stable up to {depth_mm}" in _text(piece)
    assert "tool point of tip.toml" in piece
    typed = {"depth_mm": "0,0984252", "diameter_mm": "2,2047244", "feed_mm_rev": "0,011811024",
             "speed_m_min": "721,78478", "stiffness_N_m": "31919,7", "damping_ratio": "0,039",
             "typed": "de.inch"}  # fmt: skip
    inches = client.get(
        f"{PAGE}?{urlencode(pair | CUT | MODE | typed)}", headers={"Accept-Language": "de"}
    ).text
    low = depth_mm.split(" ", maxsplit=1)[0].replace(".", ",")
    assert f"Stabil bis {low} mm" in _text(inches)
    assert re.search(r'name="stiffness_N_m"[^>]*value="5590"', inches)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"frequency_Hz": "fast"}, "mode 1: frequency_Hz: 'fast' is not a number"),
        ({"damping_ratio": "3.9"}, "mode 1: damping_ratio: must be less than 1"),
        ({"stiffness_N_m": ""}, "mode 1: stiffness_N_m"),
        ({"depth_mm": "deep"}, "cut 1: depth_mm"),
        ({"material": ""}, "state material, tool and a cut"),
    ],
)
def test_what_cannot_be_is_said_and_what_was_typed_stays(
    client: TestClient, pair: dict[str, str], change: dict[str, str], said: str
) -> None:
    page = client.get(f"{PAGE}?{urlencode(pair | CUT | MODE | change)}").text
    alert = re.search(r'role="alert">(.*?)</p>', page)
    assert alert is not None
    assert said in unescape(alert[1])
    assert f'value="{change.get("frequency_Hz", "603")}"' in page
    assert "stability lobes" not in page


def test_more_modes_than_a_form_has_are_refused(client: TestClient, pair: dict[str, str]) -> None:
    many = urlencode([*(pair | CUT).items(), *[("axis", "x")] * 21])
    assert "21 modes are too many" in client.get(f"{PAGE}?{many}").text

"""The pages of a shop that works in inches: what is printed, typed, drawn and sent on."""

import json
import re
from base64 import b64decode
from html import unescape
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import numpy as np
import pytest
from fastapi.testclient import TestClient
from numpy.typing import NDArray

from autodb.agent.answer.looking_up import PairReader
from autodb.agent.answer.pooled import pooling
from autodb.agent.operate.deciding import mismatches
from autodb.errors import UnusableInput
from autodb.files.units import presentation_of
from autodb.store import Store
from autodb.web.pages.typed import typed_as
from autodb.web.receive.apart import MismatchToExplain
from autodb.web.routes.asked import as_cut
from autodb.wording import presented
from tests.helpers.asked import client_of
from tests.helpers.explanations import channel, explained, friction

MACHINE = "/machines/lathe-1"
CUT = {"operation": "turn", "diameter_mm": "56", "depth_mm": "2.5", "feed_mm_rev": "0.3",
       "speed_m_min": "220", "length_mm": "100"}  # fmt: skip
IN_INCHES = {"operation": "turn", "diameter_mm": "2.2", "depth_mm": "0.1", "feed_mm_rev": "0.012",
             "speed_m_min": "722", "typed": "en.inch"}  # fmt: skip
N_A_LBF, NM_A_FT_LBF, W_A_HP, MM_AN_IN = 4.4482216152605, 1.3558179483314, 745.69987158227, 25.4
INCH = {"autodb_units": "inch"}


def _text(html: str) -> str:
    shown = re.sub(r"<(script|style|title).*?</\1>", " ", html, flags=re.DOTALL)
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", shown)).replace("\u00a0", " ").split())


def _three(value: float) -> str:
    """Return a number with three significant digits, as the pages write it."""
    return f"{float(f'{value:.2e}'):.{max(0, 2 - int(np.floor(np.log10(value))))}f}"


def test_a_looked_up_force_is_its_newtons_over_the_pound(
    url: str, client: TestClient, store: Store, pair: dict[str, str]
) -> None:
    with store.reading() as session:
        alone = PairReader(session, "lathe-1").look_up(**pair, cut=as_cut(CUT))
    asked = f"{MACHINE}/pair?{urlencode(pair | CUT)}"
    with client_of(url, cookies=INCH) as shop:
        text, metric = (_text(one.get(asked).text) for one in (shop, client))
    for value, factor, unit in (
        (alone.cut.force_y_N.value, N_A_LBF, "lbf"),
        (alone.cut.force_z_N.value, N_A_LBF, "lbf"),
        (alone.cut.torque_N_m.value, NM_A_FT_LBF, "ft·lbf"),
        (alone.cut.power_W.value, W_A_HP, "hp"),
        (alone.figures.removal_cm3_min or 0.0, 16.387064, "in³/min"),
    ):
        assert f"{_three(value / factor)} {unit}" in text
    assert f"{_three(alone.cut.force_y_N.value)} N" in metric
    assert f"z force {900.0 / N_A_LBF:.6g} lbf" in text
    assert not re.search(r"\d (N|N·m|W|mm|m/min|mm/rev)\b(?!/)", text)


def test_numbers_are_typed_and_shown_again_in_inches(
    url: str, client: TestClient, pair: dict[str, str]
) -> None:
    metric = {"operation": "turn", "diameter_mm": "55.88", "depth_mm": "2.54",
              "feed_mm_rev": "0.3048", "speed_m_min": "220.0656"}  # fmt: skip
    asked = f"{MACHINE}/plan?{urlencode(pair | IN_INCHES)}"
    with client_of(url, cookies=INCH) as shop:
        html = shop.get(asked).text
        same = shop.get(f"{MACHINE}/plan?{urlencode(pair | metric)}").text
    assert "Depth [in]" in _text(html)
    assert "Feed [in/rev]" in _text(html)
    assert "Cutting speed [ft/min]" in _text(html)
    assert (
        'name="depth_mm" class="number" inputmode="decimal" autocomplete="off" value="0.1"' in html
    )
    assert 'name="typed" value="en.inch"' in html
    answer = re.compile(r"What it will take.*")
    found, expected = (answer.search(_text(one)) for one in (html, same))
    assert found is not None
    assert expected is not None
    assert found[0] == expected[0]
    # who has not chosen inches and gets this address sees the same cut, in millimetres
    sent = client.get(asked).text
    assert 'value="2.54"' in sent
    assert 'name="typed" value="en.si"' in sent


def test_a_wrong_number_is_said_as_it_was_typed(url: str, pair: dict[str, str]) -> None:
    with client_of(url, cookies=INCH) as shop:
        html = shop.get(f"{MACHINE}/plan?{urlencode(pair | IN_INCHES | {'depth_mm': 'deep'})}").text
    assert "cut 1: depth_mm: 'deep' is not a number" in _text(html)
    assert 'value="deep"' in html


def test_a_german_form_takes_what_it_shows(url: str, pair: dict[str, str]) -> None:
    """A decimal comma with three digits behind it is one where the form says that it is German."""
    typed = IN_INCHES | {"diameter_mm": "2,125", "depth_mm": "0,1", "feed_mm_rev": "0,012",
                         "typed": "de.inch"}  # fmt: skip
    cookies = INCH | {"autodb_language": "de"}
    with client_of(url, cookies=cookies) as shop:
        html = shop.get(f"{MACHINE}/plan?{urlencode(pair | typed)}").text
        assert 'value="2,125"' in html
        assert "Durchmesser 2,125 in, Schnitttiefe 0,1 in" in _text(html)
        either = shop.get(f"{MACHINE}/plan?{urlencode(pair | typed | {'diameter_mm': '2.125'})}")
        assert "kann 2,125 oder 2125 sein" in _text(either.text)


def test_plots_are_drawn_in_the_units_of_the_shop(
    url: str, client: TestClient, pair: dict[str, str]
) -> None:
    asked = f"{MACHINE}/pair?{urlencode(pair | CUT)}"
    with client_of(url, cookies=INCH) as shop:
        inches, metric = (_figures(one.get(asked).text) for one in (shop, client))
    ours, theirs = (
        next(one for one in found if _titles(one)[0].startswith("Force Y"))
        for found in (metric, inches)
    )
    assert "[lbf]" in _titles(theirs)[0]
    box, shop_box = (one["layout"]["shapes"][0] for one in (ours, theirs))
    for end in ("x0", "x1", "y0", "y1"):
        np.testing.assert_allclose(shop_box[end], box[end] / MM_AN_IN, rtol=1e-9)
    place, shop_place = (one["data"][-1]["x"] for one in (ours, theirs))
    np.testing.assert_allclose(_values(shop_place), _values(place) / MM_AN_IN, rtol=1e-6)


def _figures(html: str) -> list[Any]:
    found = re.findall(r'<script type="application/json">(.*?)</script>', html, re.DOTALL)
    return [json.loads(one)["figure"] for one in found]


def _titles(figure: Any) -> list[str]:
    return [one["text"] for one in figure["layout"]["annotations"]]


def _values(told: Any) -> NDArray[np.float64]:
    """Return numbers of a plot, which are in it as they are or as bytes."""
    if isinstance(told, dict):
        read = np.frombuffer(b64decode(told["bdata"]), dtype=np.dtype(told["dtype"]))
        return read.astype(np.float64)
    return np.asarray(told, dtype=np.float64)


def test_the_stock_of_a_program_is_typed_like_its_form() -> None:
    for stated, text in (("en.inch", "2.2"), ("de.inch", "2,2"), ("de.si", "55,88"), ("", "55.88")):
        assert typed_as(stated).length("stock_diameter_mm", text) == pytest.approx(55.88, rel=1e-12)
    for stated, text, said in (("", "1,234", "1.234 or 1234"), ("de.si", "1.234", "1,234 or 1234")):
        with pytest.raises(UnusableInput, match=said):
            typed_as(stated).length("stock_diameter_mm", text)


def test_the_report_of_a_mismatch_is_in_the_units_of_the_page(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = explained(channel(friction()).model_copy(update={"unit": "N"}))
    monkeypatch.setattr(pooling, "explain_mismatch", lambda *_: found)
    with store.reading() as session:
        number = mismatches(session, "lathe-1", decided=False)[0].id
    task = MismatchToExplain(number, Path("cuts.csv"))

    def shown(system: str) -> tuple[str, list[Any]]:
        with presented(presentation_of("en", system)):
            html = json.loads(task.do(store, lambda _: None))
        return html, _figures(html)

    (_, ours), (html, theirs) = shown("si"), shown("inch")
    assert "[lbf]" in _titles(theirs[0])[0]
    for one, other in zip(ours[0]["data"], theirs[0]["data"], strict=True):
        np.testing.assert_allclose(_values(other["y"]), _values(one["y"]) / N_A_LBF, rtol=1e-5)
    place, shop_place = (some[-1]["data"][0]["x"] for some in (ours, theirs))
    np.testing.assert_allclose(_values(shop_place), _values(place) / MM_AN_IN, rtol=1e-5)
    box, shop_box = (some[-1]["layout"]["shapes"][0] for some in (ours, theirs))
    assert shop_box["x0"] == pytest.approx(box["x0"] / MM_AN_IN, rel=1e-9)
    assert f"falls from {0.41 / N_A_LBF:.4f}\u00a0lbf" in html

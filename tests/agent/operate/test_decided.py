"""What a person confirms of a pair is in the next prediction; taken back, all is as it was before.

Of each cause: a shop that measures its forces, whose truth is no law of this program.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import select

from autodb.store import models, open_store
from tests.conftest import Cli
from tests.helpers.dynamometer_shop import (
    PAIR,
    Effect,
    blunt,
    drawn,
    forces,
    hard,
    joined,
    soft,
    thin,
    welded,
    written,
)

URL = "sqlite:///autodb.sqlite3"
THIN, SLOW, FAST = (0.03, 0.08), (40.0, 56.0), (150.0, 220.0)
Refused = Callable[..., str]


@dataclass(frozen=True)
class Shop:
    """A shop: its usual cuts, those that a cause was found in, and ones to predict."""

    effect: Effect
    usual: dict[str, Any]
    odd: dict[str, Any]
    ahead: dict[str, Any]


SHOPS = {
    "edge_force": Shop(
        blunt, drawn(1, 30, feed=(0.25, 0.4)), drawn(2, 20, feed=THIN), drawn(3, 6, feed=THIN)
    ),
    "size_effect": Shop(
        thin, drawn(1, 30, feed=(0.2, 0.4)), drawn(2, 20, feed=THIN), drawn(3, 6, feed=THIN)
    ),
    "speed_softening": Shop(
        soft, drawn(1, 30), drawn(2, 20, speed=(300.0, 400.0)), drawn(3, 6, speed=(300.0, 400.0))
    ),
    "built_up_edge": Shop(
        welded,
        joined(drawn(1, 20, speed=SLOW), drawn(2, 20, speed=FAST)),
        drawn(3, 20, speed=(70.0, 115.0)),
        joined(drawn(4, 4, speed=(80.0, 100.0)), drawn(5, 3, speed=(170.0, 200.0))),
    ),
}


SAID = {
    "built_up_edge": {
        name: {"value": value, "low": 0.9 * value, "high": 1.1 * value, "unit": unit}
        for name, value, unit in (("centre", 100.0, "m/min"), ("width", 0.25, "1"))
    }
}
"""What explain would say of a cause's numbers, some way off the truth."""


def made(cli: Cli, shop: Shop, *, usual: Effect | None) -> None:
    """Have a machine learn a shop's usual cuts, and exclude the others."""
    cli("init")
    cli("machine", "add", "lathe-1")
    for name, cuts, effect in (
        ("usual.csv", shop.usual, usual), ("odd.csv", shop.odd, shop.effect),
    ):  # fmt: skip
        cli("import", written(name, cuts, effect), "--machine", "lathe-1")
        cli("refresh", "--machine", "lathe-1")


def kept(term: str, channel: str = "force.y", recording: str = "odd.csv", **columns: Any) -> int:
    """Keep a cause as explain would, and return the mismatch' number."""
    store = open_store(URL)
    with store.writing() as session:
        named = select(models.StoredRecording).where(
            models.StoredRecording.path.endswith(recording)
        )
        row = models.Mismatch(
            **{
                "recording_id": session.scalars(named).one().id, "channel": channel, "term": term,
                "kind": "missing", "confidence": 0.9, "parameters": {}, "statement": "It differs.",
                **columns,
            }
        )  # fmt: skip
        session.add(row)
        session.flush()
        number = row.id
    store.close()
    return number


def predicted(
    cli: Cli, cuts: dict[str, Any], lot: str | None = None
) -> tuple[list[Any], list[str]]:
    """Return what is predicted of cuts, and the notes."""
    rows = zip(*(cuts[k].tolist() for k in ("feed", "depth", "speed")), strict=True)
    said = "" if lot is None else f"lot = '{lot}'\n"
    text = f"name = 'next'\nmaterial = '{PAIR[0]}'\ntool = '{PAIR[1]}'\n{said}"
    for feed, depth, speed in rows:
        text += (
            f"[[cut]]\ndiameter_mm = 60.0\nfeed_mm_rev = {feed}\ndepth_mm = {depth}\n"
            f"speed_m_min = {speed}\n"
        )
    Path("job.toml").write_text(text)
    found = json.loads(cli("predict", "job.toml", "--machine", "lathe-1", "--json").out)
    return found["cuts"], found["notes"]


def off(found: list[dict[str, Any]], truth: tuple[Any, Any]) -> tuple[float, float]:
    """Return the mean relative error of looked-up forces y and z, and the share of them held."""
    errors, held = [], []
    for k, real in zip("yz", truth, strict=True):
        for one, value in zip(found, real.tolist(), strict=True):
            force = one[f"force_{k}_N"]
            errors.append(abs(force["value"] - value) / value)
            held.append(force["low"] < value < force["high"])
    return float(np.mean(errors)), float(np.mean(held))


@pytest.mark.parametrize("term", SHOPS)
def test_a_confirmed_cause_of_a_pair_is_in_the_next_look_up(cli: Cli, term: str) -> None:
    shop = SHOPS[term]
    made(cli, shop, usual=shop.effect)
    truth = forces(shop.ahead, shop.effect)
    before = predicted(cli, shop.ahead)
    number = kept(term, parameters=SAID.get(term, {}))
    done = cli("mismatch", "confirm", number, "--because", "the second bar shows it").out
    assert f"mismatch {number}: {term} confirmed" in done
    print(done)
    after = predicted(cli, shop.ahead)
    was, is_now = off(before[0], truth), off(after[0], truth)
    print(term, was, is_now)
    assert is_now[0] < 0.6 * was[0]
    assert is_now[1] >= 0.9

    # It is traced and shown with its reason
    assert "confirmed as" in cli("mismatch", "show", number).out
    assert "because the second bar shows it" in cli("trace", "mismatch", number).out
    assert (
        f"mismatch {number}: force.y: {term} (missing, confirmed"
        in cli("trace", "parameters", _newest()).out
    )
    assert cli("doctor").code == 0

    # Taken back, everything is exactly as it was; the history says both
    back = cli("mismatch", "reopen", number, "--because", "it was another bar").out
    assert f"mismatch {number}: {term} is open again" in back
    assert "is taken back" in back
    assert predicted(cli, shop.ahead) == before
    history = cli("trace", "mismatch", number).out
    assert history.index("the second bar shows it") < history.index("it was another bar")
    assert ", taken back on" in history
    assert cli("doctor").code == 0

    # The next refresh changes nothing; rejected, the cuts are learnt after all
    cli("refresh", "--machine", "lathe-1")
    assert predicted(cli, shop.ahead) == before


def _newest() -> int:
    store = open_store(URL)
    with store.reading() as session:
        query = select(models.CuttingParameters.id).order_by(models.CuttingParameters.id.desc())
        number = session.scalars(query.limit(1)).one()
    store.close()
    return number

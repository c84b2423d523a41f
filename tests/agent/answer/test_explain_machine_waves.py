"""explain --machine on a mill's forces over time: the pair's own posterior is the simulation."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from sqlalchemy import select

from autodb.agent.rows.machines import find_machine
from autodb.agent.rows.posteriors import posterior_columns
from autodb.errors import UnusableInput
from autodb.explain.waves.teeth import Mill, StandsOut, Teeth
from autodb.forward.prediction import ToolOf
from autodb.forward.waveform import waves_N
from autodb.pairs.engaged import BY_NAME
from autodb.pairs.observed import Observed
from autodb.pairs.posterior import PairPosterior
from autodb.pairs.prior import any_metal
from autodb.pairs.updating import posterior_of_readings
from autodb.store import models, open_store
from tests.conftest import Cli, Once
from tests.helpers.campaigns import first

Array = NDArray[np.float64]

URL = "sqlite:///autodb.sqlite3"
TOOL = {"diameter_mm": 10.0, "teeth": 4.0, "helix_deg": 30.0, "rake_deg": 0.0}
RPM, RATE_HZ = 2400.0, 2000.0
K_N_MM2, EDGE_N_MM = (1800.0, 600.0, 300.0), (20.0, 25.0, 0.0)
OUT = (0.012, -0.004, -0.009, 0.001)
T = np.arange(0.0, 0.9, 1.0 / RATE_HZ)
ANGLE = 2.0 * np.pi * RPM / 60.0 * T


def _law(chip_mm: Array) -> tuple[Array, Array, Array]:
    pairs = zip(K_N_MM2, EDGE_N_MM, strict=True)
    t, r, a = (k * chip_mm + edge * (chip_mm > 0.0) for k, edge in pairs)
    return t, r, a


def _mill(feed_mm: float, depth_mm: float, width_mm: float) -> Mill:
    twist = float(depth_mm * np.tan(np.radians(30.0)) / 5.0)
    arc = (0.0, float(np.arccos(1.0 - 2.0 * width_mm / 10.0)))
    return Mill(4, twist, depth_mm, feed_mm, arc, slices=40)


def _sent(
    mill: Mill, angle: Array, inside: NDArray[np.bool_], out: StandsOut | None = None
) -> Array:
    teeth = Teeth(mill, angle, inside.astype(np.float64), np.ones(len(angle)))
    return teeth.forces(_law, out)


def _learnt() -> PairPosterior:
    """Return what ten cuts' mean forces tell of the pair."""
    turn = np.linspace(0.0, 2.0 * np.pi, 1440, endpoint=False)
    drawn = np.random.default_rng(5)
    made = [(f, d, w) for f in (0.03, 0.06, 0.1) for d in (1.0, 2.0) for w in (2.0, 4.0)]
    means = np.array([_sent(_mill(*one), turn, turn >= 0.0).mean(axis=1) for one in made])
    rows = [
        {"cutting.feed": f, "cutting.depth": d, "cutting.width": w, "spindle.speed": RPM}
        for f, d, w in made
    ]
    cuts = BY_NAME["side-up"].cuts(TOOL, rows, called="mill-10")
    count = len(made)
    observed = Observed(
        (cuts,), np.tile(np.arange(count), 3), np.repeat([0, 1, 2], count),
        (means + drawn.standard_normal(means.shape)).T.ravel(),
        np.full(3 * count, 1.0), np.zeros((3 * count, 0)),
    )  # fmt: skip
    return posterior_of_readings(any_metal(), observed)


@pytest.fixture
def milled(cli: Cli, once: Once) -> Cli:
    """Return the command line on a mill that has learnt a pair."""

    def make() -> None:
        cli("init")
        cli("machine", "add", "mill-1")
        store = open_store(URL)
        with store.writing() as session:
            tool = models.Tool(name="mill-10", **TOOL | {"teeth": 4})
            pair = models.Pair(material=models.Material(name="C45"), tool=tool)
            session.add(pair)
            session.flush()
            owner = find_machine(session, "mill-1")
            session.add(
                models.CuttingParameters(
                    machine_id=owner.id, pair_id=pair.id, version=1, **posterior_columns(_learnt())
                )
            )
        store.close()

    once(make)
    return cli


SIDE = """[recording]
work = "C45"
[tool]
name = "mill-10"
diameter_mm = 10.0
teeth = 4
helix_deg = 30.0
[cut]
operation = "side-up"
depth_mm = 2.0
width_mm = 3.0
feed_mm_tooth = 0.06
speed_rpm = 2400.0
"""


CUT = {"cutting.feed": 0.06, "cutting.depth": 2.0, "cutting.width": 3.0, "spindle.speed": RPM}
INSIDE = (T > 0.1) & (T < 0.8)


def _recorded(
    forces: Array, *, angle_deg: Array | None, side: str = SIDE, stamps_s: Array = T
) -> Path:
    """Write a cut that begins and ends in air, with noise of 4 N."""
    forces = forces + 4.0 * np.random.default_rng(11).standard_normal(forces.shape)
    columns = {"t": stamps_s, **{f"force.{axis}": forces[k] for k, axis in enumerate("xyz")}}
    if angle_deg is not None:
        columns["spindle.angle"] = angle_deg
    path = Path("cut.csv")
    np.savetxt(
        path, np.column_stack(list(columns.values())), delimiter=",", comments="", fmt="%.6f",
        header=",".join(columns),
    )  # fmt: skip
    Path("cut.csv.toml").unlink(missing_ok=True)
    Path("cut.toml").write_text(side, encoding="utf-8")
    return path


def _answer(ran: Any) -> dict[str, Any]:
    assert ran.code == 0, ran.err
    found: dict[str, Any] = json.loads(ran.out)["channels"]
    return found


def test_waves_of_a_posterior_have_the_means_that_it_learnt_and_come_back_each_pitch() -> None:
    posterior = _learnt()
    angle = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    waves = waves_N(posterior, ToolOf("mill-10", TOOL), "side-up", CUT, angle)
    truth = _sent(_mill(0.06, 2.0, 3.0), angle, angle >= 0.0).T
    assert waves.shape == (720, 3)
    assert_allclose(waves[:180], waves[180:360], atol=1e-6)
    assert_allclose(waves.mean(axis=0), truth.mean(axis=0), rtol=0.03, atol=1.0)
    # The posterior's edge fades under chips as thin as it is round; this truth's does not
    assert np.sqrt(np.mean((waves - truth) ** 2)) < 0.08 * np.sqrt(np.mean(truth**2))


def test_waves_refuse_what_does_not_mill_and_cuts_that_lack_something() -> None:
    tool = ToolOf("mill-10", TOOL)
    with pytest.raises(UnusableInput, match=r"'turn': use .*slot"):
        waves_N(any_metal(), tool, "turn", {}, np.zeros(3))
    narrow = {name: value for name, value in CUT.items() if name != "cutting.width"}
    with pytest.raises(UnusableInput, match=r"side-up.*cutting\.width"):
        waves_N(any_metal(), tool, "side-up", narrow, np.zeros(3))


@pytest.mark.parametrize("again", first(1, [False, True]))
def test_run_out_is_found_and_kept_as_a_mismatch(milled: Cli, again: bool) -> None:
    forces = _sent(_mill(0.06, 2.0, 3.0), ANGLE, INSIDE, StandsOut(OUT))
    path = _recorded(forces, angle_deg=np.degrees(ANGLE))
    ran = milled("explain", path, "--machine", "mill-1", "--json")
    for channel, answer in _answer(ran).items():
        missing = {c["term"]: c for c in answer["missing"] if c["kind"] == "missing"}
        if channel != "force.z":
            # The posterior's edge fades under thin chips, the truth's does not: that may be said
            assert "runout" in missing
            assert set(missing) <= {"runout", "size_effect"}
            out = missing["runout"]["parameters"]
            for tooth, mm in enumerate(OUT):
                assert abs(out[f"tooth {tooth}"]["value"] - mm) < 0.0015
    assert "wholly in the work" in ran.err
    listed = milled("mismatch", "list", "mill-1")
    assert "runout" in listed.out
    before = _peaks(milled)
    number = _number_of("runout")
    confirmed = milled("mismatch", "confirm", number)
    assert confirmed.code == 0, confirmed.err
    assert f"mismatch {number}: runout confirmed\ntool mill-10: run-out 0.01" in confirmed.out

    # The next prediction's peaks are those of a mill that runs out
    angle = np.linspace(0.0, 2.0 * np.pi, 1440, endpoint=False)
    true = np.abs(_sent(_mill(0.06, 2.0, 3.0), angle, angle >= 0.0, StandsOut(OUT))).max(axis=1)
    after = _peaks(milled)
    for k, (was, is_now) in enumerate(zip(before, after, strict=True)):
        assert is_now["low"] < true[k] < is_now["high"]
        assert abs(is_now["value"] - true[k]) < 0.5 * abs(was["value"] - true[k])

    # Explained again it is there; taken back, peaks are as they were
    if again:
        found = _answer(milled("explain", path, "--machine", "mill-1", "--json"))
        named = [c for a in found.values() for c in a["missing"] if c["term"] == "runout"]
        assert {cause["kind"] for cause in named} <= {"mistuned"}
    back = milled("mismatch", "reopen", number, "--why", "clamped anew").out
    assert "the run-out of tool mill-10 is taken back" in back
    assert _peaks(milled) == before


def _number_of(term: str) -> int:
    store = open_store(URL)
    with store.reading() as session:
        query = select(models.Mismatch.id).where(models.Mismatch.term == term)
        number = session.scalars(query.order_by(models.Mismatch.id)).first()
    store.close()
    assert number is not None
    return number


def _peaks(cli: Cli) -> list[dict[str, float]]:
    """Return the peaks of force x, y and z that a look-up of the cut has, by size."""
    ran = cli(
        "lookup", "--machine", "mill-1", "--material", "C45", "--tool", "mill-10", "--operation",
        "side-up", "--depth", 2, "--width", 3, "--feed", 0.06, "--rpm", RPM, "--json",
    )  # fmt: skip
    peaks = json.loads(ran.out)["cut"]["peaks"]
    found = []
    for axis in "xyz":
        value, low, high = (peaks[f"force_{axis}_N"][key] for key in ("value", "low", "high"))
        low, high = sorted((abs(low), abs(high)))
        found.append({"value": abs(value), "low": low, "high": high})
    return found


@pytest.mark.campaign
@pytest.mark.parametrize("angle_deg", [np.degrees(ANGLE) - 30.0, None])
def test_nothing_missing_where_nothing_is(milled: Cli, angle_deg: Array | None) -> None:
    """Neither with an angle whose zero is elsewhere, nor without one; 3 % more force is tuning."""
    waves = waves_N(_learnt(), ToolOf("mill-10", TOOL), "side-up", CUT, ANGLE).T
    path = _recorded(1.03 * waves * INSIDE, angle_deg=angle_deg)
    ran = milled("explain", path, "--machine", "mill-1", "--json")
    for answer in _answer(ran).values():
        causes = {cause["term"]: cause for cause in answer["missing"]}
        assert {cause["kind"] for cause in causes.values()} <= {"mistuned"}
        assert causes["shear"]["parameters"]["factor"]["value"] == pytest.approx(1.03, abs=0.004)
    assert ("its zero is taken from them" in ran.err) == (angle_deg is not None)


@pytest.mark.campaign
def test_stamps_rounded_to_a_millisecond_change_no_number(milled: Cli) -> None:
    """Two rows share a stamp; what is explained is a part of the recording."""
    waves = waves_N(_learnt(), ToolOf("mill-10", TOOL), "side-up", CUT, ANGLE).T
    answers, corrected = [], []
    for stamps_s in (T, np.floor(1000.0 * T) / 1000.0):
        path = _recorded(1.03 * waves * INSIDE, angle_deg=np.degrees(ANGLE), stamps_s=stamps_s)
        ran = milled("explain", path, "--machine", "mill-1", "--json", "--out", "answer")
        answers.append(_answer(ran))
        corrected.append(np.loadtxt("answer/corrected.csv", delimiter=",", skiprows=1))
    assert "stamps rounded to 1 ms" in ran.err
    for channel, answer in answers[0].items():
        pairs = zip(answer["missing"], answers[1][channel]["missing"], strict=True)
        for one, other in pairs:
            size, again = (cause["parameters"]["size"]["value"] for cause in (one, other))
            assert again == pytest.approx(size, rel=1e-4)
    assert_allclose(corrected[1], corrected[0], rtol=1e-4, atol=0.01)


@pytest.mark.parametrize(
    ("side", "said"),
    [
        (SIDE.replace('work = "C45"', ""), "a side file with [recording] work and [tool] name"),
        (SIDE.replace("C45", "Ti6Al4V"), "has no parameters of Ti6Al4V / mill-10"),
        (SIDE.replace('operation = "side-up"', ""), "state [cut] operation in a side file"),
        (SIDE.replace("depth_mm = 2.0", ""), "depth_mm"),
        (SIDE.replace("width_mm = 3.0", ""), "cutting.width"),
    ],
)
def test_what_is_missing_is_named(milled: Cli, side: str, said: str) -> None:
    path = _recorded(_sent(_mill(0.06, 2.0, 3.0), ANGLE, INSIDE), angle_deg=None, side=side)
    ran = milled("explain", path, "--machine", "mill-1")
    assert ran.code == 2
    assert said in ran.err
    assert len(ran.err.strip().splitlines()) == 1
    assert not Path("cut-explained").exists()

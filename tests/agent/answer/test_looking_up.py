"""Look-ups, material cards into and out of a database, and predictions as tables and pictures."""

import csv
import json
import re
import shutil
from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sqlalchemy import event
from sqlalchemy.orm import Session

from autodb.agent.answer.looking_up import PairReader
from autodb.agent.answer.predicting import predict_job
from autodb.agent.learn.starting import start_of
from autodb.agent.rows.imported_cards import imported_card, keep_cards
from autodb.agent.rows.machines import add_machine
from autodb.agent.rows.posteriors import learnt_pairs, posterior_columns
from autodb.cutting import shear, tools
from autodb.cutting.elements import (
    Elements,
    cut_forces,
    force_gradient,
    force_parts,
    linearised_forces,
)
from autodb.cutting.kienzle import kienzle
from autodb.files.job import Job
from autodb.files.job_cut import KEYS, OPERATIONS, JobCut
from autodb.files.machine import AxisFile, AxisLimits, MachineFile
from autodb.fitting.gaussian import Gaussian
from autodb.forward.predictedfile import prediction_as_csv
from autodb.forward.prediction import Interval, Peaks, PredictedCut
from autodb.pairs.cards import read_cards
from autodb.pairs.engaged import BY_NAME
from autodb.pairs.posterior import PairPosterior, law_error
from autodb.pairs.prior import any_metal, of_card, of_relative
from autodb.store import Store, create_store, models, open_store
from tests.conftest import Cli

URL = "sqlite:///autodb.sqlite3"
CUT = JobCut(operation="turn", diameter_mm=50.0, depth_mm=2.0, feed_mm_rev=0.25, speed_m_min=220.0)
INSERT = {"nose_radius_mm": 0.8, "kappa_deg": 95.0, "rake_deg": -6.0, "inclination_deg": -6.0,
          "included_deg": 80.0}  # fmt: skip
MILL = {"diameter_mm": 10.0, "teeth": 4, "helix_deg": 30.0}
ASKED = (
    *("lookup", "--machine", "m", "--material", "steel", "--tool", "insert"),
    *("--diameter", 50, "--depth", 2, "--feed", 0.25, "--speed", 220),
)
CARDS = (
    "material,k_c1.1,k_c1.1_unit,m_c,rake_deg,lower,upper,source\n"
    "brass,780,MPa,0.2,0,700,870,book\nsteel C45,2.1,kN/mm²,0.18,6,1.8,2.4,shop\n"
)
ONE_OF_EACH: dict[str, float] = {
    "diameter_mm": 50.0, "depth_mm": 2.0, "width_mm": 2.0, "feed_mm_rev": 0.2,
    "feed_mm_tooth": 0.05, "direction_deg": 20.0, "ramp_deg": 3.0, "pocket_diameter_mm": 40.0,
}  # fmt: skip
SIX_DIGITS = 1e-5
FORCES = ("force_x_N", "force_y_N", "force_z_N", "torque_N_m", "power_W")


def _posterior(scale: float = 1.0) -> PairPosterior:
    start = any_metal().also((law_error("turn"),))
    state = Gaussian(start.state.mean, 0.04 * scale * start.state.covariance)
    return replace(start, state=state, cuts=12)


def _row(machine: int, pair: int, version: int, posterior: PairPosterior, **more: Any) -> Any:
    return models.CuttingParameters(
        machine_id=machine, pair_id=pair, version=version, **posterior_columns(posterior), **more
    )


@pytest.fixture(scope="module")
def database(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a database with a machine that has posteriors of two tools and one steel."""
    path = tmp_path_factory.mktemp("store") / "made.sqlite3"
    create_store(f"sqlite:///{path}")
    opened = open_store(f"sqlite:///{path}")
    limits = {"z": AxisLimits(force_N=500.0), "spindle": AxisLimits(torque_N_m=20.0)}
    axes = {name: AxisFile(limits=of) for name, of in limits.items()}
    for name in ("m", "other"):
        add_machine(opened, name, MachineFile(axes=axes))
    with opened.writing() as session:
        steel = models.Material(name="steel")
        insert = models.Tool(name="insert", kind="turning_insert", **INSERT)
        mill = models.Tool(name="mill", kind="end_mill", **MILL)
        pairs = [models.Pair(material=steel, tool=tool) for tool in (insert, mill)]
        session.add_all(pairs)
        session.flush()
        session.add(_row(1, pairs[0].id, 1, _posterior(2.0)))
        session.add(_row(1, pairs[0].id, 2, _posterior()))
        session.add(_row(1, pairs[0].id, 3, _posterior(9.0), undone_at="2026-01-01"))
        session.add(_row(1, pairs[0].id, 4, _posterior(9.0), state="built_up_edge"))
        session.add(_row(1, pairs[1].id, 1, replace(_posterior(), cuts=3)))
    opened.close()
    return path


@pytest.fixture
def store(cli: Cli, database: Path) -> Iterator[Store]:
    """Return a copy of the database, in the folder that commands run in."""
    del cli
    shutil.copyfile(database, "autodb.sqlite3")
    opened = open_store(URL)
    yield opened
    opened.close()


def _elements(operation: str) -> Elements:
    stated = {name: ONE_OF_EACH[name] for name in KEYS[operation].needs}
    stated |= {"direction_deg": 20.0} if operation in ("taper", "contour") else {}
    cut = JobCut.model_validate({"operation": operation, "speed_rpm": 900.0, **stated})
    tool = {"turning_insert": INSERT, "end_mill": MILL, "drill": {"diameter_mm": 8.0}}[
        BY_NAME[operation].kind
    ]
    rows = [cut.conditions(tool.get("diameter_mm"))] * 2
    return BY_NAME[operation].cuts(tool, rows, called="t").elements


@pytest.mark.parametrize("operation", OPERATIONS)
def test_forces_parts_and_derivatives_together_are_those_alone(operation: str) -> None:
    theta, elements = _posterior().law.mean, _elements(operation)
    whole, parts, slopes = linearised_forces(theta, elements)
    for found, alone in (
        (whole, cut_forces(theta, elements).all),
        (parts, force_parts(theta, elements)),
        (slopes, force_gradient(theta, elements)),
    ):
        assert_allclose(found, alone, rtol=0, atol=1e-12 * np.abs(alone).max())


def test_a_look_up_says_what_predict_says_and_stores_nothing(store: Store) -> None:
    job = Job(name="j", material="steel", tool="insert", cut=(CUT,))
    with store.reading() as session:
        found = PairReader(session, "m").look_up("steel", "insert", CUT)
    predicted = predict_job(store, "m", job)
    assert asdict(found.cut) == asdict(predicted.cuts[0])
    assert (found.behind, found.notes) == (predicted.behind, predicted.notes)
    assert (found.behind.version, found.behind.cuts) == (2, 12)
    assert found.exceeds == predicted.exceeds
    assert {one.axis for one in found.exceeds} == {"z", "spindle"}
    with store.reading() as session:
        PairReader(session, "m").look_up("steel", "insert", CUT)
        assert len(session.query(models.Prediction).all()) == 1


def test_the_command_prints_the_table_of_predict(store: Store, cli: Cli) -> None:
    del store
    done = cli(*ASKED)
    assert done.code == 0
    assert re.search(r"turn +1401 +220 ", done.out)
    assert "chance to exceed spindle's 20 N·m" in done.out
    assert "behind it: 12 cuts, version 2 (parameters 2)" in done.out
    answer = json.loads(cli(*ASKED, "--json").out)
    assert answer["behind"]["version"] == 2
    assert answer["cut"]["force_y_N"]["low"] < answer["cut"]["force_y_N"]["value"]


def test_without_a_cut_the_pairs_are_listed(store: Store, cli: Cli) -> None:
    del store
    assert re.search(r"steel +insert +12 +2 .*\n +steel +mill +3 +1 ", cli(*ASKED[:3]).out)
    only = cli(*ASKED[:3], "--tool", "mill", "--json").out
    assert [(row["tool"], row["cuts"]) for row in json.loads(only)] == [("mill", 3)]
    assert "has no fitted pair yet" in cli("lookup", "--machine", "other").out


@pytest.mark.parametrize(
    "ask",
    [
        lambda session: PairReader(session, "m").pairs(),
        lambda session: learnt_pairs(session, 1),
    ],
    ids=["listed", "learnt"],
)
def test_the_list_of_pairs_does_not_read_every_version(
    store: Store, ask: Callable[[Session], list[Any]]
) -> None:
    """A version's covariance stands before what says whether it counts: to look reads it."""
    asked: list[tuple[str, Any]] = []
    event.listen(store.engine, "before_cursor_execute", lambda *a: asked.append((a[2], a[3])))
    with store.reading() as session:
        assert len(ask(session)) == 2
        statement, given = asked[-1]
        plan = session.connection().exec_driver_sql(f"EXPLAIN QUERY PLAN {statement}", given).all()
    correlated = {row[0] for row in plan if "CORRELATED" in row[3]}
    steps = [row[3] for row in plan if row[1] not in correlated]
    of_all = [step for step in steps if re.search(r"(SEARCH|SCAN) cutting_parameters", step)]
    assert of_all
    for step in of_all:
        assert re.search("COVERING INDEX|INTEGER PRIMARY KEY", step)


MILLED = ("--operation", "slot", "--depth", 2, "--rpm", 3000)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (("--depth", 2), "operation 'turn' needs --diameter and --feed"),
        (MILLED, "operation 'slot' needs --feed"),
        ((*MILLED, "--feed", 0.05, "--width", 2), "operation 'slot' has no --width; it takes "),
        (("--operation", "trun"), "--operation 'trun': there is none (did you mean turn"),
        (("--diameter", 5, "--depth", -1, "--feed", 1), "--depth: must be greater than 0, not -1"),
        (("--diameter", 5, "--depth", 1, "--feed", 1), "give either --rpm or --speed"),
        (
            ("--tool", "insrt"),
            "has no parameters of a pair with tool 'insrt' (did you mean insert?)",
        ),
        ((*MILLED, "--feed", 0.05), "a cut needs --material and --tool"),
    ],
    ids=lambda asked: asked if isinstance(asked, str) else "",
)
def test_what_cannot_be_looked_up_names_options(
    store: Store, refused: Callable[..., str], asked: tuple[object, ...], said: str
) -> None:
    del store
    assert said in refused("lookup", "--machine", "m", *asked)


@pytest.mark.parametrize("kind", sorted(tools.OF_KIND))
def test_what_is_assumed_of_a_tool_is_what_its_cuts_assume(kind: str) -> None:
    operation = next(one for one in BY_NAME.values() if one.kind == kind)
    stated = {"diameter_mm": 8.0, "teeth": 2} if kind != "turning_insert" else {}
    needs = {name: ONE_OF_EACH[name] for name in KEYS[operation.name].needs}
    cut = JobCut.model_validate({"operation": operation.name, "speed_rpm": 900.0, **needs})
    made = operation.cuts(stated, [cut.conditions(stated.get("diameter_mm"))], called="t")
    names = [one.key.removeprefix("t: ") for one in made.variants]
    assert names == [one.key for one in tools.assumed_of(kind, stated)]


# Material cards


def test_a_card_enters_once_and_one_of_its_source_replaces_it(store: Store, cli: Cli) -> None:
    path = Path("cards.csv")
    path.write_text(CARDS, "utf-8")
    assert cli("import", path).out.count(": imported") == 2
    assert cli("import", path).out.count(": already there") == 2
    path.write_text(CARDS.replace("2.1,kN", "2.2,kN"), "utf-8")
    done = cli("import", path)
    assert "card of steel C45 (shop): replaces the one of this source: k_c1.1 2100" in done.out
    assert "card of brass (book): already there" in done.out
    with store.reading() as session:
        kept = imported_card(session, 1, "STEEL c45")
        assert imported_card(session, 1, "copper") is None
        assert len(session.query(models.ConventionalParameter).all()) == 12
    assert kept is not None
    again = read_cards(path)[1]
    assert_allclose(kept.card.tangential, again.card.tangential, rtol=1e-12)
    assert (kept.k_c11, kept.m_c, kept.m_c_bounds) == (again.k_c11, again.m_c, again.m_c_bounds)
    assert (kept.at.thinnest_mm, kept.at.thickest_mm) == (
        again.at.thinnest_mm,
        again.at.thickest_mm,
    )


def test_a_bad_card_is_refused_whole(store: Store, refused: Callable[..., str]) -> None:
    Path("cards.csv").write_text(CARDS.replace("0.18,6", "1.8,6"), "utf-8")
    assert "cards.csv: column 'm_c', row 2: is 1.8" in refused("import", "cards.csv")
    with store.reading() as session:
        assert session.query(models.ConventionalParameter).all() == []


def test_a_new_pair_starts_from_a_relative_then_a_card_then_what_ships(store: Store) -> None:
    path = Path("cards.csv")
    path.write_text(CARDS.replace("brass", "steel").replace("C45", "42CrMo4"), "utf-8")
    keep_cards(store, read_cards(path))
    with store.reading() as session:
        related, card, ships, metal = (
            start_of(session, 1, material, "new tool")
            for material in ("steel", "steel 42crmo4", "aisi 1045", "unobtainium")
        )
    assert str(related.said).startswith("steel / insert, the same material with another tool")
    assert_allclose(related.posterior.law.mean, of_relative(_posterior()).law.mean)
    assert card.said == "imported card of steel 42CrMo4 (shop)"
    assert_allclose(card.posterior.law.mean, of_card(read_cards(path)[1].card).law.mean, rtol=1e-9)
    assert str(ships.said).startswith("conventional values of")
    assert str(metal.said).startswith("what any metal may have")


def test_cards_of_a_machine_read_back_and_tell_it_nothing(store: Store, cli: Cli) -> None:
    done = cli("export", "--cards", "own.csv", "--machine", "m")
    assert "excluded: steel / mill (3 cuts): the card is of insert (12 cuts)" in done.out
    (card,) = read_cards(Path("own.csv"))
    assert card.source.startswith("autodb: machine m, insert, 12 cuts, version 2, ")
    assert_allclose(np.degrees(card.at.rake_rad), INSERT["rake_deg"])
    law, at = _posterior().law, card.at
    true = shear.per_width(law.mean, at.edge)[0]
    off = kienzle(law, at).off  # what Kienzle's line leaves of the law
    assert_allclose(card.card.tangential, true, rtol=off + SIX_DIGITS)
    assert cli("import", "own.csv").code == 0
    with store.reading() as session:
        assert imported_card(session, 1, "steel") is None
    with store.reading() as session:
        assert imported_card(session, 2, "steel") is not None


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (("--cards", "c.txt", "--machine", "m"), "c.txt does not end in .csv; write FILE.csv"),
        (("--cards", "c.csv"), "--cards needs --machine NAME"),
        (("--cards", "c.csv", "--machine", "m", "--material", "stel"), "did you mean steel?"),
        (("--cards", "no/c.csv", "--machine", "m"), "no: no such folder"),
        ((), "give one of a folder for the tables, --cards FILE.csv, --coefficients FILE.json"),
        (("tables", "--tool", "mill"), "--material and --tool go with --cards"),
    ],
    ids=lambda asked: asked if isinstance(asked, str) else "",
)
def test_cards_that_cannot_be_written_say_why(
    store: Store, refused: Callable[..., str], asked: tuple[str, ...], said: str
) -> None:
    del store
    assert said in refused("export", *asked)


# A prediction as a table and a picture


JOB = (
    'name = "j"\nmaterial = "steel"\ntool = "insert"\n[[cut]]\nname = "rough <Ø50>"\n'
    "diameter_mm = 50\ndepth_mm = 2\nfeed_mm_rev = 0.25\nspeed_m_min = 220\n"
)


def test_a_prediction_is_written_as_table_and_picture(store: Store, cli: Cli) -> None:
    del store
    Path("job.toml").write_text(JOB, "utf-8")
    files = ("--csv", "p.csv", "--plot", "p.html")
    done = cli("predict", "job.toml", "--machine", "m", *files, "--json")
    answer = json.loads(done.out)["cuts"][0]
    with Path("p.csv").open(encoding="utf-8", newline="") as file:
        (row,) = csv.DictReader(file)
    channels = ("force.x", "force.y", "force.z", "torque.spindle", "spindle.power")
    for channel, field in zip(channels, FORCES, strict=True):
        for end, name in (("", "value"), (".low", "low"), (".high", "high")):
            assert_allclose(float(row[f"{channel}{end}"]), answer[field][name], rtol=1e-5)
    assert (row["name"], row["force.z.limit"], row["force.y.limit"]) == ("rough <Ø50>", "500", "")
    assert 0.0 < float(row["torque.spindle.chance"]) < 1.0
    page = Path("p.html").read_text("utf-8")
    assert "limit \\u00b1 500 N" in page or "limit ± 500 N" in page
    assert "chance to exceed z&#39;s 500 N" in page
    (numbers, *_) = re.findall(r'<th scope="row">rough &lt;Ø50&gt;</th>(.*?)</tr>', page)
    shown = [float(one) for one in re.findall(r"<td>(-?[\d.]+) \(", numbers)]
    assert_allclose(shown, [answer[field]["value"] for field in FORCES], rtol=6e-3)
    assert "rough <Ø50>" not in page.split("</head>")[1]
    assert not re.search(r"<(?:script|img|link)[^>]+(?:src|href)=[\"']?https?:", page)


@pytest.mark.parametrize(
    ("option", "name", "said"),
    [("--csv", "p.txt", "does not end in .csv"), ("--plot", "no/p.html", "no: no such folder")],
)
def test_names_that_cannot_be_written_are_refused_before_anything_is_stored(
    store: Store, refused: Callable[..., str], option: str, name: str, said: str
) -> None:
    Path("job.toml").write_text(JOB, "utf-8")
    assert said in refused("predict", "job.toml", "--machine", "m", option, name)
    with store.reading() as session:
        assert session.query(models.Prediction).all() == []


def test_a_cut_s_name_that_is_a_formula_is_written_as_text() -> None:
    mean = Interval(-1.0, -2.0, 0.5)
    cut = PredictedCut("=1+1", "turn", 3000.0, 94.0, mean, mean, mean, mean, mean)
    (row,) = csv.DictReader(prediction_as_csv([cut], {}).splitlines())
    assert (row["name"], row["force.x"]) == ("'=1+1", "-1")


def test_a_mill_s_row_has_peaks_and_its_chance_is_theirs() -> None:
    mean, peak = Interval(100.0, 80.4, 119.6), Interval(200.0, 180.4, 219.6)
    cut = PredictedCut(
        "a", "slot", 3000.0, 94.0, mean, mean, mean, mean, mean, Peaks(peak, peak, peak, peak, peak)
    )
    (row,) = csv.DictReader(prediction_as_csv([cut], {"x": AxisLimits(force_N=200.0)}).splitlines())
    assert (row["force.x"], row["force.x.peak"], row["force.x.chance"]) == ("100", "200", "0.5")
    assert row["force.y.chance"] == row["torque.spindle.limit"] == ""


def test_numbers_of_a_cut_may_have_a_decimal_comma(cli: Cli) -> None:
    cli("init")
    cli("machine", "add", "lathe-1")
    cut = ["--material", "C45", "--tool", "CNMG120408", "--diameter", "50", "--speed", "220"]
    point, comma = (
        cli("lookup", *cut, "--depth", depth, "--feed", feed)
        for depth, feed in (("2.5", "0.25"), ("2,5", "0,25"))
    )
    assert (comma.code, comma.out) == (0, point.out)
    for typed, said in (("1,234", "--feed: '1,234' may be 1.234 or 1234"), ("deep", "--feed: 'd")):
        refused = cli("lookup", *cut, "--depth", "2", "--feed", typed)
        assert refused.code == 2
        assert refused.err.startswith(f"autodb: {said}")

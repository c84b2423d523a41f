"""What machines know together, and which of them disagrees."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sqlalchemy import event, select

from autodb.agent.fleet.sharing import learn_fleet
from autodb.agent.learn.shared_priors import known_from, newest_prior
from autodb.agent.learn.starting import start_of
from autodb.agent.operate.refreshing import refresh
from autodb.agent.rows.machines import as_file, find_machine, update_machine
from autodb.agent.sense.gain_check import standard_cut
from autodb.proofs.machines.lathe import fleets
from autodb.store import Store, create_store, models, open_store
from tests.conftest import Cli
from tests.helpers import shops
from tests.helpers.virtual_fleet import FIRST, FLEET, MACHINES, OFF, PAIRS, SECOND, SEED, added

pytestmark = pytest.mark.usefixtures("one_law")

FEW = 20
"""Values that a statement is given, whatever the number of machines: more than a row's keys."""


def _prior(store: Store, material: str) -> models.FleetPrior:
    with store.reading() as session:
        row = session.scalars(select(models.Material).where(models.Material.name == material)).one()
        prior = newest_prior(session, row.id)
        assert prior is not None
        assert prior.known is not None
        session.expunge_all()
        return prior


@pytest.mark.parametrize("behind", [2, 6])
def test_what_a_refresh_asks_does_not_grow_with_other_machines(tmp_path: Path, behind: int) -> None:
    store = _stored(tmp_path)
    rng = np.random.default_rng([SEED, 4])
    every = shops.names(1 + behind)
    for name in every:
        shops.add(store, name, fleets.on_machine(rng, FLEET, PAIRS[:1]), cuts=4, rng=rng)
    for name in every:  # after the first one's pass, the others sense
        refresh(store, name)
    shops.add(store, every[0], fleets.on_machine(rng, FLEET, PAIRS[:1]), cuts=4, rng=rng)
    asked: list[int] = []

    def count(_c: Any, _cursor: Any, said: str, given: Any, _context: Any, _many: bool) -> None:
        if said.startswith("SELECT"):
            asked.append(len(given))

    event.listen(store.engine, "before_cursor_execute", count)
    done = refresh(store, every[0])
    event.remove(store.engine, "before_cursor_execute", count)
    store.close()
    assert done.versions
    assert max(asked) < FEW


def _stored(folder: Path) -> Store:
    url = f"sqlite:///{folder / 'own.sqlite3'}"
    create_store(url)
    return open_store(url)


@pytest.mark.usefixtures("shop")
def test_a_calibration_that_is_off_is_named_and_stays_out(cli: Cli) -> None:
    done = cli("fleet", "learn")
    assert done.code == 0
    (named,) = [line for line in done.out.splitlines() if "disagrees" in line]
    assert named.startswith(f"{OFF} disagrees in ")
    assert "its calibration is off: force along +" in named
    assert "determined from 3 pairs shared with others" in named
    for material in FLEET.materials:
        assert f"{material}: version 1 from {MACHINES - 1} machines, 1 tool" in done.out
    shown = cli("fleet", "show").out
    assert named in shown
    assert {
        one["material"] for one in json.loads(cli("fleet", "show", "--json").out)["materials"]
    } == {*FLEET.materials}
    again = cli("fleet", "learn").out.splitlines()
    assert again == ["nothing new for all machines together", named]


def test_a_machine_that_never_cut_it_starts_from_the_others(shop: Store, cli: Cli) -> None:
    material = FLEET.materials[0]
    learn_fleet(shop)
    added(shop, "new", PAIRS[:1], cuts=1)
    with shop.reading() as session:
        owner = find_machine(session, "new")
        with_it = start_of(session, owner.id, material, FIRST)
        without = start_of(session, owner.id, material, SECOND)
    others = MACHINES - 1
    assert (
        with_it.said
        == f"{others} other machines that cut the material, {others} of them with this tool"
    )
    assert without.said == f"{others} other machines that cut the material, with other tools"
    narrow, wide = (np.diag(one.posterior.law.covariance) for one in (with_it, without))
    assert np.all(narrow <= wide * (1.0 + 1e-9))
    assert np.sum(narrow < 0.9 * wide) >= 4
    done = cli("refresh", "--machine", "new")
    assert f"{material} / {FIRST}: version 1 from 1 cuts" in done.out
    traced = cli("trace", "parameters", "16").out
    assert f"began as: {others} other machines" in traced
    assert "machine 'lathe-0': parameters 1:" in traced
    assert OFF not in traced
    assert "lathe-0 1.csv" not in traced  # its recordings are its own


def test_recordings_of_others_are_traced_where_their_machine_shares_them(
    shop: Store, cli: Cli
) -> None:
    with shop.reading() as session:
        file = as_file(find_machine(session, "lathe-0"))
    update_machine(shop, "lathe-0", file.model_copy(update={"shares": "recordings"}))
    update_machine(shop, "lathe-1", file.model_copy(update={"shares": "nothing"}))
    learn_fleet(shop)
    added(shop, "new", PAIRS[:1], cuts=1)
    refresh(shop, "new")
    traced = cli("trace", "parameters", "16").out
    assert "lathe-0 1.csv" in traced
    assert "machine 'lathe-1'" not in traced
    assert f"prior 1: {FLEET.materials[0]}, version 1, {MACHINES - 2} machines" in traced


def test_a_pair_s_own_cuts_do_not_count_twice(shop: Store) -> None:
    """Its start is the same whether the others' sums hold it or not."""
    material = FLEET.materials[1]
    learn_fleet(shop)
    with shop.reading() as session:
        first = find_machine(session, "lathe-0").id
        held = start_of(session, first, material, FIRST).posterior.law
    with shop.reading() as session:
        file = as_file(find_machine(session, "lathe-0"))
    update_machine(shop, "lathe-0", file.model_copy(update={"shares": "nothing"}))
    learn_fleet(shop)
    with shop.reading() as session:
        alone = start_of(session, first, material, FIRST).posterior.law
    assert_allclose(held.mean, alone.mean, rtol=1e-6, atol=1e-8)
    assert_allclose(held.covariance, alone.covariance, rtol=1e-5, atol=1e-9)


def test_what_nobody_shares_is_known_together_no_more(shop: Store, cli: Cli) -> None:
    learn_fleet(shop)
    for name in shops.names(MACHINES):
        with shop.reading() as session:
            file = as_file(find_machine(session, name))
        update_machine(shop, name, file.model_copy(update={"shares": "nothing"}))
    assert learn_fleet(shop).lines() == ["nothing new for all machines together"]
    assert "nothing has been fitted for all machines yet" in cli("fleet", "show").err
    with shop.reading() as session:
        owner = find_machine(session, "lathe-0")
        assert start_of(session, owner.id, FLEET.materials[0], SECOND).prior is None
    assert cli("doctor").out.count("FAILED") == 1  # the recordings of virtual cuts are no files


def test_bit_by_bit_is_all_at_once(shop: Store, cli: Cli) -> None:
    learn_fleet(shop)
    added(shop, "new", PAIRS[:2], cuts=3)
    refresh(shop, "new")
    done = learn_fleet(shop)
    assert [(one.material, one.version) for one in done.materials] == [
        (name, 2) for name in FLEET.materials[:2]
    ]
    bit_by_bit = [_prior(shop, name) for name in FLEET.materials]
    with shop.writing() as session:
        for row in session.scalars(select(models.FleetPrior)):
            if row.version == 2:
                row.known = {**(row.known or {}), "tools": {}, "aside": []}
                row.parameters = []
    learn_fleet(shop)
    for before, name in zip(bit_by_bit[:2], FLEET.materials, strict=False):
        after = _prior(shop, name)
        assert after.version == 3
        assert after.machines == before.machines
        assert_allclose(after.mean, before.mean, rtol=1e-7, atol=1e-9)
        assert_allclose(after.covariance, before.covariance, rtol=1e-6, atol=1e-10)
        shares = known_from(before.known or {}).shares
        assert_allclose(known_from(after.known or {}).shares, shares, rtol=1e-9)
    assert cli("doctor").code == 1  # versions 2 were emptied, and it says so


def test_one_that_agrees_again_comes_back(shop: Store) -> None:
    learn_fleet(shop)
    with shop.writing(OFF) as session:
        owner = find_machine(session, OFF)
        for row in session.scalars(
            select(models.CuttingParameters).where(models.CuttingParameters.machine_id == owner.id)
        ):
            row.undone_at = models.now()
        forces = session.scalars(
            select(models.SensedForce).where(
                models.SensedForce.cut.has(models.Cut.recording.has(machine_id=owner.id)),
                models.SensedForce.value_N.is_not(None),
            )
        )
        for force in forces:
            force.value_N = float(force.value_N or 0.0) / 1.6
    refresh(shop, OFF)
    done = learn_fleet(shop)
    assert done.named == []
    assert {one.machines for one in done.materials} == {MACHINES}


def test_a_standard_cut_says_how_a_machine_senses(shop: Store) -> None:
    """The published cut of the kit, 485.78 N along, 325.78 N across, sensed a fifth too large."""
    with shop.reading() as session:
        assert standard_cut(session, find_machine(session, "lathe-0").id) is None
    published = {"y": 485.78, "z": 325.78}
    with shop.writing("lathe-0") as session:
        owner = find_machine(session, "lathe-0")
        pair = models.Pair(
            material=models.Material(name="Aluminium alloy"), tool=models.Tool(name=_tool())
        )
        recording = models.StoredRecording(
            machine_id=owner.id, sha256="standard", path="standard.csv", kind="cuts", rows=1,
            units={}, side={},
        )  # fmt: skip
        cut = models.Cut(
            recording=recording, number=1, operation="turn", pair=pair, measured={},
            conditions={"spindle.speed": 1000.0, "cutting.feed": 0.2, "cutting.depth": 2.0},
        )  # fmt: skip
        session.add(cut)
        session.flush()
        for component, value in published.items():
            session.add(
                models.SensedForce(
                    cut_id=cut.id, component=component, estimator="range", value_N=1.2 * value,
                    sd_N=10.0, calibration=_calibration(owner.id, component),
                )
            )  # fmt: skip
    with shop.reading() as session:
        found = standard_cut(session, find_machine(session, "lathe-0").id)
    assert found is not None
    assert_allclose(found.gain, [0.2, 0.2], rtol=1e-6)
    assert found.along.tolist() == [[1.0, 0.0], [0.0, 1.0]]
    assert np.all((found.sd > 0.04) & (found.sd < 0.09))


def _tool() -> str:
    from autodb.standard import read_protocol

    return read_protocol("turning-aluminium").tool


def _calibration(machine_id: int, component: str) -> models.CalibrationVersion:
    return models.CalibrationVersion(
        machine_id=machine_id, axis=component, version=9, component=component, kind="line",
        parameters={}, channel=f"{component}.current", current_unit="A", unit="N",
        coefficients=[0.0, 1.0], covariance=[[1.0, 0.0], [0.0, 1.0]], scores={},
        current_low=0.0, current_high=1.0, offered=True, verdict="good", scores_with_transients={},
        transients=[],
    )  # fmt: skip


def test_nothing_known_together_says_what_would(cli: Cli) -> None:
    cli("init")
    done = cli("fleet", "show")
    assert (done.code, done.err) == (
        2,
        "autodb: nothing has been fitted for all machines yet; run 'autodb fleet learn'\n",
    )
    assert cli("fleet", "learn").out == "nothing new for all machines together\n"
    assert "add one with 'autodb machine add NAME'" in cli("fleet", "refresh").err

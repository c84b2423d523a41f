"""A machine's clock that is set is told from one that goes on."""

from dataclasses import replace

import pytest

from autodb.live.source import SourceClock
from autodb.proofs.machines.served.mtconnect import MtConnectServer
from autodb.proofs.machines.served.opcua import OpcUaServer
from tests.conftest import Cli
from tests.helpers.campaigns import first
from tests.helpers.running_machine import (
    cuts_stored,
    new_database,
    run_agent,
    running,
    same_as_said,
    write_agentfile,
)
from tests.helpers.shifts import LATHE, MILL, MILL_SPEED, SPEED, all_in, free_port, rows_recorded


@pytest.mark.parametrize("off_s", first(1, [-3600.0, -4.0, 86400.0]))
def test_a_machine_whose_clock_is_set_cuts_on(cli: Cli, off_s: float) -> None:
    """In a pause: every cut is whole, and what it stated before holds."""
    del cli
    pause = (LATHE.cuts[0][1] + LATHE.cuts[1][0]) // 2 // 50 * 50
    shift = replace(LATHE, clock_set=(pause, off_s))
    with running(MtConnectServer(shift)) as one:
        new_database(mill=False)
        path = write_agentfile(one.server, shift, protocol="mtconnect")
        one.when_read(path, SPEED)
        said, agent = run_agent(path, all_in(3))
    same_as_said(LATHE)
    assert sum("clock was set" in line for line in said) == agent.health.gaps == 1
    assert {cut.pair_id for cut in cuts_stored()} == {1}  # the tool was said once, at the beginning


@pytest.mark.campaign  # of MTConnect, and of what is heard: the other tests here
def test_a_clock_that_is_set_in_a_cut_parts_it(cli: Cli) -> None:
    del cli
    place = MILL.cuts[0][0] + 200
    shift = replace(MILL, clock_set=(place, -3600.0))
    server = OpcUaServer(shift, port=free_port())
    with running(server) as one:
        new_database(mill=True)
        path = write_agentfile(server, shift, protocol="opcua", item=server.item)
        one.when_read(path, MILL_SPEED)
        _, agent = run_agent(path, all_in(3))
    assert [len(rows) for rows in rows_recorded()] == [200, 176, 376]
    assert (agent.health.gaps, agent.health.late) == (1, 0)


def _heard(*said: dict[str, list[float]]) -> list[list[tuple[dict[str, list[float]], bool]]]:
    clock = SourceClock(["i", "p"], float("-inf"))
    found = []
    for one in said:
        parts = clock.heard({item: (at, [0.0] * len(at)) for item, at in one.items()})
        found.append([({item: at for item, (at, _) in p.values.items()}, p.jump) for p in parts])
    return found


def test_a_clock_that_is_set_is_told_from_one_that_goes_on() -> None:
    """Back or ahead, between batches or in one; states that are old, and quiet, are neither."""
    assert _heard({"i": [1.0, 2.0], "e": [-500.0]}, {"i": [2.5, 9.0], "p": [8.0]}) == [
        [({"i": [1.0, 2.0], "e": [-500.0]}, False)],
        [({"i": [2.5, 9.0], "p": [8.0]}, False)],
    ]
    assert _heard({"i": [100.0]}, {"i": [50.0, 51.0], "e": [50.5]})[1] == [
        ({"i": [50.0, 51.0], "e": [50.5]}, True)
    ]
    assert _heard({"i": [100.0]}, {"i": [101.0, 501.0], "p": [501.0], "e": [101.0, 500.5]})[1] == [
        ({"i": [101.0], "e": [101.0]}, False),
        ({"i": [501.0], "p": [501.0], "e": [500.5]}, True),
    ]
    assert _heard({"i": [100.0]}, {"i": [101.0, 41.0, 42.0, 902.0]})[1] == [
        ({"i": [101.0]}, False), ({"i": [41.0, 42.0]}, True), ({"i": [902.0]}, True)
    ]  # fmt: skip
    caught_up = {"i": [float(at) for at in range(101, 160)], "p": [101.0, 159.0]}
    assert _heard({"i": [100.0]}, caught_up)[1] == [(caught_up, False)]
    assert _heard({"i": [100.0]}, {"e": [10.0]})[1] == [({"e": [10.0]}, False)]
    assert _heard({"i": [100.0]})[0] == [({"i": [100.0]}, False)]
    three_back = {"i": [100.5, 98.0, 98.5], "p": [100.4, 97.9], "e": [98.2]}
    assert _heard({"i": [100.0], "p": [99.0]}, three_back)[1] == [
        ({"i": [100.5], "p": [100.4], "e": [98.2]}, False), ({"i": [98.0, 98.5], "p": [97.9]}, True)
    ]  # fmt: skip
    went_on = {"i": [99.0, 100.9], "p": [99.9]}
    assert _heard({"i": [100.0], "p": [99.0]}, three_back, went_on)[2] == [(went_on, False)]
    after_a_restart = SourceClock(["i"], 50.0)
    (morning,) = after_a_restart.heard({"i": ([30_000.0], [1.0])})
    assert not morning.jump
    assert after_a_restart.heard({"i": ([60_000.0], [1.0])})[0].jump

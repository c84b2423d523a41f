"""An agent beside virtual machines that run: what they cut is recorded, sensed and learnt from."""

import time
from pathlib import Path

import pytest
from numpy.testing import assert_allclose

from autodb.agent.operate.health import read_health
from autodb.agent.operate.running import health_of
from autodb.proofs.machines.served.mtconnect import MtConnectServer
from autodb.proofs.machines.served.shift import ServedShift
from tests.conftest import Cli
from tests.helpers.running_machine import (
    MACHINE,
    Running,
    connected,
    cuts_stored,
    holds,
    new_database,
    recorded,
    run_agent,
    running,
    same_as_said,
    write_agentfile,
)
from tests.helpers.shifts import LATHE, MILL, MILL_SPEED, SPEED, all_in, rows_recorded, served_mill


def test_a_lathe_behind_mtconnect_teaches_its_database(
    lathe: Running, cli: Cli, sample_jobs: Path
) -> None:
    """Phase currents at 1 kHz: what was said is recorded to the bit, sensed, and learnt from."""
    table = sample_jobs / "stepped_shaft" / "recordings" / "standard-cuts.csv"
    assert cli("import", str(table), "--machine", MACHINE).code == 0
    assert cli("calibrate", "--machine", MACHINE).code == 0
    assert cli("refresh", "--machine", MACHINE).code == 0
    lathe.when_read(Path("agent.toml"), SPEED)
    said, agent = run_agent(Path("agent.toml"), all_in(3))
    same_as_said(LATHE)
    cuts = cuts_stored()
    told = [cut.conditions for cut in cuts]
    assert [(one["cutting.depth"], one["cutting.feed"]) for one in told] == [
        (2.0, 0.2), (1.0, 0.15), (1.5, 0.25)
    ]  # fmt: skip
    assert all("z.current.range" in cut.measured for cut in cuts)
    assert any("steel bar / carbide insert: version" in line for line in said)
    health = read_health(health_of(Path("agent.toml")))
    assert (health.cuts, health.gaps, health.late, health.waiting) == (3, 0, 0, 0)
    assert agent.health.line().startswith(time.strftime("%H"))


def _late_in_pause(shift: ServedShift) -> int:
    """Return a row of the first pause between cuts by which the cut before it has ended."""
    (_, end), (begin, _) = shift.cuts[:2]
    return end + round(0.85 * (begin - end))


async def _restarted(one: Running, pause: int, *, speed: float) -> None:
    """Play a shift up to a row in a pause, be away until that was noticed, and play the rest."""
    path = Path("agent.toml")
    await holds(lambda: connected(path))
    await one.server.play(speed=speed, upto=pause)
    await holds(lambda: len(recorded()) == 1)
    await one.server.stop()
    await holds(lambda: not connected(path))
    await one.server.start()
    await holds(lambda: connected(path))
    await one.server.play(speed=speed)


def test_a_server_that_is_restarted_is_read_again(cli: Cli) -> None:
    """OPC UA, fourteen channels at 250 Hz: the server goes in a pause; both cuts are whole."""
    del cli
    with served_mill(history=False) as one:
        one.begin(_restarted(one, _late_in_pause(MILL), speed=MILL_SPEED))
        said, agent = run_agent(Path("agent.toml"), all_in(2))
        same_as_said(MILL)
        (first, second) = cuts_stored()
        assert (first.operation, first.conditions["cutting.width"]) == ("side-down", 5.0)
        assert_allclose(second.conditions["cutting.feed"], 400.0 / 3500.0 / 2.0)
        assert (agent.health.gaps, agent.health.late, agent.health.lost) == (1, 0, 0)
        assert said[0].endswith(": connected")
        assert sum(line.endswith(": connected") for line in said) == 2
        assert any(line.endswith("; trying again") for line in said)


@pytest.mark.campaign  # over OPC UA at every change: the test above
def test_an_mtconnect_agent_that_is_restarted_is_read_from_its_beginning(lathe: Running) -> None:
    """It counts anew, and what it had kept is gone: both sides of a gap in a pause are whole."""
    lathe.begin(_restarted(lathe, _late_in_pause(LATHE), speed=SPEED))
    _, agent = run_agent(Path("agent.toml"), all_in(3))
    same_as_said(LATHE)
    assert agent.health.gaps == 1


async def _played_as_heard(server: MtConnectServer) -> None:
    """Play the rest of a shift, no more at a time than its buffer has room for."""
    for upto in range(LATHE.cuts[1][0] + 2000, LATHE.rows + 1000, 1000):
        await holds(lambda: server.heard)
        await server.play(speed=1000.0, upto=min(upto, LATHE.rows))


def test_what_an_agent_has_forgotten_is_a_gap(cli: Cli) -> None:
    """A buffer of two seconds; nobody listens for longer."""
    del cli
    server = MtConnectServer(LATHE, buffer=600)
    with running(server) as one:
        new_database(mill=False)
        path = write_agentfile(one.server, LATHE, protocol="mtconnect")
        one.call(one.server.play(speed=50.0, upto=1000))
        run_agent(path, lambda: health_of(path).is_file() and read_health(health_of(path)).well)
        one.call(one.server.play(speed=50.0, upto=LATHE.cuts[1][0] + 1000))
        one.begin(_played_as_heard(server))
        _, agent = run_agent(path, all_in(2))
        assert agent.health.gaps == 1
        assert len(recorded()) == 2
        assert abs(len(rows_recorded()[1]) - 5900) <= 1


def test_while_the_database_is_away_cuts_wait_in_the_inbox(lathe: Running) -> None:
    lathe.when_read(Path("agent.toml"), SPEED)
    away = Path("away.sqlite3")

    def recorded_all() -> bool:
        if not away.exists() and not list(Path().glob("*.sqlite3-*")):
            Path("autodb.sqlite3").rename(away)
        return len(recorded()) == 3 and away.exists()

    said, agent = run_agent(Path("agent.toml"), recorded_all)
    assert any(line.startswith("refresh: ") and line.endswith("trying again") for line in said)
    assert not agent.health.well
    _, again = run_agent(Path("agent.toml"), lambda: True)  # it records all the same
    assert again.health.refresh
    away.rename("autodb.sqlite3")
    said, _ = run_agent(Path("agent.toml"), all_in(3))
    same_as_said(LATHE)

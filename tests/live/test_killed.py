"""An agent that is killed: no cut is lost and none comes twice; what nobody heard is a gap."""

import hashlib
import os
import shutil
import signal
import time
from pathlib import Path

import numpy as np
import pytest

from autodb.agent.operate.running import Agent, health_of, journal_of
from autodb.files.excuses import excuse
from autodb.live.agentfile import read_agentfile
from autodb.live.journal import Journal
from autodb.proofs.machines.served.mtconnect import MtConnectServer
from tests.conftest import Cli
from tests.helpers.campaigns import first
from tests.helpers.running_machine import (
    Running,
    connected,
    cuts_stored,
    holds,
    new_database,
    opened,
    recorded,
    run_agent,
    running,
    same_as_said,
    write_agentfile,
)
from tests.helpers.shifts import (
    CHANNELS,
    LATHE,
    MILL,
    MILL_SPEED,
    SPEED,
    all_in,
    rows_recorded,
    served_mill,
)


def _checksums() -> dict[str, str]:
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in recorded()}


def _forked(path: Path) -> int:
    """Fork an agent that runs until it is killed; return its process id."""
    child = os.fork()
    if child:
        return child
    try:
        Agent(path, read_agentfile(path), opened, say=lambda _: None, excuse=excuse).run()
    finally:
        os._exit(0)


def _kill_in_turn(path: Path, lives_s: list[float]) -> None:
    for lives in lives_s:
        child = _forked(path)
        time.sleep(lives)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)


@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
@pytest.mark.parametrize(("times", "beside"), first(1, [(3, False), (5, True)]))
def test_killed_again_and_again_no_cut_is_lost_or_comes_twice(
    lathe: Running, cli: Cli, times: int, beside: bool
) -> None:
    """Lives of an agent while a lathe turns three bars; the same files as of one life, byte by
    byte, where one is lived ``beside``."""
    lathe.when_read(Path("agent.toml"), SPEED)
    lives = np.random.default_rng(140).uniform(0.3, 1.4, times)
    _kill_in_turn(Path("agent.toml"), lives.tolist())
    run_agent(Path("agent.toml"), all_in(3))
    same_as_said(LATHE)
    assert len(cuts_stored()) == 3
    assert cli("doctor").code == 0
    if not beside:
        return
    killed = _checksums()
    shutil.rmtree("inbox")
    shutil.rmtree("agent-journal")
    Path("autodb.sqlite3").unlink()
    new_database(mill=False)
    lathe.call(lathe.server.stop())
    with running(MtConnectServer(LATHE)) as again:
        write_agentfile(again.server, LATHE, protocol="mtconnect")
        again.when_read(Path("agent.toml"), 2.0 * SPEED)
        run_agent(Path("agent.toml"), all_in(3))
    lathe.call(lathe.server.start())
    assert _checksums() == killed


def _killed_at(one: Running, row: int) -> None:
    """Kill an agent when all is in its journal that the mill said before a row."""
    path = Path("agent.toml")
    child = _forked(path)
    one.call(holds(lambda: connected(path)))
    one.call(one.server.play(speed=MILL_SPEED, upto=row))
    heard_s = MILL.instant_s(row - 1) - 1e-6

    def heard() -> bool:
        said = Journal(journal_of(path)).read()
        last = {} if said.position is None else said.position["last"]
        return max((last[item] for item in CHANNELS if item in last), default=0.0) >= heard_s

    one.call(holds(heard))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    health_of(path).unlink()


@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
def test_what_a_server_remembers_is_read_after_a_kill(cli: Cli) -> None:
    """While nobody listens the mill goes on; its server's history has it."""
    del cli
    with served_mill(history=True) as one:
        _killed_at(one, MILL.cuts[0][0] + 150)
        one.call(one.server.play(speed=MILL_SPEED, upto=MILL.cuts[1][0] + 100))
        one.when_read(Path("agent.toml"), MILL_SPEED)
        _, agent = run_agent(Path("agent.toml"), all_in(2))
        same_as_said(MILL)
        assert agent.health.gaps == 0


@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
def test_without_a_history_what_nobody_heard_is_a_gap(cli: Cli) -> None:
    """What was heard before it is recorded, and what comes behind it."""
    del cli
    with served_mill(history=False) as one:
        middle = MILL.cuts[0][0] + 150
        _killed_at(one, middle)
        one.call(one.server.play(speed=MILL_SPEED, upto=middle + 30))
        one.when_read(Path("agent.toml"), MILL_SPEED)
        _, agent = run_agent(Path("agent.toml"), all_in(3))
        assert agent.health.gaps == 1
        rows = [len(mill_rows) for mill_rows in rows_recorded()]
        assert rows[0] == 150
        assert abs(rows[1] - (MILL.cuts[0][1] - middle - 30)) <= 2
        assert abs(rows[2] - 375) <= 1

"""An agent beside virtual machines that run: nothing they cut is lost, nothing is counted twice."""

import asyncio
import hashlib
import json
import os
import shutil
import signal
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import aclosing, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.agent.operate.health import Health, read_health
from autodb.agent.operate.running import Agent, health_of, journal_of
from autodb.errors import UnusableInput
from autodb.files.excuses import excuse
from autodb.live import mtconnect
from autodb.live.agentfile import read_agentfile
from autodb.live.batch import Batch
from autodb.live.journal import Journal
from autodb.live.mtconnect import MtConnect
from autodb.live.source import Away, SourceClock
from autodb.proofs.machines.served.mtconnect import MtConnectServer
from autodb.proofs.machines.served.opcua import OpcUaServer
from autodb.proofs.machines.served.shift import lathe_shift, mill_shift
from tests.conftest import Cli
from tests.helpers.running_machine import (
    MACHINE,
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

LATHE = lathe_shift(3, 5)
MILL = mill_shift(2, 5, longest_s=1.5, pause_s=0.8)
SPEED = 6.0
CHANNELS = [OpcUaServer(MILL, port=0).item(name) for name in MILL.columns]


def _free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


@pytest.fixture
def lathe(cli: Cli) -> Iterator[Running]:
    """Run a lathe behind MTConnect, with its agent file and an empty database."""
    del cli
    with running(MtConnectServer(LATHE)) as one:
        new_database(mill=False)
        write_agentfile(one.server, LATHE, protocol="mtconnect")
        yield one


@contextmanager
def _mill(*, history: bool) -> Iterator[Running]:
    server = OpcUaServer(MILL, port=_free_port(), history=history)
    with running(server) as one:
        new_database(mill=True)
        write_agentfile(server, MILL, protocol="opcua", item=server.item)
        yield one


def _all_in(count: int) -> Callable[[], bool]:
    return lambda: len(cuts_stored()) >= count


def _checksums() -> dict[str, str]:
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in recorded()}


def test_a_lathe_behind_mtconnect_teaches_its_database(
    lathe: Running, cli: Cli, sample_jobs: Path
) -> None:
    """Phase currents at 1 kHz: what was said is recorded to the bit, felt, and learnt from."""
    table = sample_jobs / "stepped_shaft" / "recordings" / "standard-cuts.csv"
    assert cli("import", str(table), "--machine", MACHINE).code == 0
    assert cli("calibrate", "--machine", MACHINE).code == 0
    assert cli("refresh", "--machine", MACHINE).code == 0
    lathe.when_read(Path("agent.toml"), SPEED)
    said, agent = run_agent(Path("agent.toml"), _all_in(3))
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


def test_a_mill_over_opc_ua(cli: Cli) -> None:
    """Fourteen channels, a node each, at 250 Hz."""
    del cli
    with _mill(history=False) as one:
        one.when_read(Path("agent.toml"), 1.0)
        said, agent = run_agent(Path("agent.toml"), _all_in(2))
        same_as_said(MILL)
        (first, second) = cuts_stored()
        assert (first.operation, first.conditions["cutting.width"]) == ("side-down", 5.0)
        assert_allclose(second.conditions["cutting.feed"], 400.0 / 3500.0 / 2.0)
        assert (agent.health.gaps, agent.health.late, agent.health.lost) == (0, 0, 0)
        assert said[0].endswith(": connected")


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
def test_killed_again_and_again_no_cut_is_lost_or_comes_twice(lathe: Running, cli: Cli) -> None:
    """Eight lives of an agent while a lathe turns three bars; the same files, the same cuts."""
    lathe.when_read(Path("agent.toml"), SPEED)
    lives = np.random.default_rng(140).uniform(0.3, 1.4, 8)
    _kill_in_turn(Path("agent.toml"), lives.tolist())
    run_agent(Path("agent.toml"), _all_in(3))
    same_as_said(LATHE)
    assert len(cuts_stored()) == 3
    assert cli("doctor").code == 0
    killed = _checksums()
    shutil.rmtree("inbox")
    shutil.rmtree("agent-journal")
    Path("autodb.sqlite3").unlink()
    new_database(mill=False)
    lathe.call(lathe.server.stop())
    with running(MtConnectServer(LATHE)) as again:
        write_agentfile(again.server, LATHE, protocol="mtconnect")
        again.when_read(Path("agent.toml"), 2.0 * SPEED)
        run_agent(Path("agent.toml"), _all_in(3))
    lathe.call(lathe.server.start())
    assert _checksums() == killed


def _killed_at(one: Running, row: int) -> None:
    """Kill an agent when all is in its journal that the mill said before a row."""
    path = Path("agent.toml")
    child = _forked(path)
    one.call(holds(lambda: connected(path)))
    one.call(one.server.play(speed=1.0, upto=row))
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
    with _mill(history=True) as one:
        _killed_at(one, MILL.cuts[0][0] + 150)
        one.call(one.server.play(speed=1.0, upto=MILL.cuts[1][0] + 100))
        one.when_read(Path("agent.toml"), 1.0)
        _, agent = run_agent(Path("agent.toml"), _all_in(2))
        same_as_said(MILL)
        assert agent.health.gaps == 0


@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
def test_without_a_history_what_nobody_heard_is_a_gap(cli: Cli) -> None:
    """What was heard before it is recorded, and what comes behind it."""
    del cli
    with _mill(history=False) as one:
        middle = MILL.cuts[0][0] + 150
        _killed_at(one, middle)
        one.call(one.server.play(speed=1.0, upto=middle + 30))
        one.when_read(Path("agent.toml"), 1.0)
        _, agent = run_agent(Path("agent.toml"), _all_in(3))
        assert agent.health.gaps == 1
        rows = [len(mill_rows) for mill_rows in _rows()]
        assert rows[0] == 150
        assert abs(rows[1] - (MILL.cuts[0][1] - middle - 30)) <= 2
        assert abs(rows[2] - 375) <= 1


def _rows() -> list[Any]:
    import pyarrow.parquet as pq

    return [pq.read_table(path)["t"] for path in recorded()]


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
    """OPC UA: the server goes in a pause and comes back; both cuts are whole."""
    del cli
    with _mill(history=False) as one:
        pause = (MILL.cuts[0][1] + MILL.cuts[1][0]) // 2

        one.begin(_restarted(one, pause, speed=1.0))
        said, agent = run_agent(Path("agent.toml"), _all_in(2))
        same_as_said(MILL)
        assert agent.health.gaps == 1
        assert sum(line.endswith(": connected") for line in said) == 2
        assert any(line.endswith("; trying again") for line in said)


def test_an_mtconnect_agent_that_is_restarted_is_read_from_its_beginning(lathe: Running) -> None:
    """It counts anew, and what it had kept is gone: both sides of a gap in a pause are whole."""
    pause = (LATHE.cuts[0][1] + LATHE.cuts[1][0]) // 2
    lathe.begin(_restarted(lathe, pause, speed=SPEED))
    _, agent = run_agent(Path("agent.toml"), _all_in(3))
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
        _, agent = run_agent(path, _all_in(2))
        assert agent.health.gaps == 1
        assert len(recorded()) == 2
        assert abs(len(_rows()[1]) - 5900) <= 1


def _streams(first: int, following: int, value: float) -> str:
    header = f'instanceId="7" firstSequence="{first}" nextSequence="{following}"'
    load = f'dataItemId="load" sequence="{following - 1}"'
    instant = f"2026-01-01T00:00:{following:02d}Z"
    return f"""<MTConnectStreams><Header {header}/>
    <Load {load} timestamp="{instant}">{value}</Load></MTConnectStreams>"""


FORGOTTEN = '<MTConnectError><Error errorCode="OUT_OF_RANGE">from: 7</Error></MTConnectError>'


@pytest.mark.parametrize("as_part", [True, False], ids=["in the stream", "as its answer"])
@pytest.mark.usefixtures("cli")
def test_what_is_forgotten_while_it_is_read_is_a_gap_at_once(
    monkeypatch: pytest.MonkeyPatch, as_part: bool
) -> None:
    """Read on from what the agent still has, without a word of its being away."""
    probe = '<a><DataItem id="load" category="SAMPLE" type="LOAD"/></a>'
    refused = (
        httpx.Response(200, content=_part(_streams(1, 7, 2.0)) + _part(FORGOTTEN))
        if as_part
        else httpx.Response(404, text=FORGOTTEN)
    )
    answers: dict[str, list[str | httpx.Response]] = {
        "/probe": [probe],
        "/current": [_streams(1, 5, 1.0), _streams(20, 30, 9.0), _streams(20, 30, 3.0)],
        "/sample": [refused, httpx.Response(200, content=_part(_streams(20, 31, 4.0)))],
    }

    def answer(request: httpx.Request) -> httpx.Response:
        said = answers[request.url.path].pop(0)
        return httpx.Response(200, text=said) if isinstance(said, str) else said

    path = write_agentfile(MtConnectServer(LATHE), LATHE, protocol="mtconnect")
    source = MtConnect(read_agentfile(path))
    source._items = ["load"]
    transport = httpx.MockTransport(answer)
    monkeypatch.setattr(source, "_client", lambda: httpx.AsyncClient(transport=transport))
    monkeypatch.setattr(source, "_base", "http://agent")
    found: list[tuple[Any, bool, int]] = []

    def keep(one: Batch) -> None:
        found.append((one.values["load"][1][0], one.gap, one.position["next"]))

    async def read() -> None:
        async with aclosing(source.batches(None)) as batches:
            async for one in batches:
                keep(one)

    with pytest.raises(Away, match="ended its stream"):
        asyncio.run(read())
    heard = [(2.0, False, 7)] if as_part else []
    assert found == [(1.0, False, 5), *heard, (3.0, True, 20), (4.0, False, 31)]
    assert not any(answers.values())


@pytest.mark.parametrize("off_s", [-3600.0, 86400.0])
def test_a_machine_whose_clock_is_set_cuts_on(cli: Cli, off_s: float) -> None:
    """In a pause: every cut is whole, and what it stated before holds."""
    del cli
    pause = (LATHE.cuts[0][1] + LATHE.cuts[1][0]) // 2 // 50 * 50
    shift = replace(LATHE, clock_set=(pause, off_s))
    with running(MtConnectServer(shift)) as one:
        new_database(mill=False)
        path = write_agentfile(one.server, shift, protocol="mtconnect")
        one.when_read(path, SPEED)
        said, agent = run_agent(path, _all_in(3))
    same_as_said(LATHE)
    assert sum("clock was set" in line for line in said) == agent.health.gaps == 1
    assert {cut.pair_id for cut in cuts_stored()} == {1}  # the tool was said once, at the beginning


def test_a_clock_that_is_set_in_a_cut_parts_it(cli: Cli) -> None:
    del cli
    place = MILL.cuts[0][0] + 200
    shift = replace(MILL, clock_set=(place, -3600.0))
    server = OpcUaServer(shift, port=_free_port())
    with running(server) as one:
        new_database(mill=True)
        path = write_agentfile(server, shift, protocol="opcua", item=server.item)
        one.when_read(path, 1.0)
        _, agent = run_agent(path, _all_in(3))
    assert [len(rows) for rows in _rows()] == [200, 176, 376]
    assert (agent.health.gaps, agent.health.late) == (1, 0)


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
    said, _ = run_agent(Path("agent.toml"), _all_in(3))
    same_as_said(LATHE)


def test_check_list_and_health(lathe: Running, cli: Cli) -> None:
    lathe.call(lathe.server.play(speed=50.0, upto=LATHE.cuts[0][0] + 200))
    done = cli("agent", "agent.toml", "--check")
    assert done.code == 0, done.out
    assert "it cuts now" in done.out
    assert "[cut] while: holds" in done.out
    assert "recording.work" in done.out
    assert "steel bar" in done.out
    listed = cli("agent", "agent.toml", "--list")
    assert listed.code == 0
    assert all(name in listed.out for name in [*LATHE.columns, *LATHE.states])
    unknown = cli("agent", "agent.toml", "--health")
    assert unknown.code == 2
    assert "an agent that was started would have written it" in unknown.err
    Path("agent-journal").mkdir()
    Health(MACHINE, state="connected").write(health_of(Path("agent.toml")))
    assert cli("agent", "agent.toml", "--health").code == 0
    old = json.loads(health_of(Path("agent.toml")).read_text())
    health_of(Path("agent.toml")).write_text(json.dumps({**old, "at_s": old["at_s"] - 3600.0}))
    ill = cli("agent", "agent.toml", "--health")
    assert ill.code == 1
    assert "it is not running" in ill.out


@pytest.mark.usefixtures("lathe")
def test_what_is_wrong_from_the_start_is_said(cli: Cli) -> None:
    text = Path("agent.toml").read_text()

    def refused(old: str, new: str) -> str:
        Path("agent.toml").write_text(text.replace(old, new))
        done = cli("agent", "agent.toml")
        assert done.code == 2, done.out
        (line,) = done.err.strip().splitlines()
        return line

    assert "has no item 'execute' (did you mean" in refused('"execution"', '"execute"')
    assert "machine-2" in refused(MACHINE, "machine-2")
    both = refused('"work"', '"d_tool"')
    assert "'d_tool' and 'tool' are one item" in both or "'tool' and 'd_tool'" in both
    Path("agent.toml").write_text(text)
    Path("autodb.sqlite3").unlink()
    shutil.rmtree("agent-journal")
    assert cli("agent", "agent.toml").code == 2
    assert not Path("agent-journal").exists()


@pytest.mark.usefixtures("lathe")
def test_one_agent_a_file(cli: Cli) -> None:
    from filelock import FileLock

    Path("agent-journal").mkdir()
    with FileLock("agent-journal/lock"):
        done = cli("agent", "agent.toml")
    assert done.code == 2
    assert "another agent of it is running" in done.err


@pytest.mark.usefixtures("lathe")
def test_without_the_extra_it_is_said(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("autodb.live.opening.LIBRARIES", ("a_library_that_is_not_there",))
    done = cli("agent", "agent.toml")
    assert done.code == 2
    assert "pip install 'autodb[live]'" in done.err


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
    after_a_restart = SourceClock(["i"], 50.0)
    (morning,) = after_a_restart.heard({"i": ([30_000.0], [1.0])})
    assert not morning.jump
    assert after_a_restart.heard({"i": ([60_000.0], [1.0])})[0].jump


def _part(body: str) -> bytes:
    head = f"--b\r\nContent-type: text/xml\r\nContent-LENGTH: {len(body)}\r\n\r\n"
    return head.encode() + body.encode() + b"\r\n"


def test_parts_come_out_whole_however_they_come_in() -> None:
    stream = _part("<a>\r\n\r\n</a>") + _part("") + _part("<b/>")
    for step in (1, 2, 7, len(stream)):
        parts = mtconnect._Parts()
        found = [
            part
            for begin in range(0, len(stream), step)
            for part in parts.feed(stream[begin : begin + step])
        ]
        assert found == [b"<a>\r\n\r\n</a>", b"", b"<b/>"]
    with pytest.raises(ValueError, match="without Content-length"):
        mtconnect._Parts().feed(b"--b\r\nContent-type: text/xml\r\n\r\n")


def test_a_time_series_ends_at_its_timestamp() -> None:
    """MTConnect, TimeSeries: the timestamp is that of the last value; unknown is no number."""
    text = """<MTConnectStreams xmlns="urn:mtconnect.org:MTConnectStreams:2.2">
    <Header instanceId="7" nextSequence="9" firstSequence="1"/><Streams><Samples>
    <LoadTimeSeries dataItemId="a" sequence="4" timestamp="2026-01-01T00:00:01.123456789Z"
      sampleCount="3">1 2.5 -3e2</LoadTimeSeries>
    <Position dataItemId="b" sequence="6" timestamp="2026-01-01T00:00:02Z@0.5">5</Position>
    <Position dataItemId="b" sequence="5" timestamp="2026-01-01T00:00:01Z">UNAVAILABLE</Position>
    <Execution dataItemId="c" sequence="7" timestamp="2026-01-01T00:00:01Z">ACTIVE</Execution>
    <Warning dataItemId="d" sequence="8" timestamp="2026-01-01T00:00:01Z"/>
    <Position dataItemId="e" sequence="8" timestamp="2026-01-01T00:00:01Z">1</Position>
    </Samples></Streams></MTConnectStreams>"""
    found = mtconnect._document(text.encode(), {"a": 100.0}, {"a", "b", "c", "d"})
    start = 1767225600.0
    assert_allclose(found.values["a"][0], start + 1.123456 - np.array([0.02, 0.01, 0.0]))
    assert found.values["a"][1] == [1.0, 2.5, -300.0]
    assert found.values["b"] == ([start + 1.0, start + 2.0], [None, 5.0])
    assert found.values["c"][1] == ["ACTIVE"]
    assert found.values["d"][1] == ["Warning"]
    assert set(found.values) == {"a", "b", "c", "d"}
    assert found.following == 9
    with pytest.raises(ValueError, match="no sampleRate"):
        mtconnect._document(text.encode(), {}, {"a"})
    with pytest.raises(ValueError, match="too far back"):
        mtconnect._document(
            b"<MTConnectError><Error>too far back</Error></MTConnectError>", {}, set()
        )


@pytest.mark.parametrize(
    "url", ["http://127.0.0.1:9", "127.0.0.1:5000", "opc.tcp://127.0.0.1:9/"], ids=str
)
def test_a_machine_that_does_not_answer_is_away(cli: Cli, url: str) -> None:
    new_database(mill=False)
    path = write_agentfile(MtConnectServer(LATHE), LATHE, protocol="mtconnect")
    text = path.read_text().replace("http://127.0.0.1:0", url)
    path.write_text(text.replace('"mtconnect"', '"opcua"') if "opc" in url else text)
    done = cli("agent", "agent.toml", "--check")
    assert done.code == 2
    assert url in done.err
    assert len(done.err.strip().splitlines()) == 1


@pytest.mark.usefixtures("lathe")
def test_an_agent_that_talks_nonsense_is_away() -> None:
    source = MtConnect(read_agentfile(Path("agent.toml")))
    with pytest.raises(Away, match="cannot be read"):
        source._read(b"<html>")
    assert issubclass(Away, UnusableInput)

"""The command that runs an agent: its check, list and health, and what it refuses."""

import json
import shutil
from pathlib import Path

import pytest

from autodb.agent.operate.health import Health
from autodb.agent.operate.running import health_of
from autodb.proofs.machines.served.mtconnect import MtConnectServer
from tests.conftest import Cli
from tests.helpers.running_machine import (
    MACHINE,
    Running,
    new_database,
    write_agentfile,
)
from tests.helpers.shifts import LATHE


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
    assert "start the agent, which writes it" in unknown.err
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

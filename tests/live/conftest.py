"""A lathe behind MTConnect, with its agent file and an empty database."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest
from asyncua.server.internal_server import InternalServer

from autodb.agent.ingest.inbox import Inbox
from autodb.agent.operate import running as agent_running
from autodb.proofs.machines.served.mtconnect import MtConnectServer
from tests.conftest import Cli
from tests.helpers.running_machine import (
    Running,
    new_database,
    running,
    write_agentfile,
)
from tests.helpers.shifts import LATHE


@pytest.fixture(scope="session", autouse=True)
def standard_space(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Make the thousands of nodes that every OPC UA server begins with once."""
    made = tmp_path_factory.mktemp("opcua") / "nodes"
    fill = InternalServer.load_standard_address_space

    async def load(server: InternalServer, shelf_file: Path | None = None) -> None:
        if made.exists():
            server.aspace.load(made)
        else:
            await fill(server, shelf_file)
            server.aspace.dump(made)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(InternalServer, "load_standard_address_space", load)
        yield


@pytest.fixture(autouse=True)
def settled(one_law: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have an inbox take files of an agent, which are whole when they appear, after 0.2 s; what
    comes of them is learnt by one law.
    """
    del one_law
    monkeypatch.setattr(agent_running, "Inbox", partial(Inbox, settled_s=0.2))


@pytest.fixture
def lathe(cli: Cli) -> Iterator[Running]:
    """Run a lathe behind MTConnect, with its agent file and an empty database."""
    del cli
    with running(MtConnectServer(LATHE)) as one:
        new_database(mill=False)
        write_agentfile(one.server, LATHE, protocol="mtconnect")
        yield one

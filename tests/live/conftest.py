"""A lathe behind MTConnect, with its agent file and an empty database."""

from collections.abc import Iterator
from functools import partial

import pytest

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


@pytest.fixture(autouse=True)
def settled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have an inbox take files of an agent, which are whole when they appear, after 0.2 s."""
    monkeypatch.setattr(agent_running, "Inbox", partial(Inbox, settled_s=0.2))


@pytest.fixture
def lathe(cli: Cli) -> Iterator[Running]:
    """Run a lathe behind MTConnect, with its agent file and an empty database."""
    del cli
    with running(MtConnectServer(LATHE)) as one:
        new_database(mill=False)
        write_agentfile(one.server, LATHE, protocol="mtconnect")
        yield one

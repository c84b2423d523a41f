"""A lathe behind MTConnect, with its agent file and an empty database."""

from collections.abc import Iterator

import pytest

from autodb.proofs.machines.served.mtconnect import MtConnectServer
from tests.conftest import Cli
from tests.helpers.running_machine import (
    Running,
    new_database,
    running,
    write_agentfile,
)
from tests.helpers.shifts import LATHE


@pytest.fixture
def lathe(cli: Cli) -> Iterator[Running]:
    """Run a lathe behind MTConnect, with its agent file and an empty database."""
    del cli
    with running(MtConnectServer(LATHE)) as one:
        new_database(mill=False)
        write_agentfile(one.server, LATHE, protocol="mtconnect")
        yield one

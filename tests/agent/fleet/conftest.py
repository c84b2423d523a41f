"""A database of machines that have learnt."""

from collections.abc import Iterator

import numpy as np
import pytest

from autodb.agent.operate.refreshing import refresh
from autodb.proofs.machines.lathe import fleets
from autodb.store import Store, open_store
from tests.conftest import Cli, Once
from tests.helpers import shops
from tests.helpers.virtual_fleet import CUTS, FLEET, MACHINES, OFF, PAIRS, SEED, URL


@pytest.fixture
def shop(cli: Cli, once: Once) -> Iterator[Store]:
    """Return a database of machines that have learnt, one with a calibration that is off."""

    def fill() -> None:
        assert cli("init").code == 0
        store = open_store(URL)
        rng = np.random.default_rng([SEED, 1])
        for name in shops.names(MACHINES):
            made = fleets.on_machine(rng, FLEET, PAIRS, gain=1.6 if name == OFF else 1.0)
            shops.add(store, name, made, cuts=CUTS, rng=rng)
            refresh(store, name)
        store.close()

    once(fill)
    store = open_store(URL)
    yield store
    store.close()

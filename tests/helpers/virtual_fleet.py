"""A drawn fleet of lathes, of which one has a calibration that is off."""

import numpy as np

from autodb.proofs.machines.lathe import fleets
from autodb.store import Store
from tests.helpers import shops

MACHINES, CUTS = 5, 6
URL = "sqlite:///autodb.sqlite3"
SEED = 3
FLEET = fleets.draw_fleet(np.random.default_rng(SEED), materials=3, tools=2)
FIRST, SECOND = FLEET.tools
PAIRS = [(material, FIRST) for material in FLEET.materials]
OFF = "lathe-2"
"""The machine whose calibration is off."""


def added(store: Store, name: str, pairs: list[tuple[str, str]], *, cuts: int) -> None:
    rng = np.random.default_rng([SEED, 2])
    shops.add(store, name, fleets.on_machine(rng, FLEET, pairs), cuts=cuts, rng=rng)

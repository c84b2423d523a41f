"""The machine of the sample's cuts, for tests of what a browser shows."""

from pathlib import Path

import pytest

from autodb.agent.answer.looking_up import PairReader
from autodb.store import Store


@pytest.fixture
def learnt(sampled: Path) -> Path:
    """Return a database whose machine has learnt a pair and has mismatches that wait."""
    return sampled


@pytest.fixture
def pair(store: Store) -> dict[str, str]:
    """Return the pair that was learnt."""
    with store.reading() as session:
        one = PairReader(session, "lathe-1").pairs()[0]
    return {"material": one.material, "tool": one.tool}

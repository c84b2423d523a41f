"""Versions that are built on each other are found by their ids, however many there are."""

from collections.abc import Iterator
from typing import Any

import pytest
from sqlalchemy import event

from autodb.agent.learn.learnt_from import excluded_cuts
from autodb.agent.rows.machines import add_machine
from autodb.agent.rows.posteriors import chain_ids, posterior_columns, resting_on
from autodb.files.machine import LATHE
from autodb.pairs.prior import any_metal
from autodb.store import Store, create_store, models, open_store
from tests.conftest import Cli

VERSIONS, FEW = 30, 12
"""Of a chain; what a pass asks, however long it is."""


@pytest.fixture
def store(cli: Cli) -> Iterator[Store]:
    """Return a store with a chain of versions, the 11th of which was built on the 5th."""
    del cli
    create_store("sqlite:///autodb.sqlite3")
    opened = open_store("sqlite:///autodb.sqlite3")
    add_machine(opened, "m", LATHE)
    with opened.writing() as session:
        tool = models.Tool(name="insert", kind="turning_insert")
        pair = models.Pair(material=models.Material(name="steel"), tool=tool)
        session.add(pair)
        session.flush()
        for version in range(1, VERSIONS + 1):
            before = None if version == 1 else 5 if version == 11 else version - 1
            columns: dict[str, Any] = posterior_columns(any_metal())
            made = models.CuttingParameters(
                id=version, machine_id=1, pair_id=pair.id, version=version, previous_id=before,
                **columns,
            )  # fmt: skip
            session.add(made)
            session.flush()
    yield opened
    opened.close()


def test_a_chain_is_a_version_and_those_it_was_built_on(store: Store) -> None:
    with store.reading() as session:
        newest = session.get_one(models.CuttingParameters, VERSIONS)
        branch = session.get_one(models.CuttingParameters, 8)
        chain = {*range(1, 6), *range(11, VERSIONS + 1)}
        assert set(session.scalars(chain_ids([newest]))) == chain
        assert set(session.scalars(chain_ids([newest, branch]))) == chain | {6, 7, 8}
        assert not session.scalars(chain_ids([])).all()


def test_what_rests_on_a_version_is_built_on_it(store: Store) -> None:
    with store.reading() as session:
        rows = resting_on(session, 1, models.CuttingParameters.id == 7)
        assert [row.id for row in rows] == [7, 8, 9, 10]
        rows = resting_on(session, 1, models.CuttingParameters.id == 5)
        assert [row.id for row in rows] == list(range(5, VERSIONS + 1))


def test_a_long_chain_asks_no_more_of_the_database(store: Store) -> None:
    """Each version holds a covariance: they are not read one by one."""
    asked: list[str] = []
    event.listen(store.engine, "before_cursor_execute", lambda *given: asked.append(given[2]))
    with store.reading() as session:
        assert excluded_cuts(session, 1, 1, upto=10**6) == []
        resting_on(session, 1, models.CuttingParameters.id == 7)
    assert 0 < len(asked) <= FEW

"""A person records an edge change, and the machine counts for how long each edge has cut."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from sqlalchemy import select

from autodb.agent.ingest.importing import import_file
from autodb.agent.operate.changed_edges import change_edge, edges_of_machine, undo_edge_change
from autodb.agent.operate.withdrawing import take_again, withdraw
from autodb.agent.rows.counted_edges import ages_s
from autodb.agent.rows.edges_in_use import conditions_in_use
from autodb.agent.rows.machines import add_machine
from autodb.agent.rows.recorded_edges import cut_before_s, edge_label
from autodb.agent.rows.refresh_cursor import basis_of
from autodb.errors import UnusableInput
from autodb.files.machine import LATHE
from autodb.pairs.engaged import CUTTING_TIME
from autodb.store import Store, create_store, head, migrate, models, open_store
from tests.conftest import Cli
from tests.helpers.servers import Server

MACHINE, TOOL = "lathe-1", "insert"
MORNING = "2026-03-02T06:00:00+00:00"
LASTS_S = 10.0
Ages = dict[float, float | None]


@pytest.fixture
def store(cli: Cli) -> Iterator[Store]:
    """Return the database of a lathe without recordings."""
    cli("init")
    cli("machine", "add", MACHINE)
    opened = open_store("sqlite:///autodb.sqlite3")
    yield opened
    opened.close()


def _table(first: int, count: int, **columns: object) -> pd.DataFrame:
    """Return cuts numbered from ``first``, a minute each from the start of their file."""
    k = np.arange(count)
    rows = {
        "cut": first + k, "t": 60.0 * k, "operation": "turn", "work.material": "steel",
        "tool": TOOL, "cutting.speed": 200.0, "cutting.feed": 0.1 + 0.001 * (first + k),
        "cutting.depth": 2.0, "force.z": 800.0 + first + k,
    }  # fmt: skip
    return pd.DataFrame({**rows, **{name.replace("__", "."): v for name, v in columns.items()}})


def _import(store: Store, name: str, table: pd.DataFrame, *, start: str | None = MORNING) -> int:
    """Import a table that says when it began; return its recording."""
    path = Path(name).with_suffix(".csv")
    table.to_csv(path, index=False)
    if start is not None:
        path.with_suffix(".toml").write_text(f'[recording]\nstart = "{start}"\n', encoding="utf-8")
    return import_file(store, path, machine=MACHINE).recording_id


def _ages(store: Store) -> Ages:
    """Return for how long the edge of each counting cut had cut before, by its number."""
    with store.reading() as session:
        cuts = session.scalars(
            select(models.Cut).where(models.Cut.superseded_at.is_(None)).order_by(models.Cut.id)
        ).all()
        return {cut.number: cut_before_s(cut) for cut in cuts}


def _edges(store: Store) -> dict[float, str | None]:
    with store.reading() as session:
        query = select(models.Cut).where(models.Cut.superseded_at.is_(None))
        return {cut.number: edge_label(cut) for cut in session.scalars(query)}


def _basis(store: Store) -> dict[str, object]:
    with store.reading() as session:
        return basis_of(session, session.get_one(models.Machine, 1))


LASTING: list[tuple[float | None, float | None]] = [(None, 5.0), (None, 7.0), (None, 1.0)]


@pytest.mark.parametrize(
    ("cuts", "before", "ages"),
    [
        (LASTING, None, [0.0, 5.0, 12.0]),
        ([(300.0, None), (310.0, None), (330.0, None)], None, [0.0, 10.0, 30.0]),
        ([(300.0, None), (310.0, None), (4.0, None)], None, [0.0, 10.0, 4.0]),
        ([(20.0, None), (30.0, None)], 500.0, [20.0, 30.0]),
        ([(20.0, None), (30.0, None)], 10.0, [0.0, 10.0]),
        ([(None, 5.0), (None, None), (None, 5.0), (None, 5.0)], None, [0.0, 5.0, None, None]),
        ([(None, 5.0), (90.0, None), (None, 5.0), (97.0, 2.0)], None, [0.0, 5.0, None, 12.0]),
        ([(None, None), (90.0, 2.0), (3.0, 2.0), (None, None)], None, [0.0, None, 3.0, 5.0]),
        ([], None, []),
    ],
)
def test_an_edge_is_as_old_as_its_counter_or_its_cuts_say(
    cuts: list[tuple[float | None, float | None]], before: float | None, ages: list[float | None]
) -> None:
    assert ages_s(cuts, before=before) == ages


def test_durations_are_added_up_from_the_change_on(store: Store) -> None:
    _import(store, "monday", _table(1, 6, cut__duration=LASTS_S))
    done = change_edge(store, MACHINE, TOOL, at="2026-03-02T06:02:00+00:00", by="Maria", why="worn")
    assert (done.cuts, done.already, done.taken_back) == (4, False, ())
    assert _ages(store) == {1: None, 2: None, 3: 0.0, 4: 10.0, 5: 20.0, 6: 30.0}
    edges = _edges(store)
    assert (edges[1], edges[3]) == (None, f"of 2026-03-02 06:02 ({done.number})")
    with store.reading() as session:
        (one,) = edges_of_machine(session, MACHINE).edges
        cuts = session.scalars(select(models.Cut).order_by(models.Cut.number)).all()
        assert conditions_in_use(cuts)[3][CUTTING_TIME] == 10.0
        assert CUTTING_TIME not in cuts[3].conditions
    assert (one.tool, one.by, one.why, one.cuts, one.cut_s) == (TOOL, "Maria", "worn", 4, 40.0)

    # What comes in later goes on from there, whichever material it is of
    more = _table(7, 2, cut__duration=LASTS_S).assign(**{"work.material": "brass"})
    _import(store, "tuesday", more, start="2026-03-03T06:00:00+00:00")
    assert {k: v for k, v in _ages(store).items() if k > 6} == {7: 40.0, 8: 50.0}


def test_a_local_time_without_a_zone_is_this_computers(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TZ", "Europe/Berlin")
    time.tzset()
    try:
        _import(store, "monday", _table(1, 3, cut__duration=LASTS_S))
        done = change_edge(store, MACHINE, TOOL, at="2026-03-02T07:01")
        assert (done.at, done.cuts) == ("2026-03-02T06:01:00+00:00", 2)
        assert change_edge(store, MACHINE, TOOL, at="2026-03-02T06:01Z").already
    finally:
        monkeypatch.delenv("TZ")
        time.tzset()


def test_a_counter_that_nobody_set_back_counts_from_the_change(store: Store) -> None:
    counter = 100.0 + LASTS_S * np.arange(6)
    _import(store, "monday", _table(1, 6, tool__cutting_time=counter))
    change_edge(store, MACHINE, TOOL, at="2026-03-02T06:02:00+00:00")
    assert _ages(store) == {1: 100.0, 2: 110.0, 3: 0.0, 4: 10.0, 5: 20.0, 6: 30.0}
    more = _table(7, 2, tool__cutting_time=[160.0, 175.0])
    _import(store, "tuesday", more, start="2026-03-03T06:00:00+00:00")
    assert {k: v for k, v in _ages(store).items() if k > 6} == {7: 40.0, 8: 55.0}


def test_a_counter_that_was_set_back_counts_as_it_is(store: Store) -> None:
    counter = [100.0, 110.0, 25.0, 35.0]  # cuts between were not logged
    _import(store, "monday", _table(1, 4, tool__cutting_time=counter))
    change_edge(store, MACHINE, TOOL, at="2026-03-02T06:02:00+00:00")
    assert _ages(store) == {1: 100.0, 2: 110.0, 3: 25.0, 4: 35.0}


def test_behind_a_cut_of_unknown_duration_no_age_is_known(store: Store) -> None:
    lasted = [LASTS_S, np.nan, LASTS_S, LASTS_S]
    change = "2026-03-02T05:00:00+00:00"
    _import(store, "monday", _table(1, 4, cut__duration=lasted))
    change_edge(store, MACHINE, TOOL, at=change)
    assert _ages(store) == {1: 0.0, 2: 10.0, 3: None, 4: None}
    change_edge(store, MACHINE, TOOL, at="2026-03-02T06:03:00+00:00")
    assert _ages(store) == {1: 0.0, 2: 10.0, 3: None, 4: 0.0}
    with store.reading() as session:
        found = edges_of_machine(session, MACHINE, every=True).edges
    assert [(one.cuts, one.cut_s) for one in found] == [(3, None), (1, LASTS_S)]


def test_without_a_start_cuts_were_made_when_they_came_in(store: Store) -> None:
    _import(store, "monday", _table(1, 2, cut__duration=LASTS_S), start=None)
    before = change_edge(store, MACHINE, TOOL)  # also within the same second
    assert before.cuts == 0
    _import(store, "tuesday", _table(3, 2, cut__duration=LASTS_S), start=None)
    assert _ages(store) == {1: None, 2: None, 3: 0.0, 4: 10.0}


def test_the_same_change_twice_is_there_already(store: Store) -> None:
    _import(store, "monday", _table(1, 2, cut__duration=LASTS_S))
    at = "2026-03-02T06:01:00+00:00"
    first = change_edge(store, MACHINE, TOOL, at=at)
    again = change_edge(store, MACHINE, TOOL, at=at)
    assert (again.number, again.cuts, again.already) == (first.number, 1, True)


def test_what_is_undone_is_as_it_was(store: Store) -> None:
    _import(store, "monday", _table(1, 6, cut__duration=LASTS_S))
    nothing = _ages(store)
    first = change_edge(store, MACHINE, TOOL, at="2026-03-02T06:01:00+00:00")
    one = _ages(store)
    second = change_edge(store, MACHINE, TOOL, at="2026-03-02T06:03:00+00:00")
    assert _ages(store) == {1: None, 2: 0.0, 3: 10.0, 4: 0.0, 5: 10.0, 6: 20.0}
    assert undo_edge_change(store, second.number).cuts == 3
    assert _ages(store) == one
    assert undo_edge_change(store, second.number).already
    undo_edge_change(store, first.number)
    assert _ages(store) == nothing
    with store.reading() as session:
        assert edges_of_machine(session, MACHINE).edges == []
        assert len(edges_of_machine(session, MACHINE, every=True).edges) == 2
    again = change_edge(store, MACHINE, TOOL, at="2026-03-02T06:01:00+00:00")
    assert (again.already, again.cuts) == (False, 5)


def test_cuts_that_come_late_are_counted_in_the_order_of_time(store: Store) -> None:
    change = "2026-03-01T05:00:00+00:00"
    _import(store, "first", _table(1, 1), start="2026-02-01T06:00:00+00:00")
    change_edge(store, MACHINE, TOOL, at=change)
    tuesday = _table(5, 2, cut__duration=LASTS_S)
    _import(store, "tuesday", tuesday, start="2026-03-03T06:00:00+00:00")
    _import(store, "monday", _table(3, 2, cut__duration=LASTS_S))
    assert _ages(store) == {1: None, 5: 20.0, 6: 30.0, 3: 0.0, 4: 10.0}


def test_withdrawn_cuts_have_cut_nothing(store: Store) -> None:
    _import(store, "first", _table(1, 1), start="2026-02-01T06:00:00+00:00")
    change_edge(store, MACHINE, TOOL, at="2026-03-01T05:00:00+00:00")
    monday = _import(store, "monday", _table(3, 2, cut__duration=LASTS_S))
    tuesday = _table(5, 2, cut__duration=LASTS_S)
    _import(store, "tuesday", tuesday, start="2026-03-03T06:00:00+00:00")
    before = _ages(store)
    assert before == {1: None, 3: 0.0, 4: 10.0, 5: 20.0, 6: 30.0}
    withdraw(store, MACHINE, monday, why="another lathe's")
    assert _ages(store) == {1: None, 5: 0.0, 6: 10.0}
    take_again(store, MACHINE, monday)
    assert _ages(store) == before


def test_what_is_only_explained_has_cut_nothing_until_it_is_imported(store: Store) -> None:
    _import(store, "first", _table(1, 1), start="2026-02-01T06:00:00+00:00")
    change_edge(store, MACHINE, TOOL, at="2026-03-01T05:00:00+00:00")
    path = Path("monday.csv")
    _table(3, 2, cut__duration=LASTS_S).to_csv(path, index=False)
    path.with_suffix(".toml").write_text(f'[recording]\nstart = "{MORNING}"\n', encoding="utf-8")
    import_file(store, path, machine=MACHINE, looked_at=True)
    assert _ages(store) == {1: None}
    import_file(store, path, machine=MACHINE)
    assert _ages(store) == {1: None, 3: 0.0, 4: 10.0}


def test_a_table_that_has_grown_is_the_same_table(store: Store) -> None:
    _import(store, "monday", _table(1, 4, cut__duration=LASTS_S))
    change_edge(store, MACHINE, TOOL, at="2026-03-02T06:01:00+00:00")
    grown = _table(1, 6, cut__duration=LASTS_S)
    grown.loc[2, "cut.duration"] = 15.0  # mended
    grown.to_csv("monday.csv", index=False)
    done = import_file(store, Path("monday.csv"), machine=MACHINE)
    assert (done.again, done.replaced, done.cuts) == (3, 1, 3)
    assert _ages(store) == {1: None, 2: 0.0, 3: 10.0, 4: 25.0, 5: 35.0, 6: 45.0}
    with store.reading() as session:
        content = set(session.scalars(select(models.Cut.content)))
    assert None not in content


def test_a_change_that_cuts_are_yet_to_come_of_has_nothing_examined_anew(
    store: Store, cli: Cli
) -> None:
    _import(store, "monday", _table(1, 4, cut__duration=LASTS_S))
    cli("refresh")
    basis = _basis(store)
    done = change_edge(store, MACHINE, TOOL)
    tuesday = _table(5, 2, cut__duration=LASTS_S)
    _import(store, "tuesday", tuesday, start=None)
    assert _ages(store) == {1: None, 2: None, 3: None, 4: None, 5: 0.0, 6: 10.0}
    assert _basis(store) == basis
    cli("refresh")

    # One in the past alters cuts that were examined; so does undoing it
    change_edge(store, MACHINE, TOOL, at="2026-03-02T06:02:00+00:00")
    assert _basis(store) == {**basis, "recounted": 1}
    undo_edge_change(store, done.number)
    assert _ages(store) == {1: None, 2: None, 3: 0.0, 4: 10.0, 5: 20.0, 6: 30.0}
    assert _basis(store) != {**basis, "recounted": 1}


Refusing = Callable[[Store], object]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda s: change_edge(s, MACHINE, "insrt"), "(did you mean insert?)"),
        (lambda s: change_edge(s, "lathe-2", TOOL), "no machine 'lathe-2'"),
        (lambda s: change_edge(s, MACHINE, TOOL, at="soon"), "time 'soon' is none"),
        (lambda s: change_edge(s, MACHINE, TOOL, at="0001-01-01T00:00+14:00"), "is none"),
        (lambda s: change_edge(s, MACHINE, TOOL, at="2999-01-01"), "is still to come"),
        (lambda s: undo_edge_change(s, 7), "there is no edge change 7"),
    ],
)
def test_what_cannot_be_is_refused(store: Store, change: Refusing, says: str) -> None:
    _import(store, "monday", _table(1, 2))
    with pytest.raises(UnusableInput) as refused:
        change(store)
    assert says in str(refused.value)
    with store.reading() as session:
        assert session.scalars(select(models.ChangedEdge)).all() == []


def test_a_machine_without_tools_has_no_edges(store: Store) -> None:
    with pytest.raises(UnusableInput, match="has no cuts of a tool"):
        change_edge(store, MACHINE, TOOL)


def test_a_server_counts_alike(
    server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    url = server.database()
    create_store(url)
    store = open_store(url)
    add_machine(store, MACHINE, LATHE)
    _import(store, "monday", _table(1, 4, cut__duration=LASTS_S))
    change = "2026-03-02T06:01:00+00:00"
    done = change_edge(store, MACHINE, TOOL, at=change)
    tuesday = _table(5, 2, tool__cutting_time=[70.0, 80.0])
    _import(store, "tuesday", tuesday, start="2026-03-03T06:00:00+00:00")
    assert _ages(store) == {1: None, 2: 0.0, 3: 10.0, 4: 20.0, 5: 30.0, 6: 40.0}
    with store.reading() as session:
        (one,) = edges_of_machine(session, MACHINE).edges
    assert (one.number, one.cuts, one.cut_s) == (done.number, 5, 40.0)
    assert undo_edge_change(store, done.number).cuts == 5
    store.close()
    migrate(url, "0021")
    migrate(url, head())

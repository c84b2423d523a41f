"""The same cuts are the same cuts, in whatever bytes and files they come."""

from pathlib import Path

import pandas as pd
import pytest
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.assets import kit
from autodb.store import migrate, models, open_store
from tests.conftest import Cli, Once

MACHINE = ("--machine", "lathe-1")
RECORDINGS = kit("sample_jobs") / "stepped_shaft" / "recordings"
CUTS = 16


@pytest.fixture(autouse=True)
def there(cli: Cli, once: Once) -> Cli:
    """Return a database with a lathe that knows sixteen cuts and one recording over time."""

    def make() -> None:
        cli("init")
        cli("machine", "add", "lathe-1", "--file", RECORDINGS.parent / "machine.toml")
        _week().to_csv("week.csv", index=False)
        _moves().to_csv("moves.csv", index=False)
        assert cli("import", "week.csv", "moves.csv", *MACHINE).code == 0

    once(make)
    return cli


def _week(first: int = 0, last: int = CUTS) -> pd.DataFrame:
    return pd.read_csv(RECORDINGS / "shop-week-1.csv").iloc[first:last]


def _moves() -> pd.DataFrame:
    return pd.read_csv(RECORDINGS / "air-moves.csv").iloc[:3000]


def _counted() -> tuple[int, int]:
    """Return how many recordings there are, and cuts that count."""
    store = open_store("sqlite:///autodb.sqlite3")
    try:
        with store.reading() as session:
            cuts = session.scalars(select(models.Cut).where(models.Cut.superseded_at.is_(None)))
            return len(session.scalars(select(models.StoredRecording)).all()), len(cuts.all())
    finally:
        store.close()


def _in_other_bytes(name: str) -> list[str]:
    text = Path(f"{name}.csv").read_text()
    Path(f"{name}-crlf.csv").write_bytes(text.replace("\n", "\r\n").encode())
    Path(f"{name}-line.csv").write_text(text + "\n")
    table = pd.read_csv(f"{name}.csv")
    table.to_parquet(f"{name}-table.parquet", index=False)
    table[table.columns[::-1]].to_csv(f"{name}-turned.csv", index=False)
    return [f"{name}-{how}" for how in ("crlf.csv", "line.csv", "table.parquet", "turned.csv")]


@pytest.mark.parametrize("name", ["week", "moves"])
def test_what_is_there_in_other_bytes_is_there(there: Cli, name: str) -> None:
    number = 1 + (name == "moves")
    for file in _in_other_bytes(name):
        said = there("import", file, *MACHINE)
        assert f"recording {number}: {file}: already there" in said.out
    assert _counted() == (2, CUTS)


def test_of_a_table_that_overlaps_the_new_cuts_count(there: Cli) -> None:
    _week(8, 24).to_csv("other.csv", index=False)
    said = there("import", "other.csv", *MACHINE).out
    assert "imported, 16 rows, 8 cuts, 8 more are there already" in said
    assert _counted() == (3, 24)
    Path("in").mkdir()
    _week(20, 30).to_csv("in/third.csv", index=False)
    assert "6 new cuts, 4 there already" in there("refresh", *MACHINE, "--inbox", "in").out
    assert _counted() == (4, 30)


def test_cuts_of_another_number_or_value_are_others(there: Cli) -> None:
    renumbered = _week().assign(cut=_week()["cut"] + 100)
    renumbered.to_csv("renumbered.csv", index=False)
    other = _week()
    other["z.current.range"] *= 1.0 + 1e-9
    other.to_csv("other.csv", index=False)
    there("import", "renumbered.csv", "other.csv", *MACHINE)
    assert _counted() == (4, 3 * CUTS)


def test_units_do_not_make_another_recording(there: Cli) -> None:
    moves = pd.read_csv("moves.csv")
    position = [str(name) for name in moves if str(name).endswith(".position")]
    for name in position:
        moves[name] /= 1000.0
    moves.to_csv("metres.csv", index=False)
    units = "".join(f'"{name}" = {{ column = "{name}", unit = "m" }}\n' for name in position)
    Path("metres.toml").write_text(f"[channels]\n{units}")
    assert "recording 2: metres.csv: already there" in there("import", "metres.csv", *MACHINE).out


def test_a_calibration_by_a_copy_is_one_by_what_is_there(there: Cli) -> None:
    table = pd.read_csv(RECORDINGS / "standard-cuts.csv")
    table.to_csv("standard.csv", index=False)
    table.to_parquet("copy.parquet", index=False)
    there("import", "standard.csv", *MACHINE)
    assert there("calibrate", "copy.parquet", *MACHINE).code == 0
    assert _counted()[0] == 3


def test_earlier_databases_know_their_cuts_again(there: Cli) -> None:
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        known = _contents(session)
    store.close()
    migrate("sqlite:///autodb.sqlite3", "0010")
    there("init")
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        assert _contents(session) == known
    store.close()
    assert "already there" in there("import", _in_other_bytes("week")[0], *MACHINE).out


def _contents(session: Session) -> list[object]:
    return [
        *session.scalars(select(models.Cut.content).order_by(models.Cut.id)),
        *session.scalars(
            select(models.StoredRecording.content).order_by(models.StoredRecording.id)
        ),
    ]

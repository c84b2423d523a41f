"""What all cuts of a pair show together is named, and excluded where it has to be: no cut alone."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from sqlalchemy import select

from autodb.agent.learn.learnt_from import excluded_cuts
from autodb.agent.rows.mismatches import IN_BAND, IN_HARDER
from autodb.proofs.machines.lathe.process import STEEL, TrueCut, mean_forces_N
from autodb.store import models, open_store
from tests.conftest import Cli

URL = "sqlite:///autodb.sqlite3"
SCATTER = np.array([0.05, 0.02, 0.05])
SLOW_M_MIN, FAST_M_MIN = (88.0, 105.0), (125.0, 250.0)
FILES, HARD = 5, 4
SIDE = '[tool]\nkind = "turning_insert"\nnose_radius_mm = 0.8\nkappa_deg = 93\n'


def _file(number: int, *, band: float, harder: float) -> str:
    """Return a file of ten cuts with fresh edges; two are slow, and take less by ``band``."""
    rng = np.random.default_rng([9, number])
    names = ("cut", "t", "operation", "work.material", "tool", "cutting.speed", "cutting.feed",
             "cutting.depth", "work.diameter", "tool.edge", "tool.cutting_time",
             "force.y", "force.z")  # fmt: skip
    rows = [",".join(names)]
    for k in range(10):
        speed = float(rng.uniform(*(SLOW_M_MIN if k < 2 else FAST_M_MIN)))
        feed, depth = float(rng.uniform(0.12, 0.3)), float(rng.uniform(1.0, 2.0))
        edge = f"E{number}-{k}"
        cut = TrueCut(speed, feed, depth, 60.0, "turn", edge, 0.0, 0.0, "bar")
        force = mean_forces_N(replace(STEEL, softening=0.0), cut) * harder
        force *= (1.0 + band if k < 2 else 1.0) * (1.0 + SCATTER * rng.standard_normal(3))
        stated: Sequence[Any] = (speed, feed, depth, 60.0, edge, 0.0, force[1], force[2])
        rows.append(",".join(map(str, (k + 1, 100.0 * k, "turn", "bar", "insert", *stated))))
    return "\n".join(rows) + "\n"


def _refreshed(cli: Cli, *, band: float, hard: int | None) -> str:
    """Return what the refresh of the last of some files said."""
    assert cli("init").code == 0
    assert cli("machine", "add", "lathe").code == 0
    said = ""
    for number in range(FILES):
        file = Path(f"file-{number}.csv")
        file.write_text(_file(number, band=band, harder=1.25 if number == hard else 1.0))
        file.with_suffix(".toml").write_text(SIDE)
        assert cli("import", file, "--machine", "lathe").code == 0
        said = cli("refresh", "--machine", "lathe").out
    return said


def _rows() -> list[tuple[str, str, dict[str, Any], float]]:
    store = open_store(URL)
    with store.reading() as session:
        found = [
            (row.term, row.status, dict(row.found_in or {}), row.parameters["size"]["value"])
            for row in session.scalars(select(models.Mismatch).order_by(models.Mismatch.id))
        ]
    store.close()
    return found


def _excluded() -> int:
    store = open_store(URL)
    with store.reading() as session:
        count = len(excluded_cuts(session, 1, 1, upto=10**9))
    store.close()
    return count


def test_slow_cuts_with_lower_forces_are_a_band_that_is_predicted_once_confirmed(cli: Cli) -> None:
    said = _refreshed(cli, band=-0.25, hard=None)
    assert "built_up_edge" in said
    bands = [one for one in _rows() if IN_BAND in one[2]]
    assert len(bands) == 1
    assert len(bands[0][2][IN_BAND]) >= 6
    number = 1 + next(k for k, one in enumerate(_rows()) if IN_BAND in one[2])
    assert "built_up_edge confirmed" in cli("mismatch", "confirm", number).out
    assert "built_up_edge" not in cli("refresh", "--machine", "lathe").out


def test_a_harder_file_is_named_excluded_and_learnt_once_rejected(cli: Cli) -> None:
    said = _refreshed(cli, band=0.0, hard=HARD)
    assert f"cuts 1 to 10 of file-{HARD}.csv take 2" in said
    (run,) = (one for one in _rows() if IN_HARDER in one[2])
    assert run[0] == "hard_spot"
    assert len(run[2][IN_HARDER]) == 10
    assert _excluded() == 10
    number = 1 + next(k for k, one in enumerate(_rows()) if IN_HARDER in one[2])
    assert cli("mismatch", "reject", number).code == 0
    assert cli("refresh", "--machine", "lathe").code == 0
    assert _excluded() == 0


def test_usual_files_are_neither(cli: Cli) -> None:
    _refreshed(cli, band=0.0, hard=None)
    assert [one for one in _rows() if one[2].keys() & {IN_BAND, IN_HARDER}] == []

"""A sensor whose gain changed is corrected from its cut on, once a person confirms it."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from numpy.testing import assert_allclose
from pyarrow import csv
from sqlalchemy import select

from autodb.proofs.machines.lathe.process import STEEL, TrueCut, mean_forces_N
from autodb.store import models, open_store
from tests.agent.operate.test_decided import kept
from tests.conftest import Cli, Once

pytestmark = pytest.mark.usefixtures("one_law")

URL = "sqlite:///autodb.sqlite3"
FACTOR = 1.2
BEGINS = 8
"""Cut of the second recording with which the spindle's current reads too high."""


def scaled(table: pa.Table, first: int) -> pa.Table:
    """Return a table whose spindle reads FACTOR too much above its air current from a row on."""
    late = np.arange(len(table)) >= first
    columns = {name: table[name].to_numpy() for name in table.column_names}
    air = columns["spindle.current.air"]
    over = columns["spindle.current.range"] - air
    columns["spindle.current.range"] = air + np.where(late, FACTOR, 1.0) * over
    return pa.table(columns)


@pytest.fixture
def shop(cli: Cli, sample_jobs: Path, once: Once) -> Cli:
    """Return the command line on a lathe whose spindle reads too high from some cut on."""

    def learn() -> None:
        recordings = sample_jobs / "stepped_shaft" / "recordings"
        week = csv.read_csv(recordings / "shop-week-1.csv")
        half = len(week) // 2
        csv.write_csv(week.slice(0, half), "before.csv")
        csv.write_csv(scaled(week.slice(half), BEGINS), "after.csv")
        cli("init")
        cli("machine", "add", "lathe-1")
        cli("import", recordings / "standard-cuts.csv", "--machine", "lathe-1")
        cli("calibrate", "--machine", "lathe-1")
        for name in ("before.csv", "after.csv"):
            cli("import", name, "--machine", "lathe-1")
            cli("refresh", "--machine", "lathe-1")

    once(learn)
    return cli


def forces_by_calibration() -> dict[int, dict[tuple[str, float], float]]:
    """Return force y of cuts by recording's name and number, by the calibration that sensed it."""
    store = open_store(URL)
    found: dict[int, dict[tuple[str, float], float]] = {}
    with store.reading() as session:
        for force in session.scalars(select(models.SensedForce)):
            if force.component == "y" and force.value_N is not None and force.calibration_id:
                name = Path(force.cut.recording.path).name, force.cut.number
                found.setdefault(force.calibration_id, {})[name] = force.value_N
    store.close()
    return found


def true_N(cuts: pa.Table) -> dict[float, float]:
    """Return the true force y of cuts of a table by their number."""
    found = {}
    for row in cuts.to_pylist():
        cut = TrueCut(
            row["cutting.speed"], row["cutting.feed"], row["cutting.depth"], row["work.diameter"],
            row["operation"], row["tool.edge"], row["tool.cutting_time"], 0.0, "steel bar",
        )  # fmt: skip
        found[float(row["cut"])] = float(mean_forces_N(STEEL, cut)[1])
    return found


def looked_up(cli: Cli) -> dict[str, Any]:
    done = cli(
        "lookup", "--machine", "lathe-1", "--material", "steel bar", "--tool", "carbide insert",
        "--diameter", 50, "--depth", 1.5, "--feed", 0.2, "--speed", 220, "--cutting-time", 0,
        "--json",
    )  # fmt: skip
    found: dict[str, Any] = json.loads(done.out)
    return found


def test_a_confirmed_gain_corrects_what_is_sensed_from_its_cut_on(shop: Cli) -> None:
    first = csv.read_csv("after.csv").slice(BEGINS, 1).to_pylist()[0]
    said = {
        "factor": {"value": FACTOR, "low": FACTOR - 0.02, "high": FACTOR + 0.02, "unit": "1"},
        "start": {"value": first["t"] - 1.0, "low": 0.0, "high": 0.0, "unit": "s"},
        "duration": {"value": 0.0, "low": 0.0, "high": 0.0, "unit": "s"},
    }
    before = looked_up(shop)
    number = kept("gain", recording="after.csv", parameters=said)
    done = shop("mismatch", "confirm", number, "--by", "Ann").out
    assert "force.y is divided by 1.2 ± 0.02 from recording 3 on" in done
    assert "carbide insert: version " in done

    # What was sensed before is as it was; from the cut on it is divided, and learnt
    old, new = (forces for _, forces in sorted(forces_by_calibration().items()))
    for (name, cut), value in new.items():
        late = name == "after.csv" and cut >= first["cut"]
        assert_allclose(value, old[name, cut] / (FACTOR if late else 1.0), rtol=1e-12)
    real = true_N(csv.read_csv("after.csv").slice(BEGINS))
    was, is_now = (
        np.array([forces["after.csv", cut] for cut in real]) / list(real.values())
        for forces in (old, new)
    )
    assert_allclose(was.mean(), FACTOR, atol=0.05)
    assert_allclose(is_now.mean(), 1.0, atol=0.05)
    force = looked_up(shop)["cut"]["force_y_N"]
    asked = TrueCut(220.0, 0.2, 1.5, 50.0, "turn", "unseen", 0.0, 0.0, "steel bar")
    assert force["low"] < mean_forces_N(STEEL, asked)[1] < force["high"]

    # Later recordings are sensed so too, and nothing of them is excluded for it
    week = csv.read_csv("after.csv")
    later = week.slice(BEGINS + 2, 6)
    later = later.set_column(
        later.column_names.index("t"), "t", pa.array(later["t"].to_numpy() + 1e6)
    )
    csv.write_csv(later, "later.csv")
    shop("import", "later.csv", "--machine", "lathe-1")
    assert "outliers" not in shop("refresh", "--machine", "lathe-1").out

    # It leads back, and taken back all is as it was
    assert "divided by 1.2 from recording 3 on" in shop("trace", "calibration", _newest()).out
    assert "it corrected calibration" in shop("trace", "mismatch", number).out
    assert "calibration of spindle version" in shop("mismatch", "show", number).out
    assert shop("doctor").code == 0
    assert (
        "calibration of spindle version 2 is taken back"
        in shop("mismatch", "reject", number, "--why", "the cable was loose").out
    )
    # With each usual cut since then the excluded one, not decided, widens a little less
    again = looked_up(shop)
    assert again["behind"] == before["behind"]
    for name in ("force_x_N", "force_y_N", "force_z_N"):
        assert again["cut"][name]["value"] == before["cut"][name]["value"]
        assert again["cut"][name]["high"] <= before["cut"][name]["high"]
    assert shop("doctor").code == 0


def test_a_recording_that_is_withdrawn_takes_its_correction_with_it(shop: Cli) -> None:
    said = {"factor": {"value": FACTOR, "low": 1.18, "high": 1.22, "unit": "1"}}
    shop("mismatch", "confirm", kept("gain", recording="after.csv", parameters=said))
    done = shop("withdraw", 3, "--why", "wrong bar", "--machine", "lathe-1")
    assert done.code == 0, done.err
    assert "calibration of spindle version 2" in done.out
    shown = shop("trace", "calibration", 3).out
    assert shop("doctor").code == 0
    assert "divided by" not in shown


def test_a_gain_that_states_no_factor_is_noted(shop: Cli) -> None:
    done = shop("mismatch", "confirm", kept("gain", recording="after.csv")).out
    assert "it is noted, no prediction changes: it states no factor, or no calibration" in done


def _newest() -> int:
    store = open_store(URL)
    with store.reading() as session:
        query = select(models.CalibrationVersion.id).order_by(models.CalibrationVersion.id.desc())
        number = session.scalars(query.limit(1)).one()
    store.close()
    return number

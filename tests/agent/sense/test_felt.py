"""Stored forces become readings: what a calibration's errors move, what is left out and said."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.operate.refreshing import refresh
from autodb.agent.rows.calibration_records import as_calibration
from autodb.agent.rows.recordings import cuts_as_table
from autodb.agent.sense.sensed import as_observed
from autodb.pairs.observed import CHIP
from autodb.sensing.ranges.forms import LAWS, CurrentForm, MeasuredCuts
from autodb.sensing.ranges.sensed_force import sense
from autodb.store import models, open_store
from tests.conftest import Cli

pytestmark = pytest.mark.usefixtures("one_law")

URL = "sqlite:///autodb.sqlite3"
COEFFICIENTS = {
    "line": [12.0, 200.0],
    "line-of-speed": [12.0, 200.0, 15.0],
    "power": [np.log(3.0), 1.2, np.log(1500.0)],
    "power-of-speed": [np.log(3.0), 1.2, np.log(1500.0), 0.1, 0.9],
    "magnetised": [np.log(1.2), 2.0],
    "magnetised-of-speed": [np.log(1.2), 1.5, 1.2, np.log(1500.0)],
}


def _sensed(rng: np.random.Generator, n: int) -> MeasuredCuts:
    return MeasuredCuts(
        current=rng.uniform(1.0, 6.0, n),
        feed_mm_s=rng.uniform(2.0, 9.0, n),
        speed_rpm=rng.uniform(800.0, 2400.0, n),
        feed_mm=rng.uniform(0.1, 0.4, n),
        depth_mm=rng.uniform(1.0, 2.5, n),
        temperature_C=rng.uniform(20.0, 40.0, n),
        air=rng.uniform(8.0, 14.0, n),
    )


def _coefficients(form: CurrentForm) -> np.ndarray:
    plain = COEFFICIENTS[form.kind.removesuffix("-warmed")]
    return np.array([*plain, 0.002] if form.kind.endswith("-warmed") else plain)


@pytest.mark.parametrize("form", LAWS, ids=lambda form: form.kind)
def test_shift_and_share_are_what_the_coefficients_errors_do(form: CurrentForm) -> None:
    """Without noise both make up the slopes; with it the share is of the force that is expected.

    A current read 10 % high moves neither what a gain's error is of, nor an offset's.
    """
    sensed = _sensed(np.random.default_rng(3), 6)
    coefficients = _coefficients(form)
    slopes, value = form.slopes(coefficients, sensed), form.value(coefficients, sensed)
    shift, share = form.moves(coefficients, slopes, value)
    assert_allclose(shift + share * value[:, None], slopes, rtol=1e-9)
    noisy = sensed.moved(0.1 * sensed.current)
    read = form.value(coefficients, noisy)
    shift, share = form.moves(coefficients, form.slopes(coefficients, noisy), read)
    scaled = (shift + share * value[:, None]) @ form.scaling(coefficients)
    assert_allclose(scaled, value, rtol=1e-9)
    if form.kind.startswith("magnetised"):  # k moves a torque near none by up to twice its share
        return
    plain = form.kind.startswith("line")
    assert_allclose(
        (shift + share * value[:, None])[:, : 2 if plain else 1],
        slopes[:, : 2 if plain else 1],
        rtol=1e-9,
    )


def test_a_law_of_the_sample_has_every_form() -> None:
    assert {form.kind.removesuffix("-warmed") for form in LAWS} == set(COEFFICIENTS)


@pytest.fixture
def learnt(standard_learnt: Cli) -> Iterator[Session]:
    """Give the database of a lathe that has learnt turning and facing."""
    del standard_learnt
    store = open_store(URL)
    with store.reading() as session:
        yield session
    store.close()


def test_errors_of_a_calibration_move_readings_as_sensing_them_anew_does(learnt: Session) -> None:
    """Coefficients a millionth up, the cuts sensed again: the readings move as said."""
    forces = list(
        learnt.scalars(
            select(models.SensedForce)
            .where(models.SensedForce.calibration_id.is_not(None))
            .where(models.SensedForce.value_N.is_not(None), models.SensedForce.component == "y")
            .order_by(models.SensedForce.cut_id)
        )
    )
    row = forces[0].calibration
    assert row is not None
    calibration = as_calibration(row)
    step = 1e-6 * calibration.coefficients
    table = cuts_as_table([f.cut for f in forces], path=Path("cuts.csv"))
    from dataclasses import replace

    moved = sense(table, replace(calibration, coefficients=calibration.coefficients + step)).force_N
    seen = as_observed(forces)
    assert seen.shift is not None
    place = [one.key for one in seen.shared].index(f"calibration {row.id}")
    columns = slice(sum(len(s.covariance) for s in seen.shared[:place]), None)
    said = (seen.shift + seen.common * seen.value[:, None])[:, columns][:, : len(step)] @ step
    assert_allclose(said, moved - seen.value, rtol=1e-4, atol=1e-9)


def test_a_measured_chip_is_a_reading_once(learnt: Session) -> None:
    """Of a cut whose chip was learnt before only the force that is new counts."""
    forces = list(
        learnt.scalars(select(models.SensedForce).where(models.SensedForce.value_N.is_not(None)))
    )[:6]
    for force in forces:
        force.cut.conditions = {**force.cut.conditions, "chip.thickness": 0.4}
    cuts = {force.cut_id for force in forces}
    seen = as_observed(forces)
    assert int((seen.quantity == CHIP).sum()) == len(cuts)
    assert not (as_observed(forces, known=cuts).quantity == CHIP).any()
    learnt.expire_all()


def test_cuts_that_say_too_little_are_left_out_and_named(cli: Cli, sample_jobs: Path) -> None:
    """A taper without its direction, an operation without a model."""
    source = (sample_jobs / "stepped_shaft" / "recordings" / "standard-cuts.csv").read_text("utf-8")
    lines = source.splitlines()
    lines[1] = lines[1].replace(",turn,", ",taper,", 1)
    lines[2] = lines[2].replace(",turn,", ",grinding,", 1)
    Path("cuts.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    cli("init")
    cli("machine", "add", "lathe-1")
    cli("import", "cuts.csv", "--machine", "lathe-1")
    cli("calibrate", "--machine", "lathe-1")
    store = open_store(URL)
    done = refresh(store, "lathe-1")
    store.close()
    assert any("taper without cutting.direction" in sentence for sentence in done.set_aside)
    assert any("operation 'grinding' has no model" in sentence for sentence in done.set_aside)
    ((_, version, cuts),) = done.versions
    assert (version, cuts) == (1, 30)

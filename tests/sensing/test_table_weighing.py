"""Mass and gain of a table dynamometer from rests: with and without its work, and a zero that
wanders.
"""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy import constants

from autodb.errors import UnusableInput
from autodb.records.tables import Recording
from autodb.sensing.table import weighing
from autodb.sensing.table.identify import BareMoves, identify_table
from autodb.sensing.table.kinematics import Kinematics
from autodb.sensing.table.model import TableModel
from autodb.sensing.table.weighing import Weighing, weigh

Array = NDArray[np.float64]

RATE_HZ, SENSOR_KG, WORK_KG = 200.0, 20.0, 10.1
GAINS = np.array([1.012, 1.006, 1.009])
TILTS_DEG = [
    (0.0, 0.0),
    (-60.0, 0.0),
    (0.0, 0.0),
    (-60.0, 90.0),
    (0.0, 0.0),
    (30.0, 45.0),
    (0.0, 0.0),
]


def _per_kg(a_deg: Array, c_deg: Array) -> Array:
    """Return what a kilogram adds (n, 3), P4 equations 1 and 5 written out."""
    a, c = np.radians(a_deg), np.radians(c_deg)
    weight = [np.sin(c) * np.sin(a), -np.cos(c) * np.sin(a), np.cos(a) - 1.0]
    return constants.g * np.column_stack(weight)


def _rests(mass_kg: float, tilts: list[tuple[float, float]], seed: int = 1) -> Recording:
    """Return a recording that rests 2 s in each tilt, moving for 1 s between them."""
    at = 3.0 * np.repeat(np.arange(len(tilts)), 2) + np.tile([0.0, 2.0], len(tilts))
    t = np.arange(0.0, at[-1], 1.0 / RATE_HZ)
    a, c = (np.interp(t, at, np.repeat([tilt[k] for tilt in tilts], 2)) for k in range(2))
    noise = 0.3 * np.random.default_rng(seed).standard_normal((3, len(t)))
    read = GAINS[:, None] * mass_kg * _per_kg(a, c).T + noise
    channels = {"t": t, "a.angle": a, "c.angle": c}
    channels |= {f"force.{axis}": read[k] for k, axis in enumerate("xyz")}
    return Recording(Path("rests.csv"), channels)


def test_a_weighed_work_tells_the_gain_from_the_mass() -> None:
    """Gains of 0.6 to 1.2 % are taken for 0.9 % of mass; 10.1 kg on and off tell them apart."""
    work = _rests(SENSOR_KG + WORK_KG, TILTS_DEG)
    alone = identify_table([work], Kinematics())
    assert alone.mass_kg > 1.007 * (SENSOR_KG + WORK_KG)
    bare = BareMoves([_rests(SENSOR_KG, TILTS_DEG, 2)], WORK_KG)
    found = identify_table([work], Kinematics(), bare=bare)
    assert_allclose(found.mass_kg, SENSOR_KG + WORK_KG, rtol=0.002)
    assert_allclose(np.diag(found.matrix), GAINS, atol=0.002)
    assert found.mass_sd_kg < 0.5 * alone.mass_sd_kg
    assert found.gain_sd < 0.5 * alone.gain_sd
    assert TableModel.of_json(found.to_json()).gain_sd == found.gain_sd
    assert "work_kg" not in alone.to_json()


def test_a_mass_is_no_surer_than_the_scale() -> None:
    """Without noise what is left is the scale's 0.1 %, and the prior of the gain beside it."""
    tilted = _per_kg(
        np.array([-60.0, 0.0, 30.0, -60.0, 0.0]), np.array([0.0, 0.0, 45.0, 90.0, 0.0])
    )
    at, same = np.arange(5.0), np.zeros(5, dtype=np.intp)
    both = [
        Weighing(tilted, (SENSOR_KG + WORK_KG - less) * tilted, at, at + 0.5, same, less)
        for less in (0.0, WORK_KG)
    ]
    mass, _, covariance = weigh(both)
    assert_allclose(mass, SENSOR_KG + WORK_KG, rtol=1e-6)
    share = np.sqrt(covariance[0, 0]) / mass
    assert 0.0008 < share <= weighing.WEIGHED_SD


def test_a_zero_that_wanders_is_weighed_as_what_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rests 4 s apart err alike by 8 s: with that the mass of 60 draws errs by a tenth less."""
    a = np.array([0.0, -60.0] * 8 + [0.0])
    tilted = _per_kg(a, np.linspace(0.0, 90.0, len(a)))
    at: Array = np.arange(0.0, 4.0 * len(a), 4.0)
    rng = np.random.default_rng(3)
    root = np.linalg.cholesky(np.exp(-np.abs(at[:, None] - at) / 8.0))
    wander = 1.5 * np.einsum("ij,djk->dik", root, rng.standard_normal((60, len(a), 3)))
    same = np.zeros(len(a), dtype=np.intp)

    def rms() -> float:
        masses = [
            weigh([Weighing(tilted, 30.0 * tilted + w, at, at + 1.0, same)])[0] for w in wander
        ]
        return float(np.sqrt(np.mean((np.array(masses) - 30.0) ** 2)))

    ours = rms()
    monkeypatch.setattr(weighing, "FORGETS_S", (0.0,))
    assert ours < 0.9 * rms()


def test_a_recording_for_each_rest_is_as_good() -> None:
    apart = [_rests(SENSOR_KG + WORK_KG, [tilt, tilt], k) for k, tilt in enumerate(TILTS_DEG)]
    found = identify_table(apart, Kinematics())
    assert_allclose(found.mass_kg, GAINS.mean() * (SENSOR_KG + WORK_KG), rtol=0.004)


def test_what_tells_no_gain_is_refused() -> None:
    work = _rests(SENSOR_KG + WORK_KG, TILTS_DEG)
    with pytest.raises(UnusableInput, match="the work weighs 0 kg"):
        identify_table([work], Kinematics(), bare=BareMoves([work], 0.0))
    level = _rests(SENSOR_KG, [(0.0, 0.0), (0.0, 0.0)])
    with pytest.raises(UnusableInput, match="never rests tilted"):
        identify_table([work], Kinematics(), bare=BareMoves([level], WORK_KG))

"""Beyond what a calibration was made with its interval grows by forms nearly as good."""

import csv
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.fitting.gaussian import NORMAL_95
from autodb.records.tables import CutTable
from autodb.sensing.ranges.calibration import Calibration, calibrate
from autodb.sensing.ranges.choosing import TriedForm
from autodb.sensing.ranges.domain import form_weights
from autodb.sensing.ranges.forms import LINE, LINE_OF_SPEED
from autodb.sensing.ranges.sensed_force import left_domain, sense
from tests.conftest import Cli
from tests.helpers.campaigns import first

Array = NDArray[np.float64]
Gain = Callable[[Array], Array]

INSIDE, BELOW = (60.0, 420.0), (5.0, 30.0)
"""Feed speeds, mm/min, of the faces that an axis is calibrated on, and of tapers made later."""
TAPERS = 10


def steady(_feed_mm_min: Array) -> Array:
    """Return a gain that no speed changes, N/A."""
    return np.full_like(_feed_mm_min, 200.0)


def creeping(feed_mm_min: Array) -> Array:
    """Return the gain of a screw that loses a quarter at creep, N/A: no line in the logarithm."""
    return 200.0 * (1.0 - 0.25 * np.exp(-feed_mm_min / 150.0))


def cuts(seed: int, count: int, feed_mm_min: tuple[float, float], gain: Gain) -> CutTable:
    """Return cuts of x, force and rise of current, by a gain of no form that is fitted."""
    rng = np.random.default_rng(seed)
    speed = np.exp(rng.uniform(np.log(feed_mm_min[0]), np.log(feed_mm_min[1]), count))
    force, feed = rng.uniform(80.0, 400.0, count), rng.choice([0.1, 0.15, 0.2, 0.3], count)
    rise = force / gain(speed) + rng.normal(0.0, 0.05, count)
    channels = {
        "cut": np.arange(1.0, count + 1.0), "force.x": force, "spindle.speed": speed / feed,
        "cutting.feed": feed, "cutting.depth": rng.uniform(0.5, 1.0, count),
        "x.current.air": np.full(count, 5.0), "x.current.range": 5.0 + rise,
    }  # fmt: skip
    return CutTable(path=Path("x.csv"), channels=channels, texts={"operation": ["taper"] * count})


def sd_N(table: CutTable, by: Calibration) -> Array:
    """Return the whole standard deviation of each sensed force (n,)."""
    sensed = sense(table, by)
    shared = np.einsum("ij,jk,ik->i", sensed.common, by.shared_covariance, sensed.common)
    return np.asarray(np.hypot(sensed.sd_N, np.sqrt(shared)))


def held(table: CutTable, by: Calibration) -> int:
    """Return how many 95 % intervals hold the force."""
    off = np.abs(sense(table, by).force_N - table["force.x"])
    return int(np.sum(off < NORMAL_95 * sd_N(table, by)))


@pytest.mark.parametrize(("gain", "axes"), first(1, [(creeping, 30), (creeping, 60), (steady, 60)]))
def test_tapers_at_other_speeds_are_held(gain: Gain, axes: int) -> None:
    """Axes calibrated on 12 faces each, 10 tapers slower than any: 90 % or more of all."""
    inside, bare, wide = 0, 0, 0
    for seed in range(axes):
        found = calibrate(cuts(seed, 12, INSIDE, gain), "x")
        tapers = cuts(1000 + seed, TAPERS, BELOW, gain)
        wide += held(tapers, found)
        bare += held(tapers, replace(found, domain=None))
        inside += held(cuts(2000 + seed, TAPERS, (80.0, 300.0), gain), found)
    assert wide >= 0.90 * axes * TAPERS
    assert inside >= 0.90 * axes * TAPERS
    if gain is creeping:
        assert bare < 0.80 * axes * TAPERS, "the form that was taken is wrong there"


def test_within_the_range_nothing_grows() -> None:
    for seed in range(20):
        made = cuts(seed, 12, INSIDE, creeping)
        found = calibrate(made, "x")
        assert_allclose(sd_N(made, found), sd_N(made, replace(found, domain=None)), rtol=1e-12)
        assert left_domain(made, found)[0] == 0


def test_the_error_beyond_is_one_that_all_cuts_share() -> None:
    """It is in what all rows share, so that many tapers do not average it away."""
    found = calibrate(cuts(1, 12, INSIDE, creeping), "x")
    tapers = cuts(1001, TAPERS, BELOW, creeping)
    sensed, bare = sense(tapers, found), sense(tapers, replace(found, domain=None))
    assert_allclose(sensed.sd_N, bare.sd_N)
    assert np.all(sensed.common[:, -1] > 0.0)


def test_a_current_in_counts_has_its_range_in_counts() -> None:
    domain = calibrate(cuts(1, 12, INSIDE, creeping), "x").domain
    assert domain is not None
    amperes, counts = (" ".join(domain.each("N", unit)) for unit in ("A", "raw"))
    assert " A " in amperes
    assert counts == amperes.replace(" A ", " raw ")


def test_it_says_what_it_was_not_calibrated_with() -> None:
    found = calibrate(cuts(1, 12, INSIDE, creeping), "x")
    count, said = left_domain(cuts(1001, TAPERS, BELOW, creeping), found)
    assert count == TAPERS
    assert said.startswith("outside the calibrated range: feed speed ")
    assert " mm/min" in said
    assert found.domain is not None
    low, high = (60.0 * end for end in found.domain.ranges["feed_mm_s"])
    assert 60.0 <= low < 110.0
    assert 300.0 < high <= 420.0


def test_weights_follow_the_error_on_groups_left_out() -> None:
    rng = np.random.default_rng(1)
    errors = rng.normal(0.0, 1.0, 40)
    trials = [TriedForm(LINE, errors), TriedForm(LINE_OF_SPEED, rng.permutation(errors))]
    groups = np.arange(40)
    alike = form_weights(trials, groups)
    assert_allclose(alike.sum(), 1.0)
    assert_allclose(alike, 0.5, atol=0.25)
    worse = form_weights([TriedForm(LINE, 2.0 * errors), trials[1], TriedForm(LINE, None)], groups)
    assert worse[0] < 0.05
    assert worse[2] == 0.0


JOB = """name = "taper"
material = "steel"
tool = "insert"
[[cut]]
operation = "taper"
diameter_mm = 50
end_diameter_mm = 40
length_mm = 9
depth_mm = 1.0
feed_mm_rev = 0.15
speed_m_min = 150
"""


def _written(path: Path, seed: int, feed_mm_min: tuple[float, float], *, force: bool) -> Path:
    table = cuts(seed, 24, feed_mm_min, creeping)
    names = [n for n in table.channels if force or not n.startswith("force")]
    with path.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(
            [
                *names,
                "t",
                "operation",
                "work.material",
                "tool",
                "work.diameter",
                "cutting.direction",
            ]
        )
        for k in range(24):
            known = [float(table[name][k]) for name in names]
            rows.writerow([*known, 60.0 * k, "taper", "steel", "insert", 50.0, 30.0])
    return path


def test_a_machine_says_so_and_a_trace_too(cli: Cli, tmp_path: Path) -> None:
    faces = _written(tmp_path / "faces.csv", 1, INSIDE, force=True)
    tapers = _written(tmp_path / "tapers.csv", 2, BELOW, force=False)
    for command in ("init", "machine add lathe-1"):
        assert cli(*command.split()).code == 0
    assert cli("import", faces, "--machine", "lathe-1").code == 0
    assert "calibrated range: feed speed" in cli("calibrate", "--machine", "lathe-1").out
    assert "outside" not in cli("refresh", "--machine", "lathe-1").out
    assert cli("import", tapers, "--machine", "lathe-1").code == 0
    done = " ".join(cli("refresh", "--machine", "lathe-1").out.split())
    assert "new cuts are outside the calibrated range: feed speed" in done
    assert "their intervals are wider" in done
    traced = [
        " ".join(cli("trace", "force", str(number)).out.split()) for number in range(1, 121, 7)
    ]
    outside = [one for one in traced if "N outside the calibrated range: feed speed" in one]
    assert outside
    assert all("tapers.csv" in one for one in outside)

    # What is predicted from these forces says so too
    job = tmp_path / "job.toml"
    job.write_text(JOB, encoding="utf-8")
    notes = json.loads(cli("predict", job, "--machine", "lathe-1", "--json").out)["notes"]
    (note,) = [one for one in notes if "beyond the cuts that calibration 1" in one]
    assert "(axis x version 1)" in note
    assert "'autodb trace parameters" in note

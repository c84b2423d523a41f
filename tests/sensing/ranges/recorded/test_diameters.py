"""X that is logged as a diameter is named, in facing, between passes and in a table."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from autodb.errors import UnusableInput
from autodb.proofs.machines.lathe.jobs import cut_at
from autodb.proofs.machines.lathe.lathe import Lathe
from autodb.proofs.machines.lathe.phases import raw_cut
from autodb.proofs.machines.lathe.process import STEEL
from autodb.records.tables import Recording
from autodb.sensing.ranges import faults
from autodb.sensing.ranges.faults.travel import pass_steps_mm
from autodb.sensing.ranges.recorded import raw
from tests.helpers.lathe_tables import SEEDS, lathe_cuts, side_of, with_channels


def faced(seed: int) -> Recording:
    rng = np.random.default_rng([seed, 80])
    feed_mm, speed_rpm = float(rng.uniform(0.1, 0.25)), float(rng.uniform(800, 2000))
    cut = cut_at((0.75, feed_mm, speed_rpm, 60.0), operation="face", duration_s=2.0)
    made = raw_cut(Lathe.draw(seed), STEEL, cut, seed, True)
    return Recording(path=Path("a.csv"), channels=made, side=side_of("face", 0.75, feed_mm))


def as_diameter(recording: Recording) -> Recording:
    doubled = {"x.position": 2.0 * recording["x.position"]}
    return replace(recording, channels={**recording.channels, **doubled})


def test_x_as_a_diameter_is_named_in_facing() -> None:
    for seed in SEEDS:
        sound = faced(seed)
        assert raw.cut_of_recording(sound).table["cutting.feed"] > 0
        with pytest.raises(UnusableInput, match=r"a\.csv: x moves by 2 times the feed, as if X"):
            raw.cut_of_recording(as_diameter(sound))


def test_a_velocity_alone_tells_a_diameter() -> None:
    sound = faced(SEEDS[0])
    channels = dict(sound.channels)
    velocity = np.gradient(channels.pop("x.position"), sound.t_s)
    for factor, passed in ((1.0, True), (2.0, False)):
        made = replace(sound, channels={**channels, "x.velocity": factor * velocity})
        (check,) = faults.x_travels(made, slice(2500, 4000))
        assert check.passed == passed


def passes(depth_mm: float, seed: int) -> Recording:
    """Three passes of turning: z feeds 8 mm, x steps out, z returns, x steps in by the depth."""
    rng = np.random.default_rng([seed, 81])
    radius = 30.0 - depth_mm * np.arange(3)
    z, x = [], []
    for r in radius:
        z += [np.linspace(8.0, 0.0, 2400), np.full(200, 0.0), np.linspace(0.0, 8.0, 200)]
        x += [np.full(2400, r), np.linspace(r, r + 2.0, 200), np.full(200, r + 2.0)]
    z_mm, x_mm = np.concatenate(z), np.concatenate(x)
    channels = {
        "t": 0.001 * np.arange(len(z_mm)),
        "x.position": x_mm + 0.001 * rng.standard_normal(len(x_mm)),
        "z.position": z_mm,
        "spindle.speed": np.full(len(z_mm), 1000.0),
    }
    return Recording(path=Path("a.csv"), channels=channels, side=side_of("turn", depth_mm, 0.2))


def test_x_as_a_diameter_is_named_between_passes() -> None:
    for seed in SEEDS:
        sound = passes(0.5 + 0.1 * (seed % 20), seed)
        assert all(check.passed for check in faults.x_travels(sound, slice(0, 2400)))
        (check,) = faults.x_travels(as_diameter(sound), slice(0, 2400))
        assert not check.passed
        assert "x.position steps between passes by 2 times the depth" in check.sentence
        assert "diameter = true under [recording]" in check.sentence


def test_one_pass_has_no_step() -> None:
    sound = passes(1.0, 1)
    one = replace(sound, channels={n: v[:2400] for n, v in sound.channels.items()})
    assert pass_steps_mm(one, 0.2 * 1000 / 60).size == 0


def test_x_as_a_diameter_is_named_in_a_table() -> None:
    for seed in SEEDS:
        table = lathe_cuts(seed)
        radius = 0.5 * table["work.diameter"] + 12.0
        sound = with_channels(table, x__position=radius)
        assert faults.x_over_diameter(sound)[0].passed
        (check,) = faults.x_over_diameter(with_channels(table, x__position=2.0 * radius))
        assert not check.passed

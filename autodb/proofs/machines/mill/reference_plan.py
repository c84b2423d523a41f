"""P0's plan of recorded cuts on a reference mill: 181 combinations, of which 21 are kept for tests.

P0 (LSTM and model-based force reconstruction), Table 1: depth 1 to 4 mm, width 1 to 10 mm, feed 300
to 800 mm/min, 2600 to 6000 rpm; section 2.3: 181 combinations that cut undisturbed, 160 recorded
for training and 21 for tests; section 3: slots, sides, ramps and circular pockets, among the tests
sides of different parameters, one of them semi-stable, ramps, pockets counterclockwise. Which ones
they are is not printed: *chosen*, as are directions, days and the dynamometer's errors. The plan is
one for all mills.
"""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy import signal

from autodb.proofs.machines.lathe.process import Array
from autodb.proofs.machines.mill.reference_cuts import MillCut
from autodb.proofs.machines.mill.reference_mill import (
    TRUTH_HZ,
    TRUTH_ORDER,
    MillAxis,
    RecordedMilledCut,
    mill_cut,
)
from autodb.proofs.machines.mill.reference_mill_moves import AXES, RATE_HZ
from autodb.proofs.machines.mill.reference_milling import C45, TEETH, TeethLaw

DEPTHS_MM = (1.0, 2.0, 3.0, 4.0)  # P0 Table 1, as the next two and the widths
FEEDS_MM_MIN = (300.0, 400.0, 500.0, 700.0, 800.0)
SPEEDS_RPM = (2600.0, 3500.0, 4500.0, 5400.0, 6000.0)
RECESSED = 0.3  # of the slots; chosen
FEED_MM = (0.012, 0.05)  # per tooth, that cuts undisturbed; chosen
DAYS = 4  # on which the plan was cut; chosen
NOISE_N = 2.0  # of the dynamometer with its amplifier; chosen
GAIN_SD = 0.005  # of it from day to day; Kistler 9257B states linearity within 1 %; chosen


@dataclass(frozen=True)
class PlannedCut:
    """A combination of the plan: its number, its cut, the day, and whether it is for tests."""

    number: int
    cut: MillCut
    day: int
    test: bool


@dataclass(frozen=True)
class Kind:
    """A kind of cut: how many there are and how many of them are for tests.

    ``section_mm2``: from where to where chip sections of a pass cut undisturbed, or, of semi-stable
    sides, nearly so; ``slant_deg``: directions are its multiples.
    """

    operation: str
    count: int
    tests: int
    widths_mm: tuple[float, ...]
    section_mm2: tuple[float, float]
    slant_deg: float = 15.0
    shaking: bool = False


KINDS = (  # chosen
    Kind("slot", 46, 6, (10.0,), (10.0, 30.0)),
    Kind("side", 72, 7, (1.0, 2.0, 4.0, 5.0, 7.0), (4.0, 16.0)),
    Kind("side", 9, 2, (4.0, 5.0), (16.0, 20.0), slant_deg=90.0, shaking=True),
    Kind("ramp", 18, 2, (10.0,), (10.0, 20.0)),
    Kind("pocket", 36, 4, (2.0, 4.0, 5.0, 7.0), (4.0, 15.0)),
)


def _plan() -> tuple[PlannedCut, ...]:
    rng = np.random.default_rng(181)
    drawn: list[tuple[MillCut, bool]] = []
    for kind in KINDS:
        drawn += [(cut, k < kind.tests) for k, cut in enumerate(_combinations(rng, kind))]
    days = rng.permutation(len(drawn)) % DAYS
    return tuple(
        PlannedCut(number, replace(cut, name=f"{number}: {cut.operation}"), int(day), test)
        for number, ((cut, test), day) in enumerate(zip(drawn, days, strict=True))
    )


def _combinations(rng: np.random.Generator, kind: Kind) -> list[MillCut]:
    low, high = kind.section_mm2
    every = [
        one
        for one in product(DEPTHS_MM, kind.widths_mm, FEEDS_MM_MIN, SPEEDS_RPM)
        if low <= one[0] * one[1] <= high and FEED_MM[0] <= one[2] / (TEETH * one[3]) <= FEED_MM[1]
    ]
    return [_cut(rng, kind, every[k]) for k in rng.permutation(len(every))[: kind.count]]


def _cut(rng: np.random.Generator, kind: Kind, one: tuple[float, float, float, float]) -> MillCut:
    depth, width, feed, speed = one
    slants = round(360.0 / kind.slant_deg)
    direction, up, recessed = rng.integers(0, slants), rng.random() < 0.3, rng.random() < RECESSED
    return MillCut(
        name="",
        operation="recessed slot" if kind.operation == "slot" and recessed else kind.operation,
        depth_mm=depth,
        width_mm=width,
        feed_mm_min=feed,
        speed_rpm=speed,
        direction_deg=float(kind.slant_deg * direction),
        up=bool(up) and kind.operation == "side",
        shaking=kind.shaking,
    )


@dataclass(frozen=True)
class RecordedCut:
    """A cut of the plan as it was recorded: 14 channels of the control, and the dynamometer.

    ``force_N`` (3, n): what it measured, the force of the work on the tool in machine axes, low-
    passed as P0 does; ``true_N`` (3, n) what it was.
    """

    planned: PlannedCut
    made: RecordedMilledCut
    force_N: Array
    true_N: Array

    @property
    def channels(self) -> dict[str, Array]:
        """The 14 channels (n,) that the control logs, by name; P0 section 2.3."""
        found: dict[str, Array] = {}
        for name, axis in self.made.axes.items():
            found |= {
                f"{name}.position": axis.motion.x,
                f"{name}.velocity": axis.motion.v,
                f"{name}.acceleration": axis.motion.a,
                f"{name}.current": axis.current_A,
            }
        return found | {
            "spindle.speed": self.made.spindle_rpm,
            "spindle.current": self.made.spindle_A,
        }


def record_planned(
    seed: int, mill: dict[str, MillAxis], planned: PlannedCut, work: TeethLaw = C45
) -> RecordedCut:
    """Record a cut of the plan on the mill of a seed."""
    day = 1000 * seed + 1 + planned.day
    made = mill_cut(day, mill, planned.number, planned.cut, work)
    true_N = -np.array([made.load_N[name] for name in AXES])
    gain = 1.0 + GAIN_SD * np.random.default_rng([day, 85]).standard_normal(3)
    rng = np.random.default_rng([day, 86, planned.number])
    noisy = gain[:, None] * true_N + NOISE_N * rng.standard_normal(true_N.shape)
    b, a = signal.butter(TRUTH_ORDER, TRUTH_HZ, fs=RATE_HZ)
    return RecordedCut(planned, made, np.asarray(signal.filtfilt(b, a, noisy, axis=1)), true_N)


PLAN_181 = _plan()
TRAINING = tuple(one for one in PLAN_181 if not one.test)
TESTS = tuple(one for one in PLAN_181 if one.test)

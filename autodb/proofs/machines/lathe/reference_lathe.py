"""Reference lathes: machines of P1's kind, its calibration cuts and its test cuts.

P1 (autonomous machining database, current sensing), sections 6, 9, 10 and table 1: calibrated on
mild steel in longitudinal turning and facing, tested on mild steel, brass and an aluminium alloy
with tapers and contours as well; depth 1-2.5 mm, feed 0.1-0.4 mm/rev, 800-2400 rpm. Which cuts
exactly is not printed: they are drawn.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.lathe import cut_table_of
from autodb.proofs.machines.lathe.machine import Lathe
from autodb.proofs.machines.lathe.process import ALUMINIUM, BRASS, STEEL, TrueCut, TruePair

Table = dict[str, NDArray[Any]]

STEEPEST_DEG = 20.0  # profile angles; the printed range is garbled, chosen
FACED_DEPTH_MM = (0.5, 1.0)  # shallow: weight holds the X load only up to 258 N (P1 table 1)
FACED_FEED_MM = (0.1, 0.25)  # so too
CUTS_AN_EDGE = 12  # chosen
DURATION_S, PAUSE_S = 8.0, 45.0  # chosen
DIAMETER_MM = (40.0, 75.0)  # chosen
TESTED = (STEEL, BRASS, ALUMINIUM)  # P1 section 10, three materials


@dataclass(frozen=True)
class LathePlan:
    """How many cuts to calibrate and to test with: turned and faced, and of both together those
    that count for the spindle; ``tapered`` of the turned test cuts are tapers.
    """

    name: str
    turned: tuple[int, int]
    faced: tuple[int, int]
    spindle: tuple[int, int]
    tapered: int
    stream: int


# P1 table 1: Z's, X's, the spindle's cuts; "a limited number" of tapers, chosen
REGRESSION = LathePlan("regression", (105, 180), (13, 16), (102, 113), tapered=30, stream=61)
# P1 table 1, the cuts of its ANFIS; none of X is printed, the faced ones are chosen
RULES = LathePlan("ANFIS", (240, 63), (13, 40), (103, 100), tapered=10, stream=62)


@dataclass(frozen=True)
class Campaign:
    """What was recorded on one machine: cuts to calibrate with, and cuts to test on.

    ``spindle`` (n,) of each says which cuts count for the spindle.
    """

    calibration: Table
    test: Table
    spindle_calibration: NDArray[np.bool_]
    spindle_test: NDArray[np.bool_]


def campaign(seed: int, plan: LathePlan = REGRESSION) -> Campaign:
    """Draw a machine, its cuts, and what it measured; the test is on another day."""
    lathe, rng = Lathe.draw(seed), np.random.default_rng([seed, plan.stream])
    tables, counted = [], []
    for day, pairs in enumerate(((STEEL,), TESTED)):
        work = _work(rng, pairs, day, plan)
        tables.append(cut_table_of(lathe, work, 2 * seed + day, True, pause_s=PAUSE_S))
        chosen = rng.permutation(len(work))[: plan.spindle[day]]
        counted.append(np.isin(np.arange(len(work)), chosen))
    return Campaign(tables[0], tables[1], counted[0], counted[1])


def _work(
    rng: np.random.Generator, pairs: Sequence[TruePair], day: int, plan: LathePlan
) -> list[tuple[TruePair, TrueCut]]:
    """Cuts in random order, each with the pair it is of."""
    tapered = plan.tapered * day
    operations = [
        *["turn"] * (plan.turned[day] - tapered),
        *["taper"] * tapered,
        *["face"] * plan.faced[day],
    ]
    drawn = []
    for number, place in enumerate(rng.permutation(len(operations))):
        pair = pairs[int(rng.integers(len(pairs)))]
        drawn.append((pair, _cut(rng, pair, operations[place], number)))
    return drawn


def _cut(rng: np.random.Generator, pair: TruePair, operation: str, number: int) -> TrueCut:
    """A cut at conditions drawn evenly over P1's."""
    faced = operation == "face"
    speed_rpm, diameter_mm = rng.uniform(800.0, 2400.0), rng.uniform(*DIAMETER_MM)
    return TrueCut(
        speed_m_min=math.pi * diameter_mm * speed_rpm / 1000.0,
        feed_mm=rng.uniform(*(FACED_FEED_MM if faced else (0.1, 0.4))),
        depth_mm=rng.uniform(*(FACED_DEPTH_MM if faced else (1.0, 2.5))),
        diameter_mm=diameter_mm,
        operation=operation,
        tool_edge=f"edge-{number // CUTS_AN_EDGE + 1}",
        cutting_time_s=number % CUTS_AN_EDGE * DURATION_S,
        duration_s=DURATION_S,
        material=pair.work,
        inward_deg=rng.uniform(2.0, STEEPEST_DEG) if operation == "taper" else 0.0,
    )

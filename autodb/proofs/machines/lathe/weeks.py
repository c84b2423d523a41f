"""Weeks of a lathe: ten files of 30 cuts of three pairs, and what happens in a shop meanwhile.

Edges wear and are changed, one of them without anybody writing it down; one pair has a band of
cutting speed with a built-up edge; one bar is of a harder melt; the drive of one axis comes to show
6 % more current for a force. Forces, currents and the calibration programme are those of the
virtual lathe (``process``, ``drives``, ``jobs``), of inserts with a nose (``noses``). What has no
source here is *chosen*, before anything was judged on it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.drives import spindle_share
from autodb.proofs.machines.lathe.jobs import production_cuts, standard_cuts
from autodb.proofs.machines.lathe.lathe import cut_row, cut_table_of
from autodb.proofs.machines.lathe.machine import Lathe
from autodb.proofs.machines.lathe.noses import with_nose
from autodb.proofs.machines.lathe.process import (
    Array,
    TrueCut,
    TruePair,
    flank_wear_mm,
    mean_forces_N,
)

BATCHES, IN_BATCH = 10, 30
PAIRS = ("steel bar", "tough steel", "brass")
TOOLS = ("carbide insert", "coated insert", "polished insert")
EXPECTED = (  # tangential and feed force of the reference cut, N, as in ``process``
    (810.0, 420.0),
    (950.0, 520.0),
    (430.0, 170.0),
)
SPREAD = 0.10  # of a pair's forces around that
CUT_S = (40.0, 110.0)  # how long a cut takes
CHANGED_MM = (0.16, 0.30)  # flank wear at which an edge is changed
PAUSE_S = 60.0
SLOWEST_RPM = 800.0

BUILT_UP = 1  # the pair whose slow cuts have a built-up edge
BAND_M_MIN = (85.0, 110.0)  # between these, its flanks beside
FLANK_M_MIN = 8.0
BAND_CUTS = 2  # of a batch's ten, from the third batch on
RAKE_GAIN = (0.18, 0.30)  # share by which a built-up edge lowers forces
FROM_BATCH = 2

HARDER = (0.15, 0.30)
HARD_BATCHES = (4, 8)
DRIFT = 0.06
DRIFT_BATCHES = (4, 7)  # the first batch in which an axis shows more, and that which ends the range
DRIFT_OVER = 2  # batches over which it comes
AXES = ("z", "spindle")
COMPONENT = {"z": "z", "spindle": "y"}
CONDITIONS = ("fresh edge", "worn edge", "built-up edge", "hard batch", "drifted axis")
WORN_MM = 0.1  # flank wear from which on an edge counts as worn
UNRECORDED_AFTER = 3  # batches before the edge change that nobody writes down


@dataclass(frozen=True)
class WeekCut:
    """A cut as it was (``true``, of a pair by its place) and as the shop wrote it down.

    ``foreseeable_N``: the mean force x, y, z, had nothing begun in its own file that no file before
    shows: a harder bar, the first cuts of a built-up edge, the new edge that nobody wrote down.
    """

    pair: int
    true: TrueCut
    edge: str
    cutting_time_s: float
    condition: str
    force_N: tuple[float, float, float]
    foreseeable_N: tuple[float, float, float]


@dataclass(frozen=True)
class ShopFile:
    """A file of cuts: its rows, and what each of them was."""

    table: dict[str, NDArray[Any]]
    cuts: tuple[WeekCut, ...]


@dataclass(frozen=True)
class Weeks:
    """A shop's weeks: the table its lathe is calibrated with, and its batches.

    ``drifts``: the axis, its first batch and by what share; ``hard``: pair and batch;
    ``unrecorded``: pair, and number of the cut of that pair, from 1, that began with a new edge.
    """

    seed: int
    calibration: dict[str, NDArray[Any]]
    batches: tuple[ShopFile, ...]
    drifts: tuple[str, int, float]
    hard: tuple[int, int]
    unrecorded: tuple[int, int]


@dataclass(frozen=True)
class _Shop:
    """Pairs of a shop with their edges in use, and by what factors on forces its weeks differ."""

    pairs: Sequence[TruePair]
    edges: "Sequence[_Edges]"
    hard: tuple[int, int]
    harder: float
    lower: float

    def factor(self, pair: int, batch: int, speed_m_min: float) -> float:
        """Return the factor on a cut's forces."""
        harder = self.harder if (pair, batch) == self.hard else 1.0
        return harder * (self.lower if _is_built_up(pair, speed_m_min) else 1.0)

    def foreseeable(self, pair: int, batch: int, speed_m_min: float) -> float:
        """Return the factor that files before show."""
        shown = batch > FROM_BATCH and _is_built_up(pair, speed_m_min)
        return self.lower if shown else 1.0


def draw_weeks(seed: int) -> Weeks:
    """Draw the weeks of a seed; the same seed gives the same numbers."""
    rng = np.random.default_rng([73, seed])
    lathe = Lathe.draw(seed)
    pairs = _pairs(rng)
    axis = str(rng.choice(AXES))
    began, sign = int(rng.integers(*DRIFT_BATCHES)), float(rng.choice([-1.0, 1.0]))
    hard = int(rng.integers(len(pairs))), int(rng.integers(*HARD_BATCHES))
    factors = 1.0 + rng.uniform(*HARDER), 1.0 - rng.uniform(*RAKE_GAIN)
    unrecorded = int(rng.integers(len(pairs)))
    edges = [_Edges(rng, pair, unrecorded=k == unrecorded) for k, pair in enumerate(pairs)]
    shop = _Shop(pairs, edges, hard, *factors)
    batches = []
    for number in range(BATCHES):
        now = _drifted(lathe, axis, DRIFT * sign * min(max(number - began + 1, 0) / DRIFT_OVER, 1))
        batches.append(_batch(seed, number, now, shop, drifted=number >= began))
    standard = [(with_nose(pairs[0], cut), cut) for cut in standard_cuts()]
    return Weeks(
        seed=seed,
        calibration=cut_table_of(lathe, standard, seed, dynamometer=True),
        batches=tuple(batches),
        drifts=(axis, began, DRIFT * sign),
        hard=hard,
        unrecorded=(unrecorded, edges[unrecorded].unrecorded_at),
    )


def _batch(seed: int, number: int, lathe: Lathe, shop: _Shop, *, drifted: bool) -> ShopFile:
    """Make the cuts of a batch with edges that go on, and what the lathe shows of them."""
    rows, cuts = [], []
    start_s = 0.0
    for place, (k, cut) in enumerate(_planned(seed, number), start=1):
        used = shop.edges[k].next(cut.duration_s, batch=number)
        true = replace(cut, tool_edge=used.made[0], cutting_time_s=used.made[1], material=PAIRS[k])
        shown = replace(true, tool_edge=used.shown[0], cutting_time_s=used.shown[1])
        where = k, number, true.speed_m_min
        share = spindle_share(lathe.spindle, seed, start_s + 0.5 * cut.duration_s)
        pair = with_nose(_scaled(shop.pairs[k], shop.factor(*where)), true)
        ranges, force = cut_row(lathe, pair, true, seed=(seed, 7, number, place), share=share)
        usual = with_nose(_scaled(shop.pairs[k], shop.foreseeable(*where)), shown)
        rows.append(_row(place, start_s, true, k, used.written) | ranges)
        worn = flank_wear_mm(shop.pairs[k], *used.made) > WORN_MM
        states = (_is_built_up(k, true.speed_m_min), (k, number) == shop.hard, drifted, worn)
        names = ("built-up edge", "hard batch", "drifted axis", "worn edge")
        named = [name for name, holds in zip(names, states, strict=True) if holds]
        x_N, y_N, z_N = (lathe.work_factor * mean_forces_N(usual, shown)).tolist()
        cuts.append(
            WeekCut(k, true, *used.written, (named or ["fresh edge"])[0],
                    (force["force.x"], force["force.y"], force["force.z"]), (x_N, y_N, z_N))
        )  # fmt: skip
        start_s += cut.duration_s + PAUSE_S
    return ShopFile({name: np.array([row[name] for row in rows]) for name in rows[0]}, tuple(cuts))


def _pairs(rng: np.random.Generator) -> list[TruePair]:
    """Draw the three pairs around what a shop would expect."""
    found = []
    for work, tool, (tangential, feed) in zip(PAIRS, TOOLS, EXPECTED, strict=True):
        along, across = np.exp(SPREAD * rng.standard_normal(2))
        found.append(
            TruePair(
                work, tool, tangential * float(along), feed * float(across),
                life_s=float(rng.uniform(1200.0, 2000.0)),
                worn_tangential=float(rng.uniform(0.25, 0.5)),
                worn_thrust=float(rng.uniform(0.5, 0.9)),
            )
        )  # fmt: skip
    return found


@dataclass(frozen=True)
class _UsedEdge:
    """Name and cutting time, s, of an edge before a cut: as it was ``made``, as ``written`` down,
    and as the files before the cut's own show it.
    """

    made: tuple[str, float]
    written: tuple[str, float]
    shown: tuple[str, float]


class _Edges:
    """The edges of one pair's tool: used, worn, changed, and what is written down of them."""

    def __init__(self, rng: np.random.Generator, pair: TruePair, *, unrecorded: bool) -> None:
        self._rng, self._pair, self._number, self._used_s = rng, pair, 1, 0.0
        self._written, self._written_s = 1, 0.0
        self._until_mm = float(rng.uniform(*CHANGED_MM))
        self._leaves_out, self.unrecorded_at, self._cuts = unrecorded, 0, 0
        self._unseen, self._unseen_s = -1, 0.0

    def next(self, duration_s: float, *, batch: int) -> _UsedEdge:
        """Return the edge before a cut that it then makes."""
        self._cuts += 1
        if flank_wear_mm(self._pair, self._name(self._number), self._used_s) > self._until_mm:
            if self._leaves_out and not self.unrecorded_at and batch >= UNRECORDED_AFTER:
                self.unrecorded_at, self._unseen, self._unseen_s = self._cuts, batch, self._used_s
            else:
                self._written, self._written_s, self._unseen = self._written + 1, 0.0, -1
            self._number, self._used_s = self._number + 1, 0.0
            self._until_mm = float(self._rng.uniform(*CHANGED_MM))
        made = (self._name(self._number), self._used_s)
        written = (self._name(self._written), round(self._written_s, 1))
        shown = made
        if batch == self._unseen:  # nobody knows yet that it was changed
            shown = (self._name(self._number - 1), self._unseen_s + self._used_s)
        self._used_s += duration_s
        self._written_s += duration_s
        return _UsedEdge(made, written, shown)

    def _name(self, number: int) -> str:
        return f"{self._pair.work[:1].upper()}{number}"


def _planned(seed: int, batch: int) -> list[tuple[int, TrueCut]]:
    """Return a batch's cuts, pair after pair in a drawn order, their edges left open."""
    rng = np.random.default_rng([74, seed, batch])
    found = []
    each = IN_BATCH // len(PAIRS)
    for k in rng.permutation(len(PAIRS)):
        cuts = production_cuts(int(rng.integers(2**31)), ("",), each, *CUT_S)
        if k == BUILT_UP:
            cuts = [_clear_of_band(rng, cut) for cut in cuts]
        if k == BUILT_UP and batch >= FROM_BATCH:
            for place in rng.choice(each, BAND_CUTS, replace=False):
                cuts[place] = _at_speed(cuts[place], float(rng.uniform(*BAND_M_MIN)))
        found += [(int(k), cut) for cut in cuts]
    return found


def _is_built_up(pair: int, speed_m_min: float) -> bool:
    low, high = BAND_M_MIN
    return pair == BUILT_UP and low <= speed_m_min <= high


def _clear_of_band(rng: np.random.Generator, cut: TrueCut) -> TrueCut:
    """Return a cut at a speed beside the band, some on its slow flank."""
    low, high = BAND_M_MIN
    if cut.speed_m_min > high + FLANK_M_MIN:
        return cut
    slow = cut.speed_m_min < low
    speed = rng.uniform(low - 3.0 * FLANK_M_MIN, low - FLANK_M_MIN) if slow else high + FLANK_M_MIN
    return _at_speed(cut, float(speed))


def _at_speed(cut: TrueCut, speed_m_min: float) -> TrueCut:
    """Return a cut at another speed, on a diameter at which no spindle speed is too slow."""
    most_mm = 1000.0 * speed_m_min / (math.pi * SLOWEST_RPM)
    return replace(cut, speed_m_min=speed_m_min, diameter_mm=min(cut.diameter_mm, most_mm))


def _drifted(lathe: Lathe, axis: str, share: float) -> Lathe:
    """Return a lathe one of whose drives shows by a share more of a force than it did."""
    if axis == "z":
        return replace(lathe, z=replace(lathe.z, force_per_A_N=lathe.z.force_per_A_N / (1 + share)))
    spindle = lathe.spindle
    return replace(
        lathe, spindle=replace(spindle, torque_per_A_Nm=spindle.torque_per_A_Nm / (1.0 + share))
    )


def _scaled(pair: TruePair, factor: float) -> TruePair:
    return replace(pair, tangential_N=factor * pair.tangential_N, feed_N=factor * pair.feed_N)


def _row(
    number: int, start_s: float, cut: TrueCut, pair: int, recorded: Sequence[Any]
) -> dict[str, Any]:
    """Return what the shop writes down of a cut."""
    return {
        "cut": number,
        "t": round(start_s, 1),
        "operation": cut.operation,
        "work.material": PAIRS[pair],
        "tool": TOOLS[pair],
        "spindle.speed": cut.spindle_rpm,
        "cutting.speed": cut.speed_m_min,
        "cutting.feed": cut.feed_mm,
        "cutting.depth": cut.depth_mm,
        "work.diameter": cut.diameter_mm,
        "tool.edge": recorded[0],
        "tool.cutting_time": recorded[1],
    }


def forces_made(batch: ShopFile) -> Array:
    """Return the forces x, y, z that a batch's cuts really had (n, 3), N."""
    return np.array([cut.force_N for cut in batch.cuts])


def forces_foreseeable(batch: ShopFile) -> Array:
    """Return the mean forces x, y, z that files before let one expect of a batch (n, 3), N."""
    return np.array([cut.foreseeable_N for cut in batch.cuts])

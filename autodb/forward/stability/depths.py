"""Of a planned cut: to what depth it is stable at its speed, and which speeds near it are better.

How the law's numbers, its error in the operation and the receptance may be off makes the interval:
they are drawn, and the limit's logarithm is taken as normal.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.regenerating import directional_stiffness
from autodb.errors import UnusableInput
from autodb.files.job_cut import KEYS, JobCut
from autodb.fitting.gaussian import NORMAL_95, root_of
from autodb.forward.limits import probability_words
from autodb.forward.prediction import Interval, ToolOf, chance_above
from autodb.forward.stability.dynamics import ToolPoint
from autodb.forward.stability.lobes import Loop, limit_at, lines_for, loop_of
from autodb.pairs.engaged import BANDS, BY_NAME, RPM
from autodb.pairs.observed import PairCuts
from autodb.pairs.posterior import OWN, PairPosterior
from autodb.wording import amount_words, listed, localized, phrase, shop_amount, stored_msgid

Array = NDArray[np.float64]

DRAWS, SEED = 60, 1995
"""Chosen: the interval's ends then scatter by 10 % of its width."""
REACH = (0.5, 2.0)
"""Speeds around the planned one over which limits are given, of it."""
NEAR = (0.75, 1.33)
"""Speeds among which better ones are looked for."""
SPEEDS = 241
MOST_MM = 1000.0
"""A deeper limit is none."""
SHALLOW = 0.25
"""Width over diameter below which chatter with half the tooth frequency may come first (Davies et
al. 2002; Insperger et al. 2003): not in the zero-order limit."""


@dataclass(frozen=True)
class BetterSpeed:
    """A spindle speed near the planned one with the deepest stable cut there."""

    speed_rpm: float
    depth_mm: Interval


@dataclass(frozen=True)
class StableDepth:
    """Of one cut: the depth from which on it chatters at its speed, or None: at no depth.

    ``chance`` that the planned depth chatters; ``chatter_Hz`` at the limit; ``any_speed_mm``: the
    depth below which no speed chatters; ``better``: speeds near, the deepest first. ``speeds_rpm``
    with ``limit_mm``, and their ``low_mm`` and ``high_mm``: the lobes, None where none limits.
    """

    name: str
    operation: str
    speed_rpm: float
    planned_mm: float
    depth_mm: Interval | None
    chance: float
    chatter_Hz: float | None
    any_speed_mm: Interval
    better: tuple[BetterSpeed, ...]
    notes: tuple[str, ...]
    speeds_rpm: tuple[float, ...]
    limit_mm: tuple[float | None, ...]
    low_mm: tuple[float | None, ...]
    high_mm: tuple[float | None, ...]

    @property
    def words(self) -> str:
        """Say to what depth it is stable."""
        if self.depth_mm is None:
            limit = phrase("stable at any depth")
        else:
            limit = phrase(
                "stable up to {depth}, chatter at {frequency}; {chance} chance that it chatters",
                depth=depth_words(self.depth_mm),
                frequency=amount_words(self.chatter_Hz or 0.0, "Hz", ".0f"),
                chance=probability_words(self.chance),
            )
        near = self.better_words
        return phrase(
            "cut '{name}', {planned} deep at {speed}: {limit}; at any speed up to {least}{better}",
            name=self.name or self.operation,
            planned=amount_words(self.planned_mm, "mm", ".3g"),
            speed=amount_words(self.speed_rpm, "rpm", ".0f"),
            limit=limit,
            least=depth_words(self.any_speed_mm),
            better=phrase("; near it {better}", better=listed(near)) if near else "",
        )

    @property
    def better_words(self) -> list[str]:
        """Say the better speeds, each with its depth, the deepest first."""
        return [
            phrase(
                "{depth} at {speed}",
                depth=depth_words(one.depth_mm),
                speed=amount_words(one.speed_rpm, "rpm", ".0f"),
            )
            for one in self.better
        ]


def depth_words(one: Interval) -> str:
    """Say a depth and its interval, in the reader's unit."""
    low, high = (localized(f"{shop_amount(end, 'mm')[0]:.3g}") for end in (one.low, one.high))
    value = amount_words(one.value, "mm", ".3g")
    return phrase("{value} ({low} to {high})", value=value, low=low, high=high)


@dataclass(frozen=True)
class _Asked:
    """A cut, its elements, and the tool point, on lines close enough for its slowest speed."""

    posterior: PairPosterior
    cuts: PairCuts
    point: ToolPoint
    depth_mm: float
    teeth: int

    def loop(self, theta: Array, factors: Array, compliance: Array) -> Loop:
        """Return the limits for a law, factors on it along and across, and on each receptance."""
        along, across = factors.tolist()
        (stiffness,) = directional_stiffness(theta, self.cuts.elements, along=along, across=across)
        return loop_of(stiffness, self.point.frequency_Hz, compliance * self.point.receptance)

    def periods_s(self, speeds_rpm: Array) -> Array:
        """Return tooth periods."""
        return 60.0 / (self.teeth * speeds_rpm)


def stable_depth(
    posterior: PairPosterior,
    tool: ToolOf,
    cut: JobCut,
    point: ToolPoint,
    *,
    fastest_rpm: float | None = None,
) -> StableDepth:
    """Return to what depth a cut is stable.

    The chip keeps the shape that it has at the planned depth. ``fastest_rpm``: no better speed is
    beyond. Raises UnusableInput for a cut that has no depth, or where no axis that gives way moves
    its chip.
    """
    if "depth_mm" not in KEYS[cut.operation].needs or cut.depth_mm is None:
        raise UnusableInput(
            phrase("operation '{operation}' has no depth that lobes limit", operation=cut.operation)
        )
    conditions = cut.conditions(tool.diameter_mm)
    planned_rpm = conditions[RPM]
    speeds = np.geomspace(REACH[0] * planned_rpm, REACH[1] * planned_rpm, SPEEDS)
    teeth = int(tool.numbers["teeth"]) if cut.operation in BANDS else 1
    every, receptance = lines_for(
        point.frequency_Hz, point.receptance, 60.0 / (teeth * float(speeds[0]))
    )
    asked = _Asked(
        posterior=posterior.also(posterior.law_errors(cut.operation)),
        cuts=BY_NAME[cut.operation].cuts(tool.numbers, [conditions], called=tool.name),
        point=ToolPoint(point.source, every, receptance, point.share),
        depth_mm=cut.depth_mm,
        teeth=teeth,
    )
    return _answered(asked, cut, planned_rpm, speeds, fastest_rpm)


def _answered(
    asked: _Asked, cut: JobCut, planned_rpm: float, speeds: Array, fastest_rpm: float | None
) -> StableDepth:
    known = asked.posterior
    loop = asked.loop(known.state.mean[:OWN], np.ones(2), np.ones(3))
    if loop.critical * asked.depth_mm > MOST_MM:
        raise UnusableInput(
            phrase(
                "{source}: no axis that it states moves the chip of operation '{operation}' off "
                "the surface; state the axes across its edge",
                source=asked.point.source,
                operation=cut.operation,
            )
        )
    tried = np.concatenate([[planned_rpm], speeds])
    scale, chatter = limit_at(loop, asked.periods_s(tried))
    scale = np.where(scale * asked.depth_mm > MOST_MM, np.inf, scale)
    spread = _spread(asked, tried, scale, loop.critical)
    low, high = (scale * np.exp(sign * NORMAL_95 * spread[1:]) for sign in (-1.0, 1.0))
    here = None if np.isinf(scale[0]) else _around(scale[0] * asked.depth_mm, spread[1])
    lobes = [_finite(asked.depth_mm * one[1:]) for one in (scale, low, high)]
    allowed = (speeds >= NEAR[0] * planned_rpm) & (speeds <= NEAR[1] * planned_rpm)
    allowed &= speeds <= (fastest_rpm or np.inf)
    return StableDepth(
        name=cut.name,
        operation=cut.operation,
        speed_rpm=planned_rpm,
        planned_mm=asked.depth_mm,
        depth_mm=here,
        chance=0.0 if here is None else 1.0 - chance_above(here, asked.depth_mm),
        chatter_Hz=None if here is None else float(chatter[0]),
        any_speed_mm=_around(loop.critical * asked.depth_mm, spread[0]),
        better=_better(
            speeds,
            scale[1:],
            spread[2:],
            here=float(scale[0]),
            depth_mm=asked.depth_mm,
            allowed=allowed,
        ),
        notes=tuple(_notes(cut, asked)),
        speeds_rpm=tuple(speeds.tolist()),
        limit_mm=lobes[0],
        low_mm=lobes[1],
        high_mm=lobes[2],
    )


def _spread(asked: _Asked, speeds_rpm: Array, scale: Array, critical: float) -> Array:
    """Return standard deviations of the logarithm of the critical scale, then of those at speeds.

    Where a draw closes no loop at a speed, or the middle does not, it counts for nothing there.
    """
    rng = np.random.default_rng(SEED)
    known = asked.posterior
    law = root_of(known.state.covariance)
    error = known.columns(known.law_error(asked.cuts.operation).key).start
    off = np.zeros((DRAWS, len(scale) + 1))
    for k in range(DRAWS):
        state = known.state.mean + law @ rng.standard_normal(law.shape[1])
        compliance = np.exp(asked.point.share * rng.standard_normal(3))
        loop = asked.loop(state[:OWN], 1.0 + state[error : error + 2], compliance)
        found = np.concatenate([[loop.critical], limit_at(loop, asked.periods_s(speeds_rpm))[0]])
        middle = np.concatenate([[critical], scale])
        both = np.isfinite(found) & np.isfinite(middle)
        off[k, both] = np.log(found[both] / middle[both])
    return np.asarray(np.sqrt(np.mean(off**2, axis=0)))


def _finite(values: Array) -> tuple[float | None, ...]:
    return tuple(one if np.isfinite(one) else None for one in values.tolist())


def _around(value: float, spread: float) -> Interval:
    factor = exp(NORMAL_95 * spread)
    return Interval(float(value), float(value) / factor, float(value) * factor)


def _better(
    speeds: Array,
    scale: Array,
    spread: Array,
    *,
    here: float,
    depth_mm: float,
    allowed: NDArray[np.bool_],
) -> tuple[BetterSpeed, ...]:
    """Return the tops of lobes that are allowed and deeper than the planned speed's limit."""
    inner = np.where(np.isfinite(scale), scale, MOST_MM / depth_mm)
    top = np.zeros(len(speeds), dtype=np.bool_)
    top[1:-1] = (inner[1:-1] >= inner[:-2]) & (inner[1:-1] > inner[2:])
    ends = np.flatnonzero(allowed)
    if len(ends):
        top[ends[[0, -1]]] |= inner[ends[[0, -1]]] >= np.max(inner[ends])
    places = np.flatnonzero(top & allowed & (inner > 1.05 * here))
    deepest = sorted(places.tolist(), key=lambda k: -float(inner[k]))[:2]
    return tuple(
        BetterSpeed(float(speeds[k]), _around(inner[k] * depth_mm, spread[k])) for k in deepest
    )


def _notes(cut: JobCut, asked: _Asked) -> Sequence[str]:
    if cut.operation not in BANDS or cut.width_mm is None:
        return ()
    if cut.width_mm >= SHALLOW * 2.0 * float(np.max(asked.cuts.elements.radius_mm)):
        return ()
    return (
        stored_msgid(
            "engaged over a small part of a turn, it may chatter with half the tooth frequency at "
            "other depths; that is not in these limits"
        ),
    )

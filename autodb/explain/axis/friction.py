"""Candidates that are friction of an axis, or change it."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from autodb.explain.axis.signals import AxisSignals
from autodb.explain.engine.candidates import (
    Candidate,
    CandidateForm,
    PartOfLaw,
    grid_forms,
    has_positive_first,
    negative,
    spline,
    swings,
)
from autodb.explain.engine.normal import solved_together
from autodb.terms.friction import backlash, presliding, stribeck
from autodb.terms.vocabulary import friction_terms
from autodb.terms.warming import warmth

Array = NDArray[np.float64]

WARM_TIMES_S = (3.0, 8.0, 20.0, 50.0, 120.0, 300.0, 1000.0, 4000.0)
FINER = 30
DRY = frozenset({"coulomb"})
"""What a dip of friction, or its course after a reversal, is a part of."""
OVER_SPEED = frozenset({"coulomb", "viscous", "speed"})
"""Terms, and the family without a name, that add friction over speed."""
DIP = 0.25
"""Share of a dip's depth by which all of the friction must fall from where it is the deepest.
Chosen: where friction only bends upwards the likeliest dip falls by none or an eighth, most true
ones by a quarter to all of it.
"""
OF_EVERY_AXIS = 4.0
"""Dry and viscous friction are on every axis, on most that turn a weight; a load, a spring or
friction by direction on one of some: odds of two that say the same in a recording. Chosen."""
STEADY = 0.98
"""Share of the most dry friction from which on a row turns over no more. Chosen."""
PARTS = 20
"""Parts of a dip's depth over each of which friction is averaged. Chosen."""
DRAGS = (1.5, 2.0, 3.0)
"""Powers of speed with which a drag may grow."""
AS_A_DRAG = 0.8
"""Share of a dip beyond dry and viscous friction from which on, given by a drag, it may be one.
Chosen."""
FALLS = 0.7
"""Friction warms when this share of the changes of its factor over time are falls. Chosen."""


def coulomb_candidate(s: AxisSignals) -> Candidate:
    """Dry friction, turning over one of several widths of speed."""
    widths = s.scales.widths()
    forms = [
        CandidateForm(
            lambda: s.sense, names=("level",), tries=1 + len(widths), allowed=has_positive_first
        )
    ]
    forms += grid_forms(
        lambda width: np.tanh(s.velocity / width),
        [{"width": width} for width in widths],
        names=(),
        allowed=has_positive_first,
    )
    return Candidate(
        "coulomb", "coulomb", tuple(forms), (s.channel("direction"),),
        detail=lambda: around_standstill(s),
        loose=lambda: around_standstill(s), static=True, usual=OF_EVERY_AXIS,
    )  # fmt: skip


def around_standstill(s: AxisSignals) -> Array:
    """Return columns (n, 6) for what sgn(v) gets wrong where a move starts, turns or stops.

    One row earlier or later, starts and stops apart, and friction that needs some speed to rise to
    its level.
    """
    sense = s.sense
    columns = [np.tanh(s.velocity / width) - sense for width in s.scales.starts()]
    for neighbour in (np.roll(sense, -1), np.roll(sense, 1)):
        step = neighbour - sense
        gains = np.abs(neighbour) > np.abs(sense)
        columns += [step * gains, step * ~gains]
    return np.column_stack(columns)


def viscous_candidate(s: AxisSignals) -> Candidate:
    """Friction that grows with speed, in proportion or slower."""
    scale = max(float(np.abs(s.frame.velocity).max()), 1e-9)
    forms = (
        CandidateForm(
            lambda: s.velocity, names=("coefficient",), tries=3, allowed=has_positive_first
        ),
        *(
            CandidateForm(
                lambda power: s.sense * (np.abs(s.velocity) / scale) ** power,
                shape={"power": power},
                tries=3,
                allowed=has_positive_first,
            )
            for power in (0.7, 0.5)
        ),
    )
    return Candidate(
        "viscous", "viscous", forms, (s.channel("velocity"),),
        detail=lambda: s.sense[:, None] * spline(np.abs(s.velocity), 8), static=True,
        usual=OF_EVERY_AXIS,
    )  # fmt: skip


def falls_with_speed(dip: Array, beside: Mapping[str, Array]) -> bool:
    """Whether friction, a dip of it (n,) and dry and viscous friction (n,), falls as the dip does.

    Beside dry and viscous friction of any size a dip gives every curve that bends upwards, that of
    a drag as well; only where friction falls has it to be one. Rows in which the axis turns over
    are left out: all friction is less there.
    """
    dry = beside.get("coulomb", np.ones_like(dip))
    steady = (dry >= STEADY * dry.max()) | (dry <= STEADY * dry.min())
    depth = np.where(steady, np.abs(dip), 0.0)
    if not depth.any():
        return False
    along = np.sign(dip) * sum(beside.values(), start=dip)
    part = np.minimum((depth / depth.max() * PARTS).astype(int), PARTS - 1)[depth > 0.0]
    rows, sums = np.bincount(part), np.bincount(part, along[depth > 0.0])
    means = sums[rows > 0] / rows[rows > 0]
    return float(means[-1] - means.min()) >= DIP * float(depth.max())


def is_a_dip(dip: Array, beside: Mapping[str, Array]) -> bool:
    """Whether a dip of friction (n,), beside dry and viscous friction (n,), is one.

    Beside these in any size a wide dip gives every curve that bends upwards, that of a drag as
    well: it is one where friction falls as it does, or where no drag gives what it gives.
    """
    return falls_with_speed(dip, beside) or _share_of_a_drag(dip, beside) < AS_A_DRAG


def _share_of_a_drag(dip: Array, beside: Mapping[str, Array]) -> float:
    """Return how much of a dip's squares (n,) beyond dry and viscous friction a drag gives."""
    if not {"coulomb", "viscous"} <= set(beside):
        return 1.0
    dry, viscous = (beside[term] for term in ("coulomb", "viscous"))
    slow = np.abs(viscous) / max(float(np.abs(viscous).max()), 1e-300)
    drags = np.sign(viscous)[:, None] * slow[:, None] ** np.array(DRAGS)
    own, columns = np.column_stack([dry, viscous]), np.column_stack([dip, drags])
    beyond = columns - own @ solved_together(own, columns)
    lengths = np.maximum(np.linalg.norm(beyond, axis=0), 1e-300)
    alike = (beyond[:, 1:] / lengths[1:]).T @ (beyond[:, 0] / lengths[0])
    return float(np.max(alike**2))


def stribeck_dip(s: AxisSignals) -> Candidate:
    """Extra friction at low speed that falls with speed."""
    forms = grid_forms(
        lambda speed, exponent: stribeck(s.sense, s.velocity, speed_mm_s=speed, exponent=exponent),
        [{"speed": v, "exponent": e} for v in s.scales.dips() for e in (1.0, 2.0)],
        names=("level",),
        allowed=has_positive_first,
    )
    return Candidate(
        "stribeck", "stribeck", tuple(forms), (s.channel("velocity"),),
        detail=lambda: s.sense[:, None] * spline(np.abs(s.velocity), 8), static=True,
        needs=DRY, part_of=PartOfLaw(OVER_SPEED, is_a_dip),
        mistaken=lambda: around_standstill(s),
    )  # fmt: skip


def asymmetry_candidate(s: AxisSignals) -> Candidate:
    """Friction that differs by direction: the same sign both ways, gone at standstill."""
    moving, speed = np.abs(s.sense), np.abs(s.velocity)
    like = np.abs(s.frame.velocity)
    forms = (
        CandidateForm(lambda: moving, names=("level",), tries=2),
        CandidateForm(lambda: speed, names=("coefficient",), tries=2),
        CandidateForm(lambda: np.column_stack([moving, speed]), names=("level", "coefficient")),
        CandidateForm(lambda: moving[:, None] * spline(speed, 7, like)),
    )
    return Candidate(
        "asymmetry", "asymmetry", forms, (s.channel("direction"), s.channel("velocity")),
        detail=lambda: moving[:, None] * spline(speed, 10), static=True,
    )  # fmt: skip


def position_friction_candidate(s: AxisSignals) -> Candidate:
    """Friction that changes along the travel, alike in both directions."""
    like = s.frame.position
    middle = 0.5 * float(like.min() + like.max())
    forms = (
        CandidateForm(lambda: s.sense * (s.position - middle), names=("slope",)),
        CandidateForm(lambda: s.sense[:, None] * swings(s.position, 8, like)),
        CandidateForm(lambda: s.sense[:, None] * swings(s.position, 16, like)),
    )
    return Candidate(
        "position_friction",
        "position_friction",
        forms,
        (s.channel("position"), s.channel("direction")),
        detail=lambda: s.sense[:, None] * spline(s.position, FINER),
        static=True,
    )


def warmup_candidate(s: AxisSignals) -> Candidate:
    """Friction that falls as the lubricant warms: with the way run, with the clock, or freely."""
    span = float(s.frame.t_s[-1] - s.frame.t_s[0])
    times = [time for time in WARM_TIMES_S if time < 3.0 * span]

    def driven(time_constant: float) -> Array:
        return -s.friction * warmth(s.t_s, s.velocity, time_constant_s=time_constant)

    def clocked(time_constant: float) -> Array:
        return np.asarray(s.friction * np.expm1(-(s.t_s - s.t_s[0]) / time_constant))

    forms = [
        *grid_forms(driven, _times(times), names=("drop",), allowed=has_positive_first),
        *grid_forms(
            clocked,
            _times([time for time in times if time > 0.02 * span]),
            names=("drop",),
            allowed=has_positive_first,
        ),
        CandidateForm(lambda: s.friction[:, None] * swings(s.t_s, 8, s.frame.t_s), allowed=_falls),
    ]
    return Candidate(
        "warmup", "warmup", tuple(forms), ("t", s.channel("velocity")),
        detail=lambda: _warm_detail(s, times), excludes=frozenset({"gain"}),
        needs=DRY | {"viscous"}, holds=s.joined & friction_terms(),
    )  # fmt: skip


def _times(values: list[float]) -> list[dict[str, float]]:
    return [{"time_constant": value} for value in values]


def _warm_detail(s: AxisSignals, times: list[float]) -> Array:
    """Return what friction over time may be beside one law: freely over time, and each term's."""
    along = s.friction[:, None] * spline(s.t_s, 14)
    slow = s.velocity[:, None] * spline(s.t_s, 4)
    driven = [s.friction * warmth(s.t_s, s.velocity, time_constant_s=T) for T in times[:4]]
    return np.column_stack([along, slow, *driven])


def _falls(factor: Array) -> bool:
    """Whether spline coefficients over time, the last of which is 0, mostly fall."""
    steps = np.diff(np.append(factor, 0.0))
    down = -float(steps[steps < 0].sum())
    return down > FALLS * float(np.abs(steps).sum())


def soft_start(s: AxisSignals) -> Candidate:
    """After a reversal friction builds up over a small way."""
    forms = grid_forms(
        lambda distance: s.direction - presliding(s.direction, s.position, distance_mm=distance),
        [{"distance": distance} for distance in s.scales.softening()],
        names=("share",),
        allowed=negative,
    )
    return Candidate(
        "presliding", "presliding", tuple(forms), (s.channel("position"), s.channel("direction")),
        detail=lambda: reversal_columns(s), excludes=frozenset({"backlash"}), needs=DRY,
    )  # fmt: skip


def play(s: AxisSignals) -> Candidate:
    """After a reversal the load's friction is absent over a fixed way."""
    forms = grid_forms(
        lambda gap: backlash(s.direction, s.position, gap_mm=gap),
        [{"gap": gap} for gap in s.scales.plays()],
        names=("level",),
        allowed=has_positive_first,
    )
    return Candidate(
        "backlash", "backlash", tuple(forms), (s.channel("position"), s.channel("direction")),
        detail=lambda: reversal_columns(s), excludes=frozenset({"presliding"}), needs=DRY,
    )  # fmt: skip


def turning_columns(s: AxisSignals) -> Array:
    """Return what friction may do otherwise than simulated while the axis turns, (n, p)."""
    return np.column_stack([around_standstill(s), reversal_columns(s)])


def reversal_columns(s: AxisSignals) -> Array:
    """Return s·exp(−way/scale) for the way run since the last reversal at p scales, (n, p)."""
    return np.column_stack([s.last_sense * np.exp(-s.way / w) for w in s.scales.turns()])

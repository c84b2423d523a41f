"""Candidates that load an axis."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from autodb.explain.axis.friction import OF_EVERY_AXIS
from autodb.explain.axis.signals import AxisSignals
from autodb.explain.axis.tilt import CONSTANT, TILT_NAMES
from autodb.explain.engine.candidates import (
    Candidate,
    CandidateForm,
    grid_forms,
    has_positive_first,
    spline,
)
from autodb.signals import by_piece, lowpass
from autodb.terms.drive import compliance, external_load_edged, tilt
from autodb.terms.sensor import lag

Array = NDArray[np.float64]
Stretches = tuple[tuple[float, float], ...]

RICHER = 4.0
"""Further evidence asked of a load that is not constant, beside a constant one. Chosen."""
REST = 1.5
"""A spring rests at most this many half travels from the middle of the travel; what pulls from
farther is more a constant load. Chosen."""
SWINGS_HZ = (6.0, 9.0, 13.0, 18.0, 25.0, 35.0, 50.0, 70.0)
SWINGS_A_ROW = 0.3
"""Swings in a row up to which rows show one. Chosen."""
DAMPINGS = (0.03, 0.15)
HIGHEST_HZ = 100.0
"""Cutoff above which an acceleration is as good as not smoothed. Chosen."""
LOWER = (1.0, 0.7, 0.5)
"""Shares of the cutoff at which an acceleration is filtered once more. Chosen."""
LOAD_TRIES = 2000
"""Stretches that differ: 400 edges, pairs that overlap mostly look alike. Chosen."""
LEVELS_APART = 8.0
"""How many times their own scatter two levels are apart where a load comes and goes. Chosen."""
NEAR_LEVEL = 0.25
"""A level is reached within this share of the step between the two. Chosen."""
SHORTEST_PULSE_S = 0.1
"""A load that stays or goes for a shorter time did neither. Chosen."""
MOST_PULSES = 55
"""The ways in which a load could have come and gone more often are too many for a float."""
SWITCHES = 400.0
"""Moments at which a load may come or go, as far as they differ. Chosen."""
BY_MOTION, BY_PHASES = 0.5, 0.6
"""Share of the coming and going that the motion tells, up to which it is none of a motion's laws:
of pulses, and what its phases tell of one load. Chosen."""
PUSHED = 0.15
"""Share of the most acceleration from which on an axis speeds up or slows down. Chosen."""
TURNING = "gravity over the angle"
"""Key of a weight that turns with a rotary axis."""


def weights(s: AxisSignals) -> list[Candidate]:
    """Return a constant load, and of a rotary axis a weight that turns with its angle."""
    constant = Candidate(
        CONSTANT if s.rotary else "gravity",
        "gravity",
        (CandidateForm(lambda: np.ones_like(s.t_s), names=("level",)),),
        excludes=frozenset({"spring"}),
        static=True,
    )
    if not s.rotary:
        return [constant]
    turning = Candidate(
        TURNING,
        "gravity",
        (CandidateForm(lambda: tilt(s.position), names=TILT_NAMES),),
        (s.channel("position"),),
        excludes=frozenset({"spring"}),
        static=True,
        phased=True,
        usual=OF_EVERY_AXIS,
    )
    return [constant, turning]


def inertia_candidate(s: AxisSignals) -> Candidate:
    """Mass that must be accelerated."""
    return Candidate(
        "inertia",
        "inertia",
        (
            CandidateForm(
                lambda: s.acceleration, names=("coefficient",), allowed=has_positive_first
            ),
        ),
        (s.channel("acceleration"),),
        detail=lambda: _neighbours(s.acceleration),
        static=True,
    )


def _neighbours(values: Array) -> Array:
    """Return how a signal differs from itself one row earlier and later, (n, 2)."""
    return np.column_stack([np.roll(values, 1) - values, np.roll(values, -1) - values])


def spring_candidate(s: AxisSignals) -> Candidate:
    """A load that grows along the travel with the same sign both ways, straight or hardening.

    Beside a constant load that the simulation has it is a slope, and rests wherever that says.
    """
    like = s.frame.position
    middle = 0.5 * float(like.min() + like.max())
    half = max(0.5 * float(np.ptp(like)), 1e-9)
    along, here = (s.position - middle) / half, np.ones_like(s.position)
    slope = CandidateForm(lambda: s.position - middle, names=("stiffness",))
    straight = CandidateForm(
        lambda middle: np.column_stack([s.position - middle, here]),
        shape={"middle": middle},
        names=("stiffness", "constant"),
        allowed=lambda c: bool(abs(c[1]) <= REST * half * abs(c[0])),
    )
    hardening = CandidateForm(
        lambda: np.column_stack([along, along**2, along**3, here]), allowed=_monotone
    )
    return Candidate(
        "spring",
        "spring",
        (slope if (CONSTANT if s.rotary else "gravity") in s.own else straight, hardening),
        (s.channel("position"),),
        detail=lambda: spline(s.position, 10),
        bar=RICHER,
        excludes=frozenset({"gravity"}),
        static=True,
    )


def _monotone(cubic: Array) -> bool:
    """Whether a·u + b·u² + c·u³ hardly turns back over −1 to 1."""
    u = np.linspace(-1.0, 1.0, 41)
    steps = np.diff(cubic[0] * u + cubic[1] * u**2 + cubic[2] * u**3)
    forth, back = float(steps[steps > 0].sum()), -float(steps[steps < 0].sum())
    return min(forth, back) < 0.15 * max(forth, back)


def swings_behind(s: AxisSignals) -> list[Candidate]:
    """Return the load that swings behind the motor on a springy drive train, where rows show it.

    Of an acceleration that was derived with a filter, nothing swings above its cutoff: there the
    law is what the filter took of a mass.
    """
    rows = [hz for hz in SWINGS_HZ if hz * s.scales.step_s < SWINGS_A_ROW]
    shown = [hz for hz in rows if hz < s.cutoff_hz]
    return [replace(swing(s, shown), detail=lambda: _swinging(s, rows[::2]))] if shown else []


def swing(s: AxisSignals, frequencies_hz: Sequence[float]) -> Candidate:
    """The load swings behind the motor on a springy drive train."""

    def law(frequency: float, damping: float) -> Array:
        return compliance(s.acceleration, s.t_s, frequency_hz=frequency, damping=damping)

    forms = grid_forms(
        law,
        [{"frequency": f, "damping": z} for f in frequencies_hz for z in DAMPINGS],
        names=("coefficient",),
        ratio=1.5,
        allowed=has_positive_first,
    )
    return Candidate(
        "compliance", "compliance", tuple(forms), (s.channel("acceleration"),),
        detail=lambda: _swinging(s, frequencies_hz[::2]),
        mistaken=lambda: otherwise_smoothed(s),
    )  # fmt: skip


def _swinging(s: AxisSignals, frequencies_hz: Sequence[float]) -> Array:
    swings = partial(compliance, s.acceleration, s.t_s, damping=0.1)
    return np.column_stack([swings(frequency_hz=hz) for hz in frequencies_hz])


def otherwise_smoothed(s: AxisSignals) -> Array:
    """Return what acceleration lacks that was smoothed too much, or has of too little, or that
    comes a row early or late, (n, 5).

    Where it steps, a filter leaves as much ahead of the step as behind it; what swings is behind.
    """
    at_hz = min(s.cutoff_hz, HIGHEST_HZ)
    columns = [*_neighbours(s.acceleration).T]
    for share in LOWER:
        smooth = partial(lowpass, rate_hz=1.0 / s.scales.step_s, cutoff_hz=share * at_hz)
        columns.append(by_piece(smooth, s.acceleration, s.pieces) - s.acceleration)
    return np.column_stack(columns)


def cross_couplings(s: AxisSignals) -> list[Candidate]:
    """The acceleration of each other axis, at once or a little late."""
    return [
        cross_coupling_candidate(s, name) for name in s.others if name.endswith(".acceleration")
    ]


def cross_coupling_candidate(s: AxisSignals, name: str) -> Candidate:
    """The acceleration of one other axis."""
    other = s.others[name]
    return Candidate(
        f"cross_coupling {name}",
        "cross_coupling",
        (CandidateForm(lambda: other, names=("coefficient",)),),
        (name,),
        detail=lambda: np.column_stack([_neighbours(other), _late(s, other)]),
        static=True,
    )


def _late(s: AxisSignals, values: Array) -> Array:
    """Return a signal some hundredths of a second late, (n, 2)."""
    return np.column_stack([lag(values, s.t_s, delay_s=d) for d in (0.015, 0.04)])


def load_candidate(s: AxisSignals, low: float, high: float, *, key: str) -> Candidate:
    """Return the candidate of a load from ``low`` to ``high`` [s], constant or abrupt or not."""
    ramp = min(0.5, 0.15 * (high - low))
    give = min(1.0, 0.2 * (high - low))

    def inside(start: float, end: float) -> Array:
        return external_load_edged(s.t_s, start_s=start, end_s=end)

    def soft(start: float, end: float) -> Array:
        rise, fall = (s.t_s - start) / ramp + 0.5, (end - s.t_s) / ramp + 0.5
        return np.clip(np.minimum(rise, fall), 0.0, 1.0)

    def shaped(start: float, end: float) -> Array:
        box, run = inside(start, end), np.clip(2 * (s.t_s - start) / (end - start) - 1, -1, 1)
        return np.column_stack([box, box * run, box * (1.5 * run**2 - 0.5), soft(start, end) - box])

    def detail() -> Array:
        return np.column_stack([shaped(low, high), _flanks(s.t_s, low, high, ramp)])

    within = {"start": (low - give, low + give), "end": (high - give, high + give)}
    return Candidate(
        key,
        "external_load",
        tuple(
            CandidateForm(law, {"start": low, "end": high}, within, names=names, tries=LOAD_TRIES)
            for law, names in ((inside, ("level",)), (soft, ("level",)), (shaped, ()))
        ),
        ("t",),
        detail=detail,
        interval=(low, high),
    )


def _flanks(t_s: Array, low: float, high: float, ramp: float) -> Array:
    """Return what a load's beginning and end may be off, (n, 4)."""
    columns = []
    for at in (low, high):
        near = np.clip(1 - np.abs(t_s - at) / ramp, 0.0, None)
        columns += [near, near * np.sign(t_s - at)]
    return np.column_stack(columns)


def pulsed_loads(s: AxisSignals, difference: Array) -> list[Candidate]:
    """Return the load that comes and goes, where the difference (n,) keeps to two levels that no
    motion tells; none else.
    """
    seen = loaded_rows(difference)
    if seen is None:
        return []
    on = _lasting(s.t_s, seen)
    stretches = _stretches(s.t_s, on)
    if not 1 < len(stretches) <= MOST_PULSES or _told_by_motion(s, on) > BY_MOTION:
        return []
    form = CandidateForm(
        lambda start, end: on.astype(np.float64),  # noqa: ARG005  # said, and told by `on`
        {"start": stretches[0][0], "end": stretches[-1][1]},
        names=("level",),
        tries=SWITCHES ** (2 * len(stretches)),
    )
    return [
        Candidate(
            "external_load that comes and goes",
            "external_load",
            (form,),
            ("t",),
            static=True,
            stretches=stretches,
        )
    ]


def loaded_rows(difference: Array) -> NDArray[np.bool_] | None:
    """Return which rows (n,) are at the level farther from zero, or None where the values keep to
    no two levels.

    A level holds until the other is reached, so that what is between them changes nothing.
    """
    low, high = _two_levels(difference)
    step = high - low
    upper, lower = difference >= high - NEAR_LEVEL * step, difference <= low + NEAR_LEVEL * step
    known = np.flatnonzero(upper | lower)
    if step <= 0 or not len(known):
        return None
    rows = np.arange(len(difference))
    before = known[np.clip(np.searchsorted(known, rows, side="right") - 1, 0, None)]
    after = known[np.clip(np.searchsorted(known, rows), None, len(known) - 1)]
    crossed = difference >= low + 0.5 * step
    is_high = np.where(upper[before] == upper[after], upper[before], crossed)
    if is_high.all() or not is_high.any():
        return None
    scatter = 0.0
    for state, level in ((is_high, high), (~is_high, low)):
        scatter = max(scatter, 1.4826 * float(np.median(np.abs(difference[state] - level))))
    if step < LEVELS_APART * scatter:
        return None
    return is_high if abs(high) > abs(low) else ~is_high


def _lasting(t_s: Array, on: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which rows are on (n,), where what lasts too short goes on as it was before."""
    first = np.flatnonzero(np.concatenate([[True], on[1:] != on[:-1]]))
    ends = np.append(t_s[first[1:]], t_s[-1])
    lasts = ends - t_s[first] >= SHORTEST_PULSE_S
    lasts[0] |= not lasts.any()
    since = np.maximum.accumulate(np.where(lasts, np.arange(len(first)), -1))
    states = on[first[np.where(since < 0, np.argmax(lasts), since)]]
    return np.asarray(np.repeat(states, np.diff(np.append(first, len(on)))))


def _two_levels(values: Array) -> tuple[float, float]:
    """Return the medians of the values below and above the cut that parts them best."""
    cut = float(np.mean(np.quantile(values, (0.02, 0.98))))
    low = high = cut
    for _ in range(50):
        above = values > cut
        if above.all() or not above.any():
            return cut, cut
        low, high = float(np.median(values[~above])), float(np.median(values[above]))
        if 0.5 * (low + high) == cut:
            break
        cut = 0.5 * (low + high)
    return low, high


def _told_by_motion(s: AxisSignals, on: NDArray[np.bool_]) -> float:
    """Return the share of the coming and going that position, speed, direction and acceleration
    tell.
    """
    given = np.column_stack(
        [np.ones_like(s.t_s), s.position, s.velocity, np.abs(s.velocity), s.sense, s.acceleration]
    )
    given = given / np.maximum(np.abs(given).max(axis=0), 1e-300)
    state = on - on.mean()
    rest = state - given @ np.linalg.lstsq(given, state, rcond=None)[0]
    return 1.0 - float(rest @ rest) / float(state @ state)


def told_by_phases(s: AxisSignals, low: float, high: float) -> bool:
    """Whether the phases of the motion tell when a load is there, from ``low`` to ``high`` [s]:
    rest, one direction or the other, and speeding up, at speed or slowing down in each.

    What lasts as long as a move, or one of its ramps, is a law of the motion.
    """
    pushed = np.abs(s.acceleration) > PUSHED * float(np.quantile(np.abs(s.acceleration), 0.99))
    ramps = np.where(pushed, np.sign(s.acceleration), 0.0)
    phase = np.unique(3.0 * np.round(s.sense) + ramps, return_inverse=True)[1]
    on = (s.t_s >= low) & (s.t_s <= high)
    rows, loaded = np.bincount(phase), np.bincount(phase, on)
    given = float(np.sum((loaded - rows * on.mean()) ** 2 / rows))
    return given > BY_PHASES * float(np.sum((on - on.mean()) ** 2))


def _stretches(t_s: Array, on: NDArray[np.bool_]) -> Stretches:
    """Return from when to when [s] rows are on, half a row beyond the first and the last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(np.int8)))
    between = np.concatenate([[t_s[0]], 0.5 * (t_s[1:] + t_s[:-1]), [t_s[-1]]])
    return tuple(
        (float(between[first]), float(between[last])) for first, last in edges.reshape(-1, 2)
    )

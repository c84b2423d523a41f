"""Candidates that load an axis, and those that the motor, the sensor or the clock make."""

from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from autodb.explain.axis.friction import turning_columns
from autodb.explain.axis.signals import AxisSignals
from autodb.explain.axis.tilt import TILT_NAMES
from autodb.explain.axis.unknown import BAR
from autodb.explain.engine.candidates import (
    UNKNOWN,
    Candidate,
    CandidateForm,
    grid_forms,
    has_positive_first,
    near_one,
    spline,
    swings,
)
from autodb.terms.drive import compliance, tilt
from autodb.terms.sensor import lag

Array = NDArray[np.float64]

RICHER = 4.0
"""Further evidence asked of a load that is not constant, beside a constant one. Chosen."""
SWINGS_HZ = (6.0, 9.0, 13.0, 18.0, 25.0, 35.0, 50.0, 70.0)
SWINGS_A_ROW = 0.3
"""Swings in a row up to which rows show one. Chosen."""
DAMPINGS = (0.03, 0.15)
DELAYS_S = (
    0.0004,
    0.0008,
    0.0015,
    0.0025,
    0.004,
    0.006,
    0.009,
    0.013,
    0.02,
    0.03,
    0.045,
    0.07,
    0.1,
    0.15,
    0.22,
)
SETTLING = (0.05, 0.15, 0.4, 1.0)
"""Times of a settling drift and gain as shares of the recording."""
STEPS = 24
STEP_S, STEP_ROWS = 0.04, 2.0
"""Time that a gain's step takes, and rows at least: a search can follow it. Chosen."""
CLIPS = 28
SIDES = ((1.0, -1.0), (1.0,), (-1.0,))
"""Ways in which an effort is limited: a drive's limit acts both ways, a sensor's often one way."""
SOFTER = 2
"""Soft limits stand this many times as far apart as sharp ones."""
SOFT = 0.08
"""Width of a soft knee as a share of the limit."""
BELOW = 0.995
"""Share of the rows of a clipped effort that are below its limit, but for noise. Chosen."""
ONE_SIGN, OTHER_SIGN = 0.02, 0.1
"""Where the sign is lost, rows but this share have one sign, but for noise of this share of their
size; of a simulation with two signs twice that share has the other. Chosen."""
TURNING = "gravity over the angle"
"""Key of a weight that turns with a rotary axis."""
TERMS_WITH_SIGNS, SIGN_ROUNDS = 2, 10
"""Terms that a simulation has at least for its signs to be looked for, and rounds of looking."""
LOWEST_CLIP = 0.6
"""A limit is looked for from this quantile of the simulated effort on."""


def load_candidates(s: AxisSignals) -> list[Candidate]:
    """Return the loads that an axis may have beside friction."""
    return [
        *weights(s),
        inertia_candidate(s),
        spring_candidate(s),
        *swings_behind(s),
        *cross_couplings(s),
    ]


def weights(s: AxisSignals) -> list[Candidate]:
    """Return a constant load, and of a rotary axis a weight that turns with its angle."""
    constant = Candidate(
        "gravity",
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
    """A load that grows along the travel with the same sign both ways, straight or hardening."""
    like = s.frame.position
    middle = 0.5 * float(like.min() + like.max())
    half = max(0.5 * float(np.ptp(like)), 1e-9)
    along, here = (s.position - middle) / half, np.ones_like(s.position)
    return Candidate(
        "spring",
        "spring",
        (
            CandidateForm(
                lambda middle: np.column_stack([s.position - middle, here]),
                shape={"middle": middle},
                names=("stiffness", "constant"),
            ),
            CandidateForm(
                lambda: np.column_stack([along, along**2, along**3, here]), allowed=_monotone
            ),
        ),
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
    """Return the load that swings behind the motor on a springy drive train, where rows show it."""
    shown = [hz for hz in SWINGS_HZ if hz * s.scales.step_s < SWINGS_A_ROW]
    return [swing(s, shown)] if shown else []


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
        detail=lambda: np.column_stack([law(f, 0.1) for f in frequencies_hz[::2]]),
        excludes=frozenset({"lag"}),
    )  # fmt: skip


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


def sensor_candidates_of_axis(s: AxisSignals) -> list[Candidate]:
    """Return what the motor's constant, the sensor and the clock may do.

    Where no effort is known there is nothing to scale, shift, clip or lose the sign of.
    """
    if not np.any(s.effort):
        return [drift(s)]
    made = [gain_candidate(s), drift(s), shift(s), clipping(s), braking(s)]
    made += [lost_sign_candidate(s)] if _has_one_sign(s) else []
    return [candidate for candidate in made if candidate.forms]


def _has_one_sign(s: AxisSignals) -> bool:
    """Whether what was recorded has hardly another sign, while the simulation has both."""
    if s.recorded is None:
        return True
    low, high = np.quantile(s.recorded, (ONE_SIGN, 1.0 - ONE_SIGN))
    other = np.quantile(s.simulation, (2.0 * ONE_SIGN, 1.0 - 2.0 * ONE_SIGN))
    return bool(min(-low, high) < OTHER_SIGN * max(-low, high) and other[0] < 0.0 < other[1])


def gain_candidate(s: AxisSignals) -> Candidate:
    """Every contribution scales alike with a factor that changes: steadily, settling, in a step."""
    run = _run(s)
    rise = max(STEP_S, STEP_ROWS * s.scales.step_s) / float(s.frame.t_s[-1] - s.frame.t_s[0])

    def settling(time_constant: float) -> Array:
        return -s.effort * np.expm1(-run / time_constant)

    def stepping(start: float) -> Array:
        return s.effort * np.clip((run - start) / rise + 0.5, 0.0, 1.0)

    tries = 1 + len(SETTLING) + STEPS
    forms = [CandidateForm(lambda: s.effort * run, names=("share_of_all",), tries=tries)]
    forms += grid_forms(settling, [{"time_constant": T} for T in SETTLING], names=("share_of_all",))
    forms += [
        CandidateForm(
            stepping,
            shape={"start": float(at)},
            within={"start": (float(at) - 1.0 / STEPS, float(at) + 1.0 / STEPS)},
            names=("share_of_all",),
            tries=tries,
        )
        for at in np.linspace(0.0, 1.0, STEPS + 2)[1:-1]
    ]
    forms.append(CandidateForm(lambda: s.effort[:, None] * swings(run, 7, _run(s.frame))))
    return Candidate(
        "gain", "gain", tuple(forms), ("t",),
        detail=lambda: s.effort[:, None] * spline(run, 14), excludes=frozenset({"warmup"}),
    )  # fmt: skip


def braking(s: AxisSignals) -> Candidate:
    """While the drive brakes, power flows back, and another share of the effort is recorded.

    Losses add to what a motor draws and take away from what it gives back, and a meter that knows
    one direction shows nothing then.
    """
    brakes = s.effort * s.velocity < 0.0
    less = CandidateForm(lambda: s.effort * brakes, names=("share_while_braking",))
    nothing = CandidateForm(
        lambda: -s.simulation * brakes,
        names=("share",),
        allowed=near_one,
        through=lambda columns: columns * ~brakes[:, None],
    )
    return Candidate(
        "braking, with effort against the motion",
        UNKNOWN,
        (less, nothing),
        (s.channel("velocity"), s.channel("acceleration")),
        bar=BAR,
    )


def _run(s: AxisSignals) -> Array:
    """Return time as a share of the recording."""
    like = s.frame.t_s
    return np.asarray((s.t_s - like[0]) / (like[-1] - like[0]))


def drift(s: AxisSignals) -> Candidate:
    """The sensor's zero point follows the clock: straight, bent, settling, or freely and slowly."""
    run = _run(s)
    forms = [
        CandidateForm(lambda: run, names=("change",)),
        CandidateForm(lambda: np.column_stack([run, run**2]), names=("change", "bend")),
        *grid_forms(
            lambda time_constant: -np.expm1(-run / time_constant),
            [{"time_constant": time} for time in SETTLING],
            names=(),
        ),
        CandidateForm(lambda: spline(run, 8, _run(s.frame))),
    ]
    return Candidate(
        "sensor_drift",
        "sensor_drift",
        tuple(forms),
        ("t",),
        detail=lambda: spline(run, 16),
        bar=RICHER,
        static=True,
    )


def shift(s: AxisSignals) -> Candidate:
    """Recording and simulation are shifted in time, either way."""
    delays = s.scales.delays(DELAYS_S)
    least = delays[0]
    slightly = CandidateForm(
        lambda: lag(s.simulation, s.t_s, delay_s=least) - s.simulation,
        names=("slight",),
        allowed=lambda c: bool(abs(c[0]) < 1.0),
    )
    forms = grid_forms(
        lambda delay: lag(s.simulation, s.t_s, delay_s=delay) - s.simulation,
        [{"delay": sign * d} for sign in (1.0, -1.0) for d in delays],
        names=("share",),
        ratio=1.6,
        allowed=near_one,
        through=lambda columns, delay: _late_columns(columns, s.t_s, delay),
    )
    return Candidate(
        "lag", "lag", (slightly, *forms), (), detail=lambda: _shifted(s),
        excludes=frozenset({"compliance"}), mistaken=lambda: turning_columns(s),
    )  # fmt: skip


def _late_columns(columns: Array, t_s: Array, delay: float) -> Array:
    late = [lag(column, t_s, delay_s=delay) for column in columns.T]
    return np.column_stack([np.empty((len(t_s), 0)), *late])


def _shifted(s: AxisSignals) -> Array:
    return np.column_stack(
        [lag(s.simulation, s.t_s, delay_s=d) - s.simulation for d in (-0.02, -0.006, 0.006, 0.02)]
    )


def clipping(s: AxisSignals) -> Candidate:
    """The effort is clipped at a limit that the simulation exceeds: both ways, or one way only."""
    forms = [form for sides in SIDES for form in _limits(s, sides)]
    return Candidate("saturation", "saturation", tuple(forms), (), first=True)


def _limits(s: AxisSignals, sides: tuple[float, ...]) -> list[CandidateForm]:
    """Return sharp and soft limits on these sides."""
    size, sign = _beyond(s.effort, sides), np.sign(s.effort)
    like = _beyond(s.frame.effort, sides)
    highest = float(like.max())
    if highest <= 0:
        return []
    lowest = max(float(np.quantile(like, LOWEST_CLIP)), highest / CLIPS)
    step = (highest - lowest) / CLIPS
    limits = [at for n in range(CLIPS) if _ends_at(s, sides, at := lowest + step * n)]

    def sharp(limit: float) -> Array:
        return np.where(size > limit, sign * limit - s.simulation, 0.0)

    def clipped(columns: Array, limit: float) -> Array:
        return columns * (size <= limit)[:, None]

    def soft(limit: float) -> Array:
        width = SOFT * limit
        over = width * np.logaddexp(0.0, (size - limit) / width)
        added = s.effort - s.simulation
        return added - sign * over - softened(added[:, None], limit)[:, 0]

    def softened(columns: Array, limit: float) -> Array:
        return np.asarray(columns * expit((limit - size) / (SOFT * limit))[:, None])

    return [
        CandidateForm(
            law,
            shape={"limit": at},
            within={"limit": (at - step, at + step)},
            names=("share",),
            tries=len(SIDES) * len((*limits, *limits[::SOFTER])),
            allowed=near_one,
            through=through,
        )
        for law, through, tried in ((sharp, clipped, limits), (soft, softened, limits[::SOFTER]))
        for at in tried
    ]


def _ends_at(s: AxisSignals, sides: tuple[float, ...], limit: float) -> bool:
    """Whether what was recorded ends near a limit on these sides, as what is clipped does."""
    if s.recorded is None:
        return True
    size = _beyond(s.recorded, sides)
    return bool(np.quantile(size, BELOW) < (1.0 + 2.0 * SOFT) * limit)


def _beyond(effort: Array, sides: tuple[float, ...]) -> Array:
    """Return how far an effort is out on these sides, 0 on the other."""
    return np.asarray(np.max([side * effort for side in (*sides, 0.0)], axis=0))


def lost_sign_candidate(s: AxisSignals) -> Candidate:
    """A magnitude was recorded: of the simulation, or of its terms fitted to the magnitude."""
    efforts = [s.effort, *_signed_efforts(s)]

    def law(number: int) -> Array:
        return np.asarray(np.abs(efforts[number]) - s.simulation)

    def through(columns: Array, number: int) -> Array:
        return columns * np.where(efforts[number] < 0, -1.0, 1.0)[:, None]

    forms = tuple(
        CandidateForm(
            partial(law, number),
            names=("share",),
            tries=len(efforts),
            allowed=near_one,
            through=partial(through, number=number),
        )
        for number in range(len(efforts))
    )
    return Candidate("lost_sign", "lost_sign", forms, (), first=True)


def _signed_efforts(s: AxisSignals) -> list[Array]:
    """Return efforts of the simulation's terms whose magnitudes fit what was recorded.

    A simulation that was refitted to magnitudes has lost its signs with them. Fit and signs are
    found in turn, from the sign of each term on; the best stays.
    """
    if s.recorded is None or len(s.own) < TERMS_WITH_SIGNS:
        return []
    own = np.column_stack(list(s.own.values()))
    found = []
    for column in own.T:
        sign = np.sign(column)
        for _ in range(SIGN_ROUNDS):
            effort = own @ np.linalg.lstsq(own, sign * s.recorded, rcond=None)[0]
            sign = np.sign(effort)
        found.append(effort)
    left = [float(np.sum((np.abs(effort) - s.recorded) ** 2)) for effort in found]
    return [found[int(np.argmin(left))]]

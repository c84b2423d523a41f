"""Candidates that the motor, the sensor or the clock make, of an axis; what a controller makes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import Cause
from autodb.explain.axis.friction import turning_columns
from autodb.explain.axis.loads import RICHER
from autodb.explain.axis.read_off import READ_OFF
from autodb.explain.axis.signals import BRAKING, AxisSignals
from autodb.explain.axis.unknown import BAR
from autodb.explain.engine.candidates import (
    UNKNOWN,
    Candidate,
    CandidateForm,
    grid_forms,
    near_one,
    spline,
    swings,
)
from autodb.explain.engine.plain.odds import UNSURE
from autodb.terms.sensor import lag

Array = NDArray[np.float64]

LONG = (0.07, 0.1, 0.15, 0.22)
"""Delays of a recording and a simulation whose clocks were not started together. Chosen."""
DELAYS_S = (0.0004, 0.0008, 0.0015, 0.0025, 0.004, 0.006, 0.009, 0.013, 0.02, 0.03, 0.045, *LONG)
SETTLING = (0.05, 0.15, 0.4, 1.0)
"""Times of a settling drift and gain as shares of the recording."""
RAMPS = (0.15, 0.3, 0.6)
"""Times that a gain's ramp takes, as shares of the recording. Chosen."""
STEPS = 24
STEP_S, STEP_ROWS = 0.04, 2.0
"""Time that a gain's step takes, and rows at least: a search can follow it. Chosen."""
LATER_ROWS = (0.0, 0.5, 1.0, 1.5, 2.0)
"""Rows by which an effort may come after the speed that it answers."""
MOSTLY = 0.9
"""Share of an effort's variance from which on it is a controller's. Chosen: 0.98 in a public
motor's recording under speed control; elsewhere effort rises with speed or does not follow it."""


def gain_candidate(s: AxisSignals) -> Candidate:
    """Every contribution scales alike with a factor that changes: steadily, settling, in a step or
    over a ramp. The simulation is right before; friction, mass and weight that it lacks have their
    size at the mean factor where they act, so that a change that comes early leaves them that.
    """
    like = s.frame
    lacking = [s.found[term] for term in sorted(s.joined & READ_OFF) if np.any(s.found[term])]
    rise = max(STEP_S, STEP_ROWS * s.scales.step_s) / float(like.t_s[-1] - like.t_s[0])

    def scaled(change: Callable[[Array], Array]) -> Array:
        changed = change(_run(s))
        usual = (part * float(changed @ part**2) / float(part @ part) for part in lacking)
        return s.effort * changed - sum(usual, start=np.zeros_like(s.effort))

    def settling(time_constant: float) -> Array:
        return scaled(lambda run: -np.expm1(-run / time_constant))

    def stepping(start: float) -> Array:
        return scaled(lambda run: np.clip((run - start) / rise + 0.5, 0.0, 1.0))

    def ramping(start: float, duration: float) -> Array:
        return scaled(lambda run: np.clip((run - start) / duration, 0.0, 1.0))

    steps = [float(at) for at in np.linspace(0.0, 1.0, STEPS + 2)[1:-1]]
    ramps = [
        (float(at), length) for length in RAMPS for at in np.arange(0.0, 1.0 - length, length / 2)
    ]
    names, tries = ("share_of_all",), 1 + len(SETTLING) + len(steps) + len(ramps)

    def changing(
        law: Callable[..., Array], near: float, at: float, **lasts: float
    ) -> CandidateForm:
        within = {"start": (at - near, at + near)}
        within |= {name: (value / 2, value * 2) for name, value in lasts.items()}
        return CandidateForm(law, {"start": at, **lasts}, within, names, tries, _may_scale)

    settles = [{"time_constant": T} for T in SETTLING]
    forms = [
        CandidateForm(lambda: scaled(np.asarray), names=names, tries=tries, allowed=_may_scale),
        *grid_forms(settling, settles, names=names, allowed=_may_scale),
        *(changing(stepping, 1.0 / STEPS, at) for at in steps),
        *(changing(ramping, length / 2, at, duration=length) for at, length in ramps),
        CandidateForm(lambda: s.effort[:, None] * swings(_run(s), 7, _run(like))),
    ]
    return Candidate(
        "gain", "gain", tuple(forms), ("t",),
        detail=lambda: s.effort[:, None] * spline(_run(s), 14), excludes=frozenset({"warmup"}),
        holds=s.joined,
    )  # fmt: skip


def _may_scale(share: Array) -> bool:
    """Whether a constant of a motor or a sensor may change by a share: it goes, but neither doubles
    nor turns its sign.
    """
    return bool(abs(share[0]) < 1.0)


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
        BRAKING,
        UNKNOWN,
        (less, nothing),
        (s.channel("velocity"), s.channel("acceleration")),
        bar=BAR,
        holds=s.joined,
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
        lambda: _straight(s.simulation, s.t_s, least),
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
        mistaken=lambda: turning_columns(s),
    )  # fmt: skip


def _straight(values: Array, t_s: Array, delay_s: float) -> Array:
    """Return by how much values (n,) differ a moment later, along a straight line through the rows
    before and after: to draw lines between rows smooths what turns within two.
    """
    later, earlier = (lag(values, t_s, delay_s=way * delay_s) for way in (1.0, -1.0))
    return 0.5 * (later - earlier)


def _late_columns(columns: Array, t_s: Array, delay: float) -> Array:
    late = [lag(column, t_s, delay_s=delay) for column in columns.T]
    return np.column_stack([np.empty((len(t_s), 0)), *late])


def _shifted(s: AxisSignals) -> Array:
    return np.column_stack(
        [lag(s.simulation, s.t_s, delay_s=d) - s.simulation for d in (-0.02, -0.006, 0.006, 0.02)]
    )


@dataclass(frozen=True)
class SpeedControl:
    """A controller's law: ``gain`` [effort by mm/s or deg/s], ``share`` of the variance.

    It sets effort = k (v* − v), v as it was measured about a row before. Where nothing else moves
    the axis a recording obeys this law as well as the axis' own, and what a fit says of the axis is
    drawn to it: a closed loop that nothing excites. Source: Söderström and Stoica 1989, System
    Identification, ch. 10.
    """

    gain: float
    share: float


def speed_control(effort: Array, velocity: Array) -> SpeedControl | None:
    """Return the law by which a speed controller makes an effort (n,) of a velocity (n,), if it
    gives MOSTLY all of it.
    """
    rows = np.arange(len(effort), dtype=np.float64)
    off, whole = effort - effort.mean(), float(np.var(effort))
    laws = []
    for later in LATER_ROWS:
        speed = np.interp(rows - later, rows, velocity)
        speed -= speed.mean()
        slope = float(speed @ off) / max(float(speed @ speed), 1e-300)
        left = float(np.mean((off - slope * speed) ** 2))
        laws.append(SpeedControl(-slope, 1.0 - left / max(whole, 1e-300)))
    best = max(laws, key=lambda law: law.share)
    return best if best.gain > 0.0 and best.share >= MOSTLY else None


def less_sure(causes: Sequence[Cause]) -> list[Cause]:
    """Return causes, none surer than UNSURE."""
    return [
        cause.model_copy(update={"confidence": min(cause.confidence, UNSURE)}) for cause in causes
    ]

"""What the sensor, the motor constant or the clock adds to a channel."""

import numpy as np
from numpy.typing import NDArray

from autodb.terms.term import (
    Contribution,
    Factor,
    InputChange,
    OutputChange,
    ParameterPrior,
    TermParameter,
)

Array = NDArray[np.float64]


def sensor_drift(t_s: Array) -> Array:
    """A sensor's zero point follows the clock: columns t − t₀ [s] and its square, (n, 2).

    Effort = rate · (t − t₀) + bend · (t − t₀)², also at standstill and whatever the axis does.
    Source: by construction; the parabola is chosen.
    """
    since = t_s - t_s[0]
    return np.column_stack([since, since**2])


def gain(t_s: Array, *, factor: float, start_s: float, duration_s: float) -> Array:
    """The motor's or sensor's constant changes: factor 1 before, `factor` after, (n,).

    It ramps over ``duration_s`` from ``start_s`` on; every contribution scales alike. A constant
    factor over the whole recording is no gain change: then all terms are mistuned together.
    Source: by construction; the ramp is chosen.
    """
    return 1.0 + (factor - 1.0) * np.clip((t_s - start_s) / max(duration_s, 1e-9), 0.0, 1.0)


def lag(values: Array, t_s: Array, *, delay_s: float) -> Array:
    """Recording and simulation are shifted in time: values(t − delay), linear between rows, (n,).

    The ends hold their first or last value. Source: by construction.
    """
    return np.asarray(np.interp(t_s - delay_s, t_s, values), dtype=np.float64)


def saturation(effort: Array, *, limit: float) -> Array:
    """The drive or logger clips: effort limited to ±limit, in the channel's unit, (n,).

    Source: by construction.
    """
    return np.clip(effort, -limit, limit)


def lost_sign(effort: Array) -> Array:
    """A magnitude is recorded: |effort|, (n,).

    Source: by construction.
    """
    return np.abs(effort)


SENSOR_DRIFT = Contribution(
    name="sensor_drift",
    title="drift of the sensor",
    channels=("axis", "spindle", "cuts", "table"),
    inputs=("t",),
    function=sensor_drift,
    coefficients=(
        TermParameter("rate", "U/s", "drift per time at the beginning"),
        TermParameter("bend", "U/s²", "how the drift speeds up or settles"),
    ),
    needs=(),
    statement="The sensor's zero point wanders with the clock, also while nothing moves.",
    excited_by="a standstill at the beginning and one at the end",
    source="by construction",
    check="Check zero, warm-up and cable of the sensor; a reading that creeps with the clock may "
    "be its amplifier's drift, and the zero before and after the recording, with nothing moving, "
    "shows it.",
    check_source="Shaw, Metal Cutting Principles, 2nd ed. (2005), chapter 7",
    sits=("sensor", "calibration"),
)
GAIN = Factor(
    name="gain",
    title="a changed scale",
    channels=("axis", "spindle", "cuts", "table"),
    inputs=("t",),
    function=gain,
    shape=(
        TermParameter("factor", "1", "what everything is multiplied by in the end", 0.2, 5.0,
                  prior=ParameterPrior(1.0, 0.3, "chosen"), keyword="factor", starts=(0.9, 1.1)),
        TermParameter("start", "s", "when it begins to change", keyword="start_s"),
        TermParameter("duration", "s", "how long it takes", 0.0, keyword="duration_s"),
    ),
    modifies=("*",),
    needs=(),
    statement="The motor's or the sensor's constant changes: everything scales alike.",
    excited_by="accelerated moves and a loaded standstill, before and after",
    source="by construction",
    alike=("warmup",),
    distinguished_by="Add accelerated moves, or a vertical axis' standstill: warming leaves "
    "inertia and weight alone.",
    check="Check range, wiring and calibration of the sensor or amplifier, and how warm motor and "
    "charge amplifier were; a scale that changes may be any of them, and a known load before and "
    "after shows it.",
    check_source="P1 sections 9 and 12; Shaw, Metal Cutting Principles, 2nd ed. (2005), chapter 7",
    sits=("calibration", "sensor", "machine"),
    belongs_to="calibration",
)  # fmt: skip
LAG = InputChange(
    name="lag",
    title="a shift in time",
    channels=("axis", "spindle"),
    inputs=("t",),
    function=lag,
    changes=("position", "velocity", "direction", "acceleration", "other_acceleration"),
    shape=(
        TermParameter("delay", "s", "recording behind simulation", -0.5, 0.5,
                  prior=ParameterPrior(0.0, 0.05, "chosen"), keyword="delay_s",
                  starts=(-0.02, -0.005, 0.0, 0.005, 0.02)),
    ),
    modifies=("*",),
    needs=("position",),
    statement="The effort was logged later or earlier than the position.",
    excited_by="reversals and sharp accelerations",
    source="by construction",
    check="Check filters, sampling clocks and trigger of both signals; a shift in time may come "
    "from a filter or from logging by two devices, and one sharp event that both have recorded "
    "shows it.",
    check_source="P1 section 7",
    sits=("sensor", "machine"),
    belongs_to="machine",
    remembers=True,
)  # fmt: skip
SATURATION = OutputChange(
    name="saturation",
    title="a clipped signal",
    channels=("axis", "spindle", "table"),
    inputs=(),
    function=saturation,
    shape=(TermParameter("limit", "U", "largest effort shown", 0.0, keyword="limit"),),
    modifies=("*",),
    needs=(),
    statement="The drive or the logger clips at a limit.",
    excited_by="the hardest acceleration in the programme",
    source="by construction",
    check="Check the measuring range of the sensor and the current limit of the drive; a signal "
    "that stays at one value may be clipped there, and the same move with less load or a wider "
    "range shows it.",
    check_source="Altintas, Manufacturing Automation, 2nd ed. (2012), chapter 6",
    sits=("sensor", "machine"),
)
LOST_SIGN = OutputChange(
    name="lost_sign",
    title="a lost sign",
    channels=("axis", "spindle"),
    inputs=(),
    function=lost_sign,
    modifies=("*",),
    needs=(),
    statement="A magnitude was logged: the sign of the effort is lost.",
    excited_by="passes in both directions on an axis with friction only",
    source="by construction",
    check="Check what the logger keeps; a range, an rms or a percentage has no sign, and a signed "
    "torque-producing current from the control or a slow pass both ways shows it.",
    check_source="P1 sections 7 and 8",
    sits=("sensor",),
)

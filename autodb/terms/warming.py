"""Friction that falls as the lubricant warms."""

import numpy as np
from numpy.typing import NDArray

from autodb.terms._memory import first_order
from autodb.terms.term import Factor, ParameterPrior, TermParameter

Array = NDArray[np.float64]

WARM_SPEED_MM_S = 10_000.0 / 60.0
"""Speed at which warm-up figures are stated: P2 section 3 measured at 10 000 mm/min."""


def warmth(t_s: Array, velocity_mm_s: Array, *, time_constant_s: float) -> Array:
    """Return how warm the lubricant is, 0 cold, 1 after long running at WARM_SPEED_MM_S, (n,).

    T·dw/dt = |v|/WARM_SPEED − w, w = 0 at the first row: driven by friction work, which at nearly
    constant friction goes as speed; it relaxes at rest. Even sampling; over a gap of the clock the
    axis is taken to run as it does on average. Source: P2 section 3, fitted there as 1 − e^(−u/T).
    """
    heat = np.abs(velocity_mm_s) / WARM_SPEED_MM_S
    usual = np.full_like(heat, heat.mean())
    return first_order(heat, t_s, time_constant_s=time_constant_s, meanwhile=usual)


def warmup(
    t_s: Array, velocity_mm_s: Array, *, drop: float, time_constant_s: float, levelling: float
) -> Array:
    """Friction falls as the lubricant warms: factor 1 − drop · w(1 + b)/(1 + b·w), (n,).

    w(t) is ``warmth``; b = ``levelling``: 0 is the line of P2, above 0 the fall levels off before
    the heat does, as an oil's thinning does, and comes back late at rest. Acts on friction, not on
    weight or inertia. Source: P2 section 3: drop about 0.19 and time constant about 20 s at
    10 000 mm/min; b is ours, because a saturating fall could not be followed without it.
    """
    warm = warmth(t_s, velocity_mm_s, time_constant_s=time_constant_s)
    return 1.0 - drop * warm * (1.0 + levelling) / (1.0 + levelling * warm)


WARMUP = Factor(
    name="warmup",
    title="friction that falls as it warms up",
    channels=("axis", "rotary"),
    inputs=("t", "velocity"),
    function=warmup,
    shape=(
        TermParameter(
            "drop", "1", "share of friction lost when warm at 10 000 mm/min", 0.0, 0.9,
            prior=ParameterPrior(0.19, 0.2, "mean: P2 section 3; sd: chosen"),
            keyword="drop", starts=(0.1,),
        ),
        TermParameter(
            "time_constant", "s", "time to warm by 63 %", 1.0, 36_000.0,
            keyword="time_constant_s", starts=(5.0, 20.0, 100.0, 600.0),
        ),
        TermParameter(
            "levelling", "1", "how much sooner the fall levels off than the heat", 0.0, 20.0,
            prior=ParameterPrior(0.0, 2.0, "mean: P2 section 3 (none); sd: chosen"),
            keyword="levelling", starts=(0.0, 3.0), given=True,
        ),
    ),
    modifies=("coulomb", "viscous", "stribeck", "asymmetry", "position_friction", "backlash"),
    needs=("position",),
    statement="The lubricant warms: friction falls while the axis works and recovers at rest.",
    excited_by="the same pass from cold, repeated for ten minutes, and again after a rest",
    source="P2 section 3",
    alike=("gain",),
    distinguished_by="Add accelerated moves, or a vertical axis' standstill: a gain scales inertia "
    "and weight too.",
    check="Check whether the axis was warm when it was identified; friction falls as lubricant and "
    "bearings warm, and a repeated pass some minutes later, or a warm-up programme before the job, "
    "shows it.",
    check_source="P2 section IV",
    belongs_to="machine",
    remembers=True,
)  # fmt: skip

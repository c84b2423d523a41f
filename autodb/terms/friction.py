"""Friction of a feed axis, a rotary axis or a spindle.

``direction`` is an input of its own: +1 and −1 in motion, 0 at standstill. Where a term is "0 at
standstill" it claims nothing about a standing axis, whose drive may hold anything up to breakaway.
"""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.terms.term import Contribution, InputChange, ParameterPrior, TermParameter

Array = NDArray[np.float64]

STANDSTILL_MM_S = 0.05
"""Speed below which the direction fades out linearly: encoder noise makes no friction chatter.
Chosen: 1/20 of the slowest feed in use (60 mm/min)."""
STEP_SHARE = 0.05
"""Width of a step in position, as a share of the place where it is: a screw or belt has no sharper
one, and a fit can follow it. Chosen."""


def direction(velocity_mm_s: Array, *, standstill_mm_s: float = STANDSTILL_MM_S) -> Array:
    """Return the direction of motion: ±1 when moving, fading to 0 through standstill; (n,)."""
    return np.clip(velocity_mm_s / standstill_mm_s, -1.0, 1.0)


def coulomb(direction: Array) -> Array:
    """Coulomb friction opposes the motion with a constant level: column sgn(v), (n,).

    Effort = level · sgn(v), level in the channel's unit. At standstill the column is 0: what a
    standing axis holds is not known from this term. Source: P0 eq. for F_fr with σ = 0, F_br = F_C.
    """
    return direction


def viscous(velocity_mm_s: Array) -> Array:
    """Viscous friction grows in proportion to speed: column v [mm/s], (n,).

    Effort = coefficient · v; 0 at standstill. Source: P0, σ of the Stribeck law.
    """
    return velocity_mm_s


def stribeck(
    direction: Array, velocity_mm_s: Array, *, speed_mm_s: float, exponent: float
) -> Array:
    """Extra friction at creep speed falls off as a film builds up: sgn(v)·exp(−|v/v_s|^δ), (n,).

    Effort = level · column; level = breakaway − Coulomb, v_s [mm/s], δ [-]. At standstill 0, as
    Coulomb friction is. Source: P0 section 2.2 (Stribeck law, δ = 2).
    """
    return np.asarray(direction * np.exp(-((np.abs(velocity_mm_s) / speed_mm_s) ** exponent)))


def asymmetry(direction: Array, velocity_mm_s: Array) -> Array:
    """Friction differs by direction: columns |sgn v| and |v|, (n, 2).

    Effort = level · |sgn v| + coefficient · |v|: half the difference of Coulomb and of viscous
    friction between the positive and the negative direction; 0 at standstill, where a constant
    load is not. Source: Janot, Gautier, Brunot 2019 (direction-dependent model of EMPS).
    """
    return np.column_stack([np.abs(direction), np.abs(velocity_mm_s)])


def position_friction(direction: Array, position_mm: Array, *, middle_mm: float) -> Array:
    """Friction changes along the travel: column sgn(v)·(x − x_m) [mm], (n,).

    Effort = slope · column; with x_m in the middle of the travel Coulomb friction keeps the mean.
    The same in both directions; 0 at standstill. Source: P2 eq. 12, sgn(v)(P_x1 + P_x2 x).
    """
    return direction * (position_mm - middle_mm)


def since_reversal(direction: Array, position_mm: Array) -> tuple[Array, Array]:
    """Return (sense, way): the last direction of motion ±1 and the way run since it turned, (n,).

    A move counts from full direction (|sgn v| = 1) on: encoder noise at standstill turns nothing.
    Before the first move sense is 0 and the way that from the first row.
    """
    moving = np.where(np.abs(direction) >= 1.0, np.sign(direction), 0.0)
    rows = np.arange(len(moving))
    last = np.maximum.accumulate(np.where(moving != 0, rows, 0))
    sense = moving[last]
    turned = np.flatnonzero(np.diff(sense) != 0) + 1
    start = np.zeros(len(sense), dtype=np.intp)
    start[turned] = turned
    way = np.abs(position_mm - position_mm[np.maximum.accumulate(start)])
    return sense, np.asarray(way, dtype=np.float64)


def presliding(direction: Array, position_mm: Array, *, distance_mm: float) -> Array:
    """Friction rises smoothly over a small way after a reversal and is held at standstill, (n,).

    The direction is replaced by z: dz/dx = (1 − z·sgn v)/s₀, solved between reversals,
    z = sgn v·(1 − (1 − sgn v·z₀)·exp(−way/s₀)) with z₀ where the last move ended; before the first
    move z = 0. Source: P. Dahl 1968 (solid friction model, first-order form); P2 names the gap.
    """
    return presliding_state(direction, position_mm, distance_mm=distance_mm, before=0.0)


def presliding_state(
    direction: Array, position_mm: Array, *, distance_mm: float, before: float
) -> Array:
    """Return z of ``presliding`` where it was ``before`` when the first row began."""
    sense, way = since_reversal(direction, position_mm)
    edges = np.flatnonzero(np.diff(sense) != 0) + 1
    starts = np.concatenate([[0], edges, [len(sense)]])
    state = np.zeros_like(sense)
    for begin, end in pairwise(starts):
        s = sense[begin]
        run = slice(begin, end)
        state[run] = (
            s * (1.0 - (1.0 - s * before) * np.exp(-way[run] / distance_mm)) if s else before
        )
        before = float(state[end - 1])
    return state


def backlash(direction: Array, position_mm: Array, *, gap_mm: float) -> Array:
    """In the play after a reversal the load side's friction is absent: −sgn(v)·[way < gap], (n,).

    Effort = level · column, level the load side's part of Coulomb friction. The step has a width of
    STEP_SHARE of the gap. 0 at standstill and before the first reversal.
    Source: by construction, a gap between motor and load.
    """
    _, way = since_reversal(direction, position_mm)
    inside = 0.5 * (1.0 - np.tanh((way - gap_mm) / (STEP_SHARE * gap_mm)))
    return -direction * inside * _after_first_reversal(direction)


def _after_first_reversal(direction: Array) -> Array:
    moving = np.where(np.abs(direction) >= 1.0, np.sign(direction), 0.0)
    first = moving[np.argmax(moving != 0)]
    turned = (moving == -first) & (first != 0)
    return np.asarray(np.maximum.accumulate(turned), dtype=np.float64)


COULOMB = Contribution(
    name="coulomb",
    title="dry friction",
    channels=("axis", "rotary", "spindle"),
    inputs=("direction",),
    function=coulomb,
    coefficients=(
        TermParameter("level", "U", "friction that any motion must overcome", lower=0.0),
    ),
    needs=("position",),
    statement="Dry friction of the guideway and screw that is the same at every speed.",
    excited_by="constant-speed passes in both directions at several speeds",
    source="P0 section 2.2; Janot, Gautier, Brunot 2019",
    check="Check the guideway's wipers, preload and lubrication; dry friction off its usual level "
    "may come from any of them, and shows in slow passes both ways without a tool in cut.",
    check_source="P2 sections II and III.A; Armstrong-Hélouvry, Dupont and Canudas de Wit, "
    "Automatica 30 (1994), 1083-1138",
    belongs_to="machine",
    any_moves=True,
    friction=True,
)
VISCOUS = Contribution(
    name="viscous",
    title="friction that grows with speed",
    channels=("axis", "rotary", "spindle"),
    inputs=("velocity",),
    function=viscous,
    coefficients=(TermParameter("coefficient", "U·s/mm", "friction per speed"),),
    needs=("position",),
    statement="Friction that grows in proportion to speed, as an oil film makes it.",
    excited_by="constant-speed passes in both directions at several speeds",
    source="P0 section 2.2; Janot, Gautier, Brunot 2019",
    check="Check amount and grade of the lubricant and how warm the axis runs; friction that grows "
    "with speed changes with the oil film, and passes at several speeds show by how much.",
    check_source="P2 section III.A; Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 "
    "(1994), 1083-1138",
    belongs_to="machine",
    any_moves=True,
    friction=True,
)
STRIBECK = Contribution(
    name="stribeck",
    title="extra friction at low speed",
    channels=("axis", "rotary"),
    inputs=("direction", "velocity"),
    function=stribeck,
    coefficients=(TermParameter("level", "U", "breakaway less Coulomb friction", lower=0.0),),
    shape=(
        TermParameter(
            "speed", "mm/s", "speed at which 1/e of it is left", 0.05, 200.0,
            keyword="speed_mm_s", starts=(0.5, 2.0, 8.0, 30.0),
        ),
        TermParameter(
            "exponent", "1", "how sharply it falls", 0.3, 4.0,
            prior=ParameterPrior(2.0, 0.5, "mean: P0 section 2.2 (δ = 2); sd: chosen"),
            keyword="exponent", starts=(2.0,), given=True,
        ),
    ),
    needs=("position",),
    statement="Extra friction at creep speed that falls as the axis runs faster.",
    excited_by="slow constant-speed passes, 10 to 500 mm/min, in both directions",
    source="P0 section 2.2 (Stribeck law)",
    check="Check whether the axis judders at creep speed and when its guideways were last "
    "lubricated; extra friction at low speed may be a starved oil film, and passes at creep speeds "
    "show it.",
    check_source="P0 section 2.2, eq. 4; Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica "
    "30 (1994), 1083-1138",
    belongs_to="machine",
    friction=True,
)  # fmt: skip
ASYMMETRY = Contribution(
    name="asymmetry",
    title="friction that differs by direction",
    channels=("axis", "rotary"),
    inputs=("direction", "velocity"),
    function=asymmetry,
    coefficients=(
        TermParameter("level", "U", "half the difference of Coulomb friction, + less − direction"),
        TermParameter("coefficient", "U·s/mm", "half the difference of viscous friction"),
    ),
    modifies=("coulomb", "viscous"),
    needs=("position",),
    statement="The axis runs harder in one direction than in the other.",
    excited_by="constant-speed passes in both directions at several speeds, and a standstill",
    source="Janot, Gautier, Brunot 2019",
    alike=("gravity",),
    distinguished_by="Let the axis stand under control between moves: a constant load stays, a "
    "difference of friction goes.",
    check="Check covers, cable carriers, wipers and the balance of the axis in both directions; "
    "friction that differs by direction may be something that drags only one way, and slow passes "
    "both ways over the same travel show it.",
    check_source="P2 sections II and IV",
    belongs_to="machine",
    friction=True,
)
POSITION_FRICTION = Contribution(
    name="position_friction",
    title="friction that differs along the travel",
    channels=("axis",),
    inputs=("direction", "position"),
    function=position_friction,
    coefficients=(TermParameter("slope", "U/mm", "friction gained per distance towards +"),),
    shape=(
        TermParameter(
            "middle", "mm", "where Coulomb friction is the mean", keyword="middle_mm", given=True
        ),
    ),
    modifies=("coulomb",),
    needs=("position",),
    statement="Friction rises along the travel, the same way in both directions.",
    excited_by="constant-speed passes over the whole travel in both directions",
    source="P2 eq. 12",
    check="Check guideway covers, wipers and the screw where along the travel the friction "
    "differs; a folding cover, dirt or wear may sit there, and slow passes over the whole travel "
    "show the place.",
    check_source="P2 section III.A",
    belongs_to="machine",
    friction=True,
)
PRESLIDING = InputChange(
    name="presliding",
    title="the soft start after a reversal",
    channels=("axis", "rotary"),
    inputs=("position",),
    function=presliding,
    changes=("direction",),
    shape=(
        TermParameter(
            "distance", "mm", "distance over which friction turns (to 1 − 2/e)", 1e-5, 2.0,
            keyword="distance_mm", starts=(0.001, 0.003, 0.01, 0.03, 0.1, 0.3),
        ),
    ),
    modifies=("coulomb", "stribeck", "asymmetry", "position_friction"),
    needs=("position",),
    statement="After a reversal friction builds up over a small way instead of at once.",
    excited_by="many slow reversals of a few hundredths of a millimetre",
    source="Dahl 1968; P2 (gap named there)",
    check="Check the circular path at its reversals; friction that builds up only over a small "
    "distance may be guideways, seals or screw winding up, and small strokes to and fro show the "
    "distance.",
    check_source="ISO 230-4; Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 (1994), "
    "1083-1138",
    belongs_to="machine",
    remembers=True,
)  # fmt: skip
BACKLASH = Contribution(
    name="backlash",
    title="play after a reversal",
    channels=("axis",),
    inputs=("direction", "position"),
    function=backlash,
    coefficients=(TermParameter("level", "U", "friction that is absent in the play", lower=0.0),),
    shape=(
        TermParameter(
            "gap", "mm", "the play", 1e-4, 2.0,
            keyword="gap_mm", starts=(0.003, 0.01, 0.03, 0.1, 0.3, 1.0),
        ),
    ),
    modifies=("coulomb",),
    needs=("position",),
    statement="Play: after a reversal the motor first runs free, then takes the load up.",
    excited_by="slow reversals, longer than the play",
    source="physics of a gap between motor and load",
    alike=("presliding",),
    distinguished_by="Reverse at several feeds with a dial gauge on the slide: play is lost "
    "motion, pre-sliding is not.",
    check="Check the reversal error of the axis, and the preload of nut, coupling and thrust "
    "bearing; play after a reversal may come from any of them, and a dial gauge on small strokes "
    "shows it.",
    check_source="ISO 230-2",
    belongs_to="machine",
    remembers=True,
)  # fmt: skip

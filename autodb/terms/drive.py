"""Loads of a drive that are not friction."""

import numpy as np
from numpy.typing import NDArray

from autodb.terms._memory import by_run
from autodb.terms.term import Contribution, ParameterPrior, TermParameter, step_s

Array = NDArray[np.float64]

EDGE_S = 0.02
"""Time over which an external load sets in or goes: a fit can follow it. Chosen."""


def inertia(acceleration_mm_s2: Array) -> Array:
    """Inertia takes effort in proportion to acceleration: column a [mm/s²], (n,).

    Effort = coefficient · a; where effort is force in N, mass in kg = 1000 · coefficient. At
    standstill 0. Source: P0 section 2.2.
    """
    return acceleration_mm_s2


def cross_coupling(other_acceleration_mm_s2: Array) -> Array:
    """Another axis' acceleration loads this one: column a of that axis [mm/s²], (n,).

    Effort = coefficient · a_other. It acts on a standing axis too.
    Source: P0 section 2.2 (serial kinematics: one axis carries the other).
    """
    return other_acceleration_mm_s2


def tilt(angle_deg: Array) -> Array:
    """Weight off the axis of rotation: columns cos θ and sin θ of the angle [deg], (n, 2).

    It acts in motion and at standstill, with the same sign in both directions. Source: P4 (static
    tilts).
    """
    angle = np.radians(angle_deg)
    return np.column_stack([np.cos(angle), np.sin(angle)])


def gravity(position_mm: Array) -> Array:
    """A constant load acts whether the axis moves or stands: column 1, shaped as position, (n,).

    Weight of a vertical axis, a counterweight, or a constant sensor offset: one recording of a
    horizontal axis cannot distinguish them. Source: P2 (weight as the mean of up and down passes).
    """
    return np.ones_like(position_mm)


def spring(position_mm: Array, *, rest_mm: float) -> Array:
    """A restoring load grows with the way from its rest: column x − x_r [mm], (n,).

    Effort = stiffness · column, also at standstill, the same sign in both directions.
    Source: P0 section 2.2, k (s − s_r).
    """
    return position_mm - rest_mm


def cogging(position_mm: Array, *, period_mm: float) -> Array:
    """A load periodic in position: columns cos and sin of 2πx/period, (n, 2).

    Effort = cosine · cos + sine · sin, also at standstill, the same sign in both directions;
    amplitude = √(cosine² + sine²). One instance a harmonic. Source: P0 section 2.2, F_co (look-up
    table there; a Fourier series is its harmonics).
    """
    angle = 2.0 * np.pi * position_mm / period_mm
    return np.column_stack([np.cos(angle), np.sin(angle)])


def friction_ripple(direction: Array, position_mm: Array, *, period_mm: float) -> Array:
    """Friction periodic in position: sgn(v)·cos and sgn(v)·sin of 2πx/period, (n, 2).

    Effort flips with the direction, which distinguishes it from cogging; 0 at standstill.
    Source: by construction, P2 eq. 12 with a periodic friction along x.
    """
    return direction[:, None] * cogging(position_mm, period_mm=period_mm)


def compliance(
    acceleration_mm_s2: Array, t_s: Array, *, frequency_hz: float, damping: float
) -> Array:
    """The load hangs on a spring: column a_load − a_motor [mm/s²], (n,).

    a_load = ω²/(s² + 2ζωs + ω²) · a_motor (bilinear transform), ω = 2π·frequency. Effort =
    coefficient · column, coefficient the load's inertia: with the inertia term the motor moves
    M·a_motor + M_load·(a_load − a_motor). 0 in steady motion and at standstill. Even sampling;
    after a gap of the clock the load is at rest on its spring.
    Source: two-mass model of a feed drive; named as the gap of the rigid model in Janot 2019.
    """
    from scipy import signal

    rate_hz = 1.0 / step_s(t_s)
    omega = 2.0 * np.pi * frequency_hz
    b, a = signal.bilinear([omega**2], [1.0, 2.0 * damping * omega, omega**2], fs=rate_hz)
    swings = by_run(lambda own: signal.lfilter(b, a, own), acceleration_mm_s2, t_s)
    return np.asarray(swings, dtype=np.float64) - acceleration_mm_s2


def external_load(t_s: Array, *, start_s: float, end_s: float) -> Array:
    """A load that no motion explains acts during an interval: column 1 in [start, end], else 0.

    Source: P0 section 2.2, F_ext.
    """
    return ((t_s >= start_s) & (t_s <= end_s)).astype(np.float64)


def external_load_edged(t_s: Array, *, start_s: float, end_s: float) -> Array:
    """A load acts during an interval, with edges that a search can follow: column 1 inside, (n,).

    The edges last EDGE_S; half the load is there at start and end. Also at standstill.
    Source: P0 section 2.2, F_ext.
    """
    rise = np.clip((t_s - start_s) / EDGE_S + 0.5, 0.0, 1.0)
    fall = np.clip((end_s - t_s) / EDGE_S + 0.5, 0.0, 1.0)
    return np.minimum(rise, fall)


def windage(velocity_rpm: Array) -> Array:
    """Air and oil churned by a spindle: column n·|n| [rpm²], (n,); 0 at standstill.

    Effort = coefficient · column. Source: by construction, drag of a turning body ∝ speed².
    """
    return velocity_rpm * np.abs(velocity_rpm)


INERTIA = Contribution(
    name="inertia",
    title="accelerated mass",
    channels=("axis", "rotary", "spindle"),
    inputs=("acceleration",),
    function=inertia,
    coefficients=(TermParameter("coefficient", "U·s²/mm", "effort per acceleration", lower=0.0),),
    needs=("position",),
    statement="Mass that must be accelerated.",
    excited_by="accelerated moves: rapids with dwells",
    source="P0 section 2.2; Janot, Gautier, Brunot 2019",
    check="Check what lies on the slide and what mass the model was identified with; a heavier "
    "fixture or work may be the cause, and moves at another acceleration without cutting show it.",
    check_source="P0 section 2.2, eq. 7 to 10",
    belongs_to="machine",
    any_moves=True,
)
CROSS_COUPLING = Contribution(
    name="cross_coupling",
    title="the pull of another axis",
    channels=("axis",),
    inputs=("other_acceleration",),
    function=cross_coupling,
    coefficients=(TermParameter("coefficient", "U·s²/mm", "effort per acceleration of that axis"),),
    needs=("position", "another axis' position, like 'y.position'"),
    statement="The acceleration of another axis loads this axis.",
    excited_by="accelerated moves of the other axis while this one stands",
    source="P0 section 2.2 (serial kinematics)",
    check="Check whether the other axis carries this one, how square the two are, and how stiff "
    "the machine's feet stand; the other axis' acceleration pulls here, and moving it alone shows "
    "how much.",
    check_source="P0 section 2.2, eq. 2; ISO 230-1 for squareness",
    belongs_to="machine",
)
GRAVITY = Contribution(
    name="gravity",
    title="a constant load",
    channels=("axis",),
    inputs=("position",),
    function=gravity,
    coefficients=(TermParameter("level", "U", "constant load, also at standstill"),),
    needs=(),
    statement="A constant load in one direction: weight, counterweight or a sensor's zero point.",
    excited_by="passes in both directions and a standstill",
    source="P2 section on the weight current",
    alike=("sensor_drift",),
    distinguished_by="Log the current once more with the drive disabled: a sensor's zero "
    "point stays.",
    check="Check the counterweight or brake of a tilted or hanging axis, the weight that it "
    "carries, and the zero of the current sensor; a constant load may be any of them, and the "
    "reading at standstill without drive enable tells the sensor.",
    check_source="P2 section III.B; P1 section 8",
    belongs_to="machine",
    any_moves=True,
)
TILT = Contribution(
    name="gravity",
    form="tilt",
    title="a weight that turns with the axis",
    channels=("rotary",),
    inputs=("position",),
    function=tilt,
    coefficients=(
        TermParameter("cosine", "U", "load at 0 degrees"),
        TermParameter("sine", "U", "load at 90 degrees"),
    ),
    needs=("angle",),
    statement="The weight of a table or its work, off the axis of rotation: once a revolution.",
    excited_by="slow passes in both directions over as much of a revolution as there is",
    source="P4 (static tilts); P0 section 2.2, F_co",
    belongs_to="machine",
    any_moves=True,
)
SPRING = Contribution(
    name="spring",
    title="a spring load",
    channels=("axis",),
    inputs=("position",),
    function=spring,
    coefficients=(TermParameter("stiffness", "U/mm", "load per distance from rest"),),
    shape=(
        TermParameter(
            "rest", "mm", "position without load", -1e4, 1e4,
            prior=ParameterPrior(0.0, 1e3, "chosen: within a metre of the axis' zero"),
            keyword="rest_mm", starts=(0.0,), given=True,
        ),
    ),
    needs=("position",),
    statement="A spring-like load: it grows along the travel, with the same sign both ways.",
    excited_by="constant-speed passes over the whole travel in both directions",
    source="P0 section 2.2, k (s − s_r)",
    check="Check cable carriers, hoses and guideway covers for pull towards one end of the travel; "
    "a load that grows with position may come from them, and slow passes both ways show it in "
    "their mean.",
    check_source="P0 section 2.2",
    belongs_to="machine",
)  # fmt: skip
COGGING = Contribution(
    name="cogging",
    title="cogging of the motor",
    channels=("axis", "rotary"),
    inputs=("position",),
    function=cogging,
    coefficients=(
        TermParameter("cosine", "U", "cosine part of the ripple"),
        TermParameter("sine", "U", "sine part of the ripple"),
    ),
    shape=(
        TermParameter(
            "period", "mm", "distance from crest to crest", 1e-4, 1e4, keyword="period_mm"
        ),
    ),
    needs=("position",),
    statement="A ripple along the travel that keeps its sign in both directions: magnets or screw.",
    excited_by="slow constant-speed passes over many periods in both directions",
    source="P0 section 2.2, F_co",
    check="Check whether the ripple's period is the magnets' pole pitch or a turn of the screw, "
    "and whether the control's compensation is on; slow passes over the travel show the period.",
    check_source="P0 section 2.2; Altintas, Verl, Brecher, Uriarte and Pritschow, CIRP Annals 60 "
    "(2011), 779-796",
    belongs_to="machine",
)
FRICTION_RIPPLE = Contribution(
    name="position_friction",
    form="periodic",
    channels=("axis", "rotary"),
    inputs=("direction", "position"),
    function=friction_ripple,
    coefficients=(
        TermParameter("cosine", "U", "cosine part of the ripple"),
        TermParameter("sine", "U", "sine part of the ripple"),
    ),
    shape=(
        TermParameter(
            "period", "mm", "distance from crest to crest", 1e-4, 1e4, keyword="period_mm"
        ),
    ),
    modifies=("coulomb",),
    needs=("position",),
    statement="Friction goes up and down along the travel: a ripple that flips with the direction.",
    excited_by="slow constant-speed passes over many periods in both directions",
    source="P2 eq. 12, made periodic",
    belongs_to="machine",
    friction=True,
)
COMPLIANCE = Contribution(
    name="compliance",
    title="a springy drive train",
    channels=("axis", "rotary"),
    inputs=("acceleration", "t"),
    function=compliance,
    coefficients=(TermParameter("coefficient", "U·s²/mm", "inertia behind the spring", lower=0.0),),
    shape=(
        TermParameter(
            "frequency", "Hz", "natural frequency of the load on its spring", 2.0, 500.0,
            keyword="frequency_hz", starts=(8.0, 20.0, 50.0, 100.0),
        ),
        TermParameter(
            "damping", "1", "damping ratio", 0.001, 1.0,
            prior=ParameterPrior(0.05, 0.05, "chosen: screws and belts are lightly damped"),
            keyword="damping", starts=(0.05,),
        ),
    ),
    needs=("position",),
    statement="Screw or belt gives way: the load swings behind the motor when the axis jerks.",
    excited_by="sharp accelerations with dwells between them",
    source="two-mass model; Janot, Gautier, Brunot 2019 name it as left out",
    check="Check coupling, screw bearings and nut for looseness, and the scale's reading against "
    "the motor's; a drive train may give between motor and slide, and a move at another jerk shows "
    "its resonance.",
    check_source="Altintas, Verl, Brecher, Uriarte and Pritschow, CIRP Annals 60 (2011), 779-796",
    belongs_to="machine",
    remembers=True,
)  # fmt: skip
EXTERNAL_LOAD = Contribution(
    name="external_load",
    title="a load from outside",
    channels=("axis",),
    inputs=("t",),
    function=external_load_edged,
    coefficients=(TermParameter("level", "U", "mean load in the interval"),),
    shape=(
        TermParameter("start", "s", "begin of the interval", keyword="start_s"),
        TermParameter("end", "s", "end of the interval", keyword="end_s"),
    ),
    needs=(),
    statement="A load that no motion explains, while it lasts: a cut, a push, a rub.",
    excited_by="the same moves again without the load",
    source="P0 section 2.2, F_ext",
    check="Check what the machine did in that interval; a cut, a chip jammed under a cover, a "
    "clamp or a collision may have loaded the axis, and the same move without it shows.",
    check_source="P0 section 2.2, eq. 1",
)
WINDAGE = Contribution(
    name="windage",
    title="air drag of the spindle",
    channels=("spindle",),
    inputs=("velocity",),
    function=windage,
    coefficients=(TermParameter("coefficient", "U/rpm²", "effort per speed squared", lower=0.0),),
    needs=("spindle.speed",),
    statement="Air and oil that the spindle churns: drag that grows with the square of speed.",
    excited_by="steady running at speeds from the lowest to the highest",
    source="by construction (drag ∝ speed²)",
    check="Check the spindle's load while it idles at several speeds, with and without the tool; "
    "losses that grow with the square of speed or so are air and bearings, and a large cutter or "
    "chuck adds to them.",
    check_source="P1 section 9",
    belongs_to="machine",
    any_moves=True,
)

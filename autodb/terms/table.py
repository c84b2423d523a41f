"""Force measured on a rotating table: what is not the process, for one component of the sensor.

Inputs, (n,): `angle_x`, `angle_z` the angles of the two rotary axes [rad], a.angle and c.angle;
`omega_x` … `omega_z` [rad/s] and `alpha_x` … `alpha_z` [rad/s²] the table's angular velocity and
acceleration in the measuring frame; `cutting` 1 while chips are made, else 0; `t` [s];
`other_force` the force of another component [N]. Machine to measuring frame:
T = T_z(θ_z)·T_x(θ_x), P4 eq. 1-2. Each term has one form a component; the angles and rates of the
others are its inputs in turn.
"""

import numpy as np
from numpy.typing import NDArray

from autodb.terms._memory import first_order
from autodb.terms.term import Contribution, ParameterPrior, TermParameter

Array = NDArray[np.float64]

G_M_S2 = 9.80665
"""Standard acceleration of gravity, m/s², as the third CGPM fixed it in 1901."""


def table_gravity_x(angle_x_rad: Array, angle_z_rad: Array) -> Array:
    """Weight on a tilted table along x: column g sin θ_z sin θ_x [m/s²], (n,); force = mass · it.

    Source: P4 eq. 5, first row of T (0, 0, m g).
    """
    return np.asarray(G_M_S2 * np.sin(angle_z_rad) * np.sin(angle_x_rad))


def table_gravity_y(angle_x_rad: Array, angle_z_rad: Array) -> Array:
    """Weight on a tilted table along y: column −g cos θ_z sin θ_x [m/s²], (n,); force = mass · it.

    Source: P4 eq. 5, second row of T (0, 0, m g).
    """
    return np.asarray(-G_M_S2 * np.cos(angle_z_rad) * np.sin(angle_x_rad))


def table_gravity_z(angle_x_rad: Array) -> Array:
    """Weight on a tilted table along z, tared upright: columns g(cos θ_x − 1) and g [m/s²], (n, 2).

    Force = mass · g(cos θ_x − 1) + added · g, added = m − m_0 the mass put on since taring [kg].
    Source: P4 eq. 5, m g cos θ_x − m_0 g.
    """
    return np.column_stack(
        [G_M_S2 * (np.cos(angle_x_rad) - 1.0), np.full_like(angle_x_rad, G_M_S2)]
    )


def table_inertia(
    omega_i: Array, omega_j: Array, omega_k: Array, alpha_j: Array, alpha_k: Array
) -> Array:
    """A turning mass off the centre pulls: columns of component i, (i, j, k) in turn, (n, 3).

    F_i = m [ω × (ω × r) + ω̇ × r]_i is linear in r; ω [rad/s], ω̇ [rad/s²] in the measuring frame:
    −(ω_j² + ω_k²) · m r_i + (ω_i ω_j − ω̇_k) · m r_j + (ω_i ω_k + ω̇_j) · m r_k, the coefficients
    m r in kg·m. A component along the rotation axis shows only under acceleration about another.
    Source: P4 eq. 6 and 7, signs as printed (F_M is the supporting force).
    """
    return np.column_stack(
        [
            -(omega_j**2 + omega_k**2),
            omega_i * omega_j - alpha_k,
            omega_i * omega_k + alpha_j,
        ]
    )


def thermal_drift(cutting: Array, t_s: Array, *, time_constant_s: float) -> Array:
    """Chips heat the sensor: column u, T·du/dt = cutting − u, 0 cold and 1 hot, (n,).

    Force = level · u: it rises while ``cutting`` is 1 and relaxes when cutting stops; u = 0 at the
    first row. Even sampling; over a gap of the clock it cuts as before. Source: P4 section 5 names
    the effect and leaves it out; first-order heating is chosen.
    """
    return first_order(cutting, t_s, time_constant_s=time_constant_s, meanwhile=cutting)


def crosstalk(other_force_N: Array) -> Array:
    """A sensor's component shows a share of another: column that component's force [N], (n,).

    Force = share · F_other. Source: by construction, a three-component sensor.
    """
    return other_force_N


_MASS = TermParameter("mass", "kg", "effective mass on the sensor (U in N)", lower=0.0)
_MOMENT = {
    axis: TermParameter(f"moment_{axis}", "kg·m", f"mass times the {axis} of its centre (U in N)")
    for axis in "xyz"
}
_ANGLES = ("a.angle", "c.angle")
_TILTS = "static tilts of the table over its whole range, sensor tared upright"
_TURNS = "fast turns of each rotary axis in air, with sharp starts and stops"

TABLE_GRAVITY_X = Contribution(
    name="table_gravity",
    title="weight on the table",
    form="x",
    channels=("table",),
    inputs=("angle_x", "angle_z"),
    function=table_gravity_x,
    coefficients=(_MASS,),
    needs=_ANGLES,
    statement="Weight of work, fixture and sensor shows in x when the table tilts.",
    excited_by=_TILTS,
    source="P4 eq. 5",
    check="Check mass and centre of what is clamped on the table, and at which angles the sensor "
    "was tared; weight turns with the table, and standing at several tilts without cutting shows "
    "it.",
    check_source="P4 sections 2 and 4",
)
TABLE_GRAVITY_Y = Contribution(
    name="table_gravity",
    form="y",
    channels=("table",),
    inputs=("angle_x", "angle_z"),
    function=table_gravity_y,
    coefficients=(_MASS,),
    needs=_ANGLES,
    statement="Weight of work, fixture and sensor shows in y when the table tilts.",
    excited_by=_TILTS,
    source="P4 eq. 5",
)
TABLE_GRAVITY_Z = Contribution(
    name="table_gravity",
    form="z",
    channels=("table",),
    inputs=("angle_x",),
    function=table_gravity_z,
    coefficients=(_MASS, TermParameter("added", "kg", "mass put on since taring")),
    needs=_ANGLES,
    statement="Weight of work, fixture and sensor shows in z when the table tilts.",
    excited_by=_TILTS,
    source="P4 eq. 5",
)
TABLE_INERTIA_X = Contribution(
    name="table_inertia",
    title="inertia of the table",
    form="x",
    channels=("table",),
    inputs=("omega_x", "omega_y", "omega_z", "alpha_y", "alpha_z"),
    function=table_inertia,
    coefficients=(_MOMENT["x"], _MOMENT["y"], _MOMENT["z"]),
    needs=_ANGLES,
    statement="A mass off the centre of rotation pulls in x while the table turns.",
    excited_by=_TURNS,
    source="P4 eq. 6 and 7",
    check="Check the mass on the table and its distance from the rotary axes; a turning table "
    "pulls with speed and acceleration, and turning without cutting shows it.",
    check_source="P4 sections 2 and 5.1",
)
TABLE_INERTIA_Y = Contribution(
    name="table_inertia",
    form="y",
    channels=("table",),
    inputs=("omega_y", "omega_z", "omega_x", "alpha_z", "alpha_x"),
    function=table_inertia,
    coefficients=(_MOMENT["y"], _MOMENT["z"], _MOMENT["x"]),
    needs=_ANGLES,
    statement="A mass off the centre of rotation pulls in y while the table turns.",
    excited_by=_TURNS,
    source="P4 eq. 6 and 7",
)
TABLE_INERTIA_Z = Contribution(
    name="table_inertia",
    form="z",
    channels=("table",),
    inputs=("omega_z", "omega_x", "omega_y", "alpha_x", "alpha_y"),
    function=table_inertia,
    coefficients=(_MOMENT["z"], _MOMENT["x"], _MOMENT["y"]),
    needs=_ANGLES,
    statement="A mass off the centre of rotation pulls in z while the table turns.",
    excited_by=_TURNS,
    source="P4 eq. 6 and 7",
)
THERMAL_DRIFT = Contribution(
    name="thermal_drift",
    title="heat drift of the sensor",
    channels=("table",),
    inputs=("cutting", "t"),
    function=thermal_drift,
    coefficients=(TermParameter("level", "U", "reading of the hot sensor after long cutting"),),
    shape=(
        TermParameter(
            "time_constant", "s", "time to heat by 63 %", 1.0, 10_000.0,
            prior=ParameterPrior(100.0, 100.0, "chosen: minutes, as a sensor of kilograms takes"),
            keyword="time_constant_s", starts=(10.0, 30.0, 100.0, 300.0),
        ),
    ),
    needs=(),
    statement="Chips heat the sensor: its zero wanders while it cuts and comes back at rest.",
    excited_by="cutting and pauses in turn, each of some minutes",
    source="P4 section 5 (heat of chips, left unmodelled there)",
    alike=("sensor_drift",),
    distinguished_by="Pause the cutting for some minutes: heat drift comes back, the "
    "clock's goes on.",
    check="Check whether hot chips or coolant lie on the sensor; a force that rises while chips "
    "fall on it and relaxes afterwards may be heat, and the reading some minutes after the cut "
    "shows it.",
    check_source="P4 section 5.2",
    sits=("sensor",),
    remembers=True,
)  # fmt: skip
CROSSTALK = Contribution(
    name="crosstalk",
    title="crosstalk between force components",
    channels=("table",),
    inputs=("other_force",),
    function=crosstalk,
    coefficients=(
        TermParameter(
            "share", "1", "reading per force of the other component", -1.0, 1.0,
            prior=ParameterPrior(0.0, 0.03, "chosen: some percent"),
        ),
    ),
    needs=("force of the other component",),
    statement="This component of the sensor shows a share of another one's force.",
    excited_by="a push along each axis of the sensor alone",
    source="by construction (three-component sensor)",
    check="Check how the sensor was levelled, clamped and calibrated; one component that shows in "
    "another may be its crosstalk or a tilt, and a known load along one direction at a time shows "
    "it.",
    check_source="Shaw, Metal Cutting Principles, 2nd ed. (2005), chapter 7",
    sits=("sensor", "calibration"),
)  # fmt: skip

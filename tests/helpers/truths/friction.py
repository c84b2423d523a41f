"""Friction as it is on machines: rounded, dipped, tabulated, slipping element by element."""

import numpy as np

from tests.helpers.truths import Array, Truth, motion, truth

NOISE = 0.02
"""Share of the channel's rms: chosen, some percent as drive currents have."""
LEVEL, DRAG, MASS, WEIGHT = 20.0, 0.05, 0.01, 8.0


def creep() -> dict[str, Array]:
    """Passes both ways at eight speeds from creep to rapid, with standstills between."""
    speeds = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
    legs = [leg for v in speeds for leg in ((v, 1.2), (0.0, 0.2), (-v, 1.2), (0.0, 0.2))]
    return motion(legs, rate_hz=150.0, ramp_s=0.1)


def travel() -> dict[str, Array]:
    """Passes over 300 mm both ways at three speeds."""
    legs = [leg for v in (100.0, 60.0, 150.0) for leg in ((v, 300 / v), (-v, 300 / v), (0.0, 0.5))]
    return motion(legs, rate_hz=200.0, ramp_s=0.1)


def sense(m: dict[str, Array]) -> Array:
    """Direction of motion, rounded as a stick-slip-free guideway is."""
    return np.tanh(m["velocity"] / 0.02)


def base(m: dict[str, Array]) -> dict[str, Array]:
    """The loads that every axis has."""
    return {
        "coulomb": LEVEL * sense(m),
        "viscous": DRAG * m["velocity"],
        "inertia": MASS * m["acceleration"],
        "gravity": np.full_like(m["t"], WEIGHT),
    }


def without(loads: dict[str, Array], name: str) -> dict[str, Array]:
    """The other loads."""
    return {key: load for key, load in loads.items() if key != name}


def coulomb() -> Truth:
    """Dry friction that rises over a little speed."""
    m = creep()
    effect = LEVEL * np.tanh(m["velocity"] / 0.05)
    return truth("coulomb", m, without(base(m), "coulomb"), effect, within=0.03, noise=NOISE,
                 main=("level", LEVEL, 0.02))  # fmt: skip


def viscous() -> Truth:
    """An oil film that thins: a power of speed a little below one."""
    m = creep()
    v = m["velocity"]
    effect = 0.2 * np.sign(v) * 100.0 * (np.abs(v) / 100.0) ** 0.95
    return truth("viscous", m, without(base(m), "viscous"), effect, within=0.05, noise=NOISE,
                 main=("coefficient", 0.2, 0.05))  # fmt: skip


def stribeck() -> Truth:
    """A rational dip: half of it is left at 6 mm/s, 1/e at 7.86."""
    m = creep()
    effect = 12.0 * sense(m) / (1.0 + (m["velocity"] / 6.0) ** 2)
    return truth("stribeck", m, base(m), effect, within=0.15, noise=NOISE,
                 main=("speed", 6.0 * np.sqrt(np.e - 1.0), 0.2),
                 modulo=("coulomb", "viscous"))  # fmt: skip


def asymmetry() -> Truth:
    """A table of two frictions, one a direction."""
    m = creep()
    v, plain = m["velocity"], base(m)
    both = np.where(v > 0, 23.0 * sense(m) + 0.06 * v, 17.0 * sense(m) + 0.04 * v)
    effect = both - plain["coulomb"] - plain["viscous"]
    return truth("asymmetry", m, plain, effect, within=0.1, noise=NOISE,
                 main=("level", 3.0, 0.1))  # fmt: skip


def position_friction() -> Truth:
    """A way cover that drags more and more: softplus along the travel."""
    m = travel()
    effect = 0.06 * 80.0 * np.log1p(np.exp((m["position"] - 120.0) / 80.0)) * sense(m)
    return truth("position_friction", m, base(m), effect, within=0.3, noise=NOISE,
                 modulo=("coulomb",))  # fmt: skip


def friction_ripple() -> Truth:
    """A bent screw: a triangle wave of friction every 10 mm."""
    m = travel()
    phase = m["position"] / 10.0 % 1.0
    effect = 3.0 * (4.0 * np.abs(phase - 0.5) - 1.0) * sense(m)
    waves = np.arange(5.0, 60.0, 0.25)
    return truth("position_friction periodic", m, base(m), effect, within=0.2, noise=NOISE,
                 main=("period", 10.0, 0.002), begin_at={"period": tuple(300.0 / waves)},
                 modulo=("coulomb",))  # fmt: skip


def presliding() -> Truth:
    """Generalised Maxwell slip: two elastic elements that slip at their own levels."""
    t = np.arange(0.0, 16.0, 1.0 / 200.0)
    x = 0.3 * np.sin(2 * np.pi * 0.25 * t) * (1.0 + 0.5 * np.sin(2 * np.pi * 0.06 * t))
    v = np.gradient(x, t)
    m = {"t": t, "position": x, "velocity": v, "acceleration": np.gradient(v, t)}
    force = slipping(x, level=12.0, way=0.015) + slipping(x, level=8.0, way=0.05)
    loads = base(m)
    return truth("presliding", m, loads, force - loads["coulomb"], within=0.35, noise=NOISE)


def slipping(x: Array, *, level: float, way: float) -> Array:
    """Force (n,) of a spring that slips when it is bent by ``way``, where it carries ``level``."""
    bent, out = 0.0, np.zeros_like(x)
    for i, step in enumerate(np.diff(x), start=1):
        bent = min(way, max(-way, bent + step))
        out[i] = level * bent / way
    return out


def backlash() -> Truth:
    """A play operator: the load stands while the motor crosses the gap, its friction with it."""
    legs = [leg for v in (0.5, 1.0, 2.0, 0.7) for leg in ((v, 2.0), (-v, 2.0))]
    m = motion(legs, rate_hz=200.0, ramp_s=0.05)
    load = played(m["position"], gap=0.12)
    moves = np.abs(np.diff(load, prepend=load[0])) > 1e-9
    effect = 6.0 * np.where(moves, sense(m), 0.0) - 6.0 * sense(m)
    return truth("backlash", m, base(m), effect, within=0.3, noise=NOISE,
                 main=("gap", 0.12, 0.1))  # fmt: skip


def played(x: Array, *, gap: float) -> Array:
    """Position (n,) of a load that the motor pushes at either end of a gap."""
    out = np.empty_like(x)
    load = x[0] - gap / 2
    for i, at in enumerate(x):
        load = min(max(load, at - gap / 2), at + gap / 2)
        out[i] = load
    return out


TRUTHS = (
    coulomb, viscous, stribeck, asymmetry, position_friction, friction_ripple, presliding, backlash,
)  # fmt: skip

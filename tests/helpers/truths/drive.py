"""Loads, warming and sensors as they are on machines."""

import numpy as np

from tests.helpers.truths import Array, Truth, motion, total, truth
from tests.helpers.truths.friction import (
    DRAG,
    LEVEL,
    MASS,
    NOISE,
    base,
    creep,
    sense,
    travel,
    without,
)


def gravity() -> Truth:
    """A weight whose counterbalance is a little uneven along the travel."""
    m = travel()
    effect = 8.0 * (1.0 + 0.03 * np.sin(m["position"] / 40.0))
    return truth("gravity", m, without(base(m), "gravity"), effect, within=0.05, noise=NOISE,
                 main=("level", 8.0, 0.03))  # fmt: skip


def tilt() -> Truth:
    """A table whose weight lies off the axis, with a hose that pulls a little."""
    m = travel()
    angle = np.radians(m["position"])
    effect = 9.0 * np.cos(angle - 0.7) + 0.2 * np.cos(3.0 * angle)
    return truth("gravity tilt", m, without(base(m), "gravity"), effect, within=0.1, noise=NOISE)


def spring() -> Truth:
    """A cable drag that stiffens: linear and cubic from its rest."""
    m = travel()
    way = m["position"] - 110.0
    effect = 0.05 * way + 2e-7 * way**3
    return truth("spring", m, without(base(m), "gravity"), effect, within=0.1, noise=NOISE,
                 main=("rest", 110.0, 0.1))  # fmt: skip


def cogging() -> Truth:
    """Magnets every 23 mm with a second harmonic, weaker towards one end."""
    m = travel()
    angle = 2 * np.pi * m["position"] / 23.0
    effect = (3.0 * np.cos(angle + 0.4) + 0.5 * np.cos(2 * angle)) * (1 + 0.0005 * m["position"])
    waves = np.arange(5.0, 60.0, 0.25)
    return truth("cogging", m, base(m), effect, within=0.25, noise=NOISE,
                 main=("period", 23.0, 0.005),
                 begin_at={"period": tuple(300.0 / waves)})  # fmt: skip


def _magnets(position: Array, *, width: float) -> Array:
    """Two teeth a pole of 23 mm, pushing one way and the other, less their mean."""
    place = np.arange(0.0, 23.0, 0.05)

    def pole(at: Array) -> Array:
        off = [(at - where + 11.5) % 23.0 - 11.5 for where in (5.0, 13.0)]
        return np.asarray(np.exp(-((off[0] / width) ** 2)) - 0.7 * np.exp(-((off[1] / width) ** 2)))

    return np.asarray(pole(position) - pole(place).mean())


def cogging_table() -> Truth:
    """Narrow magnetic teeth, weaker towards one end."""
    m = travel()
    effect = 6.0 * _magnets(m["position"], width=1.5) * (1 + 0.0005 * m["position"])
    waves = np.arange(12.0, 14.0, 0.05)
    return truth("cogging table", m, base(m), effect, within=0.25, noise=NOISE,
                 main=("period", 23.0, 0.005),
                 begin_at={"period": tuple(300.0 / waves)})  # fmt: skip


def cogging_harmonics() -> Truth:
    """Broad magnetic teeth, weaker towards one end."""
    m = travel()
    effect = 6.0 * _magnets(m["position"], width=5.0) * (1 + 0.0005 * m["position"])
    waves = np.arange(12.0, 14.0, 0.05)
    return truth("cogging harmonics", m, base(m), effect, within=0.25, noise=NOISE,
                 main=("period", 23.0, 0.005),
                 begin_at={"period": tuple(300.0 / waves)})  # fmt: skip


def inertia() -> Truth:
    """A mass and a rotor; the effective mass changes a little along the travel."""
    m = travel()
    effect = 0.03 * (1.0 + 0.03 * np.sin(m["position"] / 50.0)) * m["acceleration"]
    return truth("inertia", m, without(base(m), "inertia"), effect, within=0.08, noise=NOISE,
                 main=("coefficient", 0.03, 0.03))  # fmt: skip


def cross_coupling() -> Truth:
    """The carried axis is sensed a little later than it accelerates."""
    m = creep()
    t = m["t"]

    def other(at: Array) -> Array:
        return np.asarray(900.0 * np.sin(2 * np.pi * 0.7 * at) ** 7)

    inputs = {**m, "y.acceleration": other(t)}
    return truth("cross_coupling", inputs, base(m), 0.012 * other(t - 0.004), within=0.15,
                 noise=NOISE, main=("coefficient", 0.012, 0.05), of="y")  # fmt: skip


def warmup() -> Truth:
    """Friction work heats, oil thins exponentially with heat, cooling is slower than heating."""
    passes = [(120.0, 2.5), (-120.0, 2.5)]
    legs = [*passes * 40, (0.0, 120.0), *[(60.0, 2.5), (-60.0, 2.5)] * 20, *passes * 20]
    m = motion(legs, rate_hz=10.0, ramp_s=0.3)
    loads = base(m)
    friction = loads["coulomb"] + loads["viscous"]
    warm, share = 0.0, np.empty_like(friction)
    for i, power in enumerate(np.abs(friction * m["velocity"]) / 4000.0):
        share[i] = 0.17 * -np.expm1(-3.0 * warm)
        heat = (1.0 - share[i]) * power
        warm += 0.1 * ((heat - warm) / 60.0 if heat > warm else (heat - warm) / 100.0)
    return truth("warmup", m, loads, -share * friction, within=0.25, noise=NOISE)


def compliance() -> Truth:
    """Two masses on a spring with a damper between them, integrated step by step."""
    legs = [leg for v in (80.0, 140.0) for leg in ((v, 0.8), (0.0, 0.8), (-v, 0.8), (0.0, 0.8))]
    m = motion(legs * 2, rate_hz=400.0, ramp_s=0.02)
    omega, damping, fine = 2 * np.pi * 15.0, 0.04, 10
    step = 1.0 / 400.0 / fine
    at = np.arange(len(m["t"]) * fine) * step
    x, v = np.interp(at, m["t"], m["position"]), np.interp(at, m["t"], m["velocity"])
    place, speed, pull = 0.0, 0.0, np.empty_like(at)
    for i, (motor, quick) in enumerate(zip(x, v, strict=True)):
        pull[i] = omega**2 * (motor - place) + 2 * damping * omega * (quick - speed)
        speed += step * pull[i]
        place += step * speed
    effect = 0.006 * (pull[::fine] - m["acceleration"])
    return truth("compliance", m, base(m), effect, within=0.2, noise=NOISE,
                 main=("frequency", 15.0, 0.03))  # fmt: skip


def external_load() -> Truth:
    """A cut: it sets in over some tenths of a second and chatters a little."""
    m = travel()
    t = m["t"]
    flank = np.clip(np.minimum(t - 6.0, 11.0 - t) / 0.3 + 0.5, 0.0, 1.0)
    effect = 15.0 * (1 - np.cos(np.pi * flank)) / 2 * (1 + 0.1 * np.sin(40.0 * t))
    when = tuple(np.arange(0.5, 17.0, 1.5))
    return truth("external_load", m, base(m), effect, within=0.2, noise=NOISE,
                 main=("level", 15.0, 0.05), begin_at={"start": when, "end": when})  # fmt: skip


def windage() -> Truth:
    """A fan in a housing: drag with the power 1.9 of speed."""
    legs = [(n, 2.0) for n in (500.0, 1500.0, 3000.0, 4500.0, 6000.0, 2000.0, -3000.0, -6000.0)]
    m = motion(legs, rate_hz=100.0, ramp_s=0.5)
    v = m["velocity"]
    loads = {"coulomb": 1.5 * np.tanh(v / 20.0), "inertia": 4e-4 * m["acceleration"]}
    effect = 6.0 * np.sign(v) * np.abs(v / 6000.0) ** 1.9
    return truth("windage", m, loads, effect, within=0.1, noise=NOISE,
                 main=("coefficient", 6.0 / 6000.0**2, 0.05))  # fmt: skip


def sensor_drift() -> Truth:
    """A zero point that settles as electronics warm: an exponential."""
    m = creep()
    effect = 6.0 * (1.0 - np.exp(-m["t"] / 25.0))
    return truth("sensor_drift", m, base(m), effect, within=0.1, noise=NOISE, modulo=("gravity",))


def gain() -> Truth:
    """A magnet that warms: the constant approaches its end exponentially."""
    m = creep()
    t, loads = m["t"], base(m)
    factor = np.where(t > 10.0, -0.2 * (1.0 - np.exp(-(t - 10.0) / 5.0)), 0.0)
    effect = factor * total(loads)
    return truth("gain", m, loads, effect, within=0.2, noise=NOISE,
                 main=("factor", 1.0 + float(factor[-1]), 0.06),
                 begin_at={"start": (4.0, 8.0, 16.0, 24.0), "duration": (2.0, 10.0)})  # fmt: skip


def lag() -> Truth:
    """An effort sampled finely, stamped 13 ms late: no whole number of rows."""
    legs = [leg for v in (100.0, 60.0, 150.0) for leg in ((v, 2.0), (-v, 2.0), (0.0, 0.5))]
    fine = motion(legs, rate_hz=2000.0, ramp_s=0.1)
    late = {name: np.interp(fine["t"] - 0.013, fine["t"], of) for name, of in fine.items()}
    rows = slice(None, None, 10)
    m = {name: values[rows] for name, values in fine.items()}
    shifted = base({name: values[rows] for name, values in late.items()})
    loads = base(m)
    effect = total(shifted) - total(loads)
    return truth("lag", m, loads, effect, within=0.2, noise=NOISE, main=("delay", 0.013, 0.08))


def saturation() -> Truth:
    """An amplifier that rounds its limit."""
    m = travel()
    loads = base(m)
    wanted = total(loads) + 0.02 * m["acceleration"]
    limited = wanted / (1.0 + np.abs(wanted / 42.0) ** 16) ** (1 / 16)
    loads["inertia"] = (MASS + 0.02) * m["acceleration"]
    tops = tuple(float(q) for q in np.quantile(np.abs(limited), (0.9, 0.97, 0.999)))
    return truth("saturation", m, loads, limited - wanted, within=0.2, noise=NOISE,
                 main=("limit", 42.0, 0.03), begin_at={"limit": tops})  # fmt: skip


def lost_sign() -> Truth:
    """A rectifier with a soft foot."""
    m = creep()
    loads = {
        "coulomb": LEVEL * sense(m),
        "viscous": DRAG * m["velocity"],
        "inertia": MASS * m["acceleration"],
    }
    wanted = total(loads)
    effect = np.sqrt(wanted**2 + 0.5**2) - wanted
    return truth("lost_sign", m, loads, effect, within=0.1, noise=NOISE)


TRUTHS = (
    gravity, tilt, spring, cogging, cogging_table, cogging_harmonics, inertia, cross_coupling,
    warmup, compliance, external_load, windage, sensor_drift, gain, lag, saturation, lost_sign,
)  # fmt: skip

"""Axes of a truth that is written here: a sweep over speeds, and a mass that sticks on a spring."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from autodb.records.tables import Recording

Array = NDArray[np.float64]

RATE_HZ = 100.0
PITCH_MM = 10.0
POLE_MM = 24.0
MIDDLE_MM = 100.0
SPEEDS_MM_S = (1.0, 2.0, 4.0, 8.0, 16.0, 30.0, 60.0, 120.0)


def pole_shape(x: Array) -> Array:
    """Return cogging (n,) of size 1: as a pole has it, not one sine."""
    turn = 2.0 * np.pi * x / POLE_MM
    return np.asarray(np.sin(turn) + 0.6 * np.cos(2.0 * turn) + 0.4 * np.sin(3.0 * turn))


@dataclass(frozen=True)
class Axis:
    """A truth in A, mm, s: friction over speed and along the travel, weight, inertia, and by how
    much friction falls when the axis is warm at 10 000 mm/min.
    """

    weight: float = 2.0
    coulomb: float = 0.9
    stribeck: float = 0.3
    stribeck_mm_s: float = 2.0
    viscous: float = 0.002
    slope: float = 5e-4
    ripple: float = 0.03
    inertia: float = 3e-4
    drop: float = 0.0
    time_constant_s: float = 40.0
    stiffness: float = 0.0
    cogging: float = 0.0

    def load(self, x: Array) -> Array:
        """Return the load (n,) that is the same in both directions: weight, a line, and a pole's
        three harmonics.
        """
        return np.asarray(
            self.weight + self.stiffness * (x - MIDDLE_MM) + self.cogging * pole_shape(x)
        )

    def size(self, x: Array, v: Array) -> Array:
        """Return the size of friction (n,), cold."""
        dip = self.stribeck * np.exp(-((np.abs(v) / self.stribeck_mm_s) ** 2))
        place = self.slope * (x - MIDDLE_MM) + self.ripple * np.sin(2 * np.pi * x / PITCH_MM)
        return np.asarray(self.coulomb + dip + self.viscous * np.abs(v) + place)


def sweep(
    *, repeats: int = 3, speeds: tuple[float, ...] = SPEEDS_MM_S, cycles: int = 0
) -> tuple[Array, Array, Array]:
    """Return (x, v, number of the run) of passes there and back at each speed, cycles at the end.

    Slow passes go a turn of the screw around the middle, fast ones nearly the whole travel.
    """
    x, at, run = [np.full(50, MIDDLE_MM)], MIDDLE_MM, [np.zeros(50)]
    for number in range(repeats):
        for speed in speeds:
            half = 70.0 if speed > 8.0 else 7.0
            for target, pace in ((MIDDLE_MM - half, 45.0), (MIDDLE_MM + half, speed),
                                 (MIDDLE_MM - half, speed)):  # fmt: skip
                x.append(_moved(at, target, pace))
                run.append(np.full(len(x[-1]), float(number)))
                at = target
    for k in range(cycles):
        target = MIDDLE_MM + (70.0 if k % 2 == 0 else -70.0)
        x.append(_moved(at, target, speeds[-1]))
        run.append(np.full(len(x[-1]), float(repeats)))
        at = target
    place = np.concatenate(x)
    return place, np.gradient(place) * RATE_HZ, np.concatenate(run)


def _moved(start: float, target: float, speed: float) -> Array:
    """Return the way to a target at a speed (n,), with smooth ramps of 0.15 s and a dwell."""
    way = target - start
    if way == 0.0:
        return np.empty(0)
    t = np.arange(round((abs(way) / speed + 0.15) * RATE_HZ)) / RATE_HZ
    last = t[-1]
    u = np.clip(np.minimum(t, last - t) / 0.15, 0.0, 1.0)
    gone = np.cumsum(u * u * (3.0 - 2.0 * u))
    return np.concatenate([start + way * gone / gone[-1], np.full(30, target)])


def recorded(
    axis: Axis,
    seed: int,
    *,
    repeats: int = 3,
    speeds: tuple[float, ...] = SPEEDS_MM_S,
    cycles: int = 0,
    run_sd: float = 0.02,
) -> Recording:
    """Return a sweep of an axis as a drive logs it.

    A run is as a whole stiffer or easier, friction wanders along the way, and there is noise: so
    that repeats of a segment differ by a few percent.
    """
    rng = np.random.default_rng([seed, 5])
    x, v, run = sweep(repeats=repeats, speeds=speeds, cycles=cycles)
    t = np.arange(len(x)) / RATE_HZ
    gone = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(x)))])
    knots = np.arange(0.0, gone[-1] + 10.0, 5.0)
    wander = np.interp(gone, knots, 0.03 * rng.standard_normal(len(knots)))
    runs = run_sd * rng.standard_normal(int(run.max()) + 1)
    keep = np.exp(-1.0 / (RATE_HZ * axis.time_constant_s))
    heat = np.abs(v) * 60.0 / 10_000.0
    warm = lfilter([0.0, 1.0 - keep], [1.0, -keep], heat)
    moving = np.clip(v / 0.05, -1.0, 1.0)
    friction = moving * axis.size(x, v) * (1.0 - axis.drop * warm)
    friction *= 1.0 + runs[run.astype(int)] + wander
    effort = axis.load(x) + friction + axis.inertia * np.gradient(v) * RATE_HZ
    effort += 0.02 * rng.standard_normal(len(x))
    channels = {"t": t, "z.position": x, "z.velocity": v, "z.current": effort}
    return Recording(path=Path(f"sweep-{seed}.csv"), channels=channels)


@cache
def stick_slip(
    speeds: tuple[float, ...], seconds: float, *, rate_hz: float = 200.0
) -> tuple[Array, Array]:
    """Return where a mass is and what its spring bears, (n, k) each, the end pulled at k speeds.

    50 kg on 4000 N/mm: friction 200 N at rest falls to 120 N over 2 mm/s, and 1.5 N s/mm damp it;
    it sticks at low speeds, and runs smoothly where friction falls less than the damping grows.
    """
    step_s, mass_t = 2e-4, 0.05
    pull = np.array(speeds)
    x, v = np.zeros(len(pull)), np.zeros(len(pull))
    every = round(1.0 / (rate_hz * step_s))
    places, loads = [], []
    for k in range(round(seconds / step_s)):
        load = 4000.0 * (pull * k * step_s - x)
        drag = 120.0 + 80.0 * np.exp(-np.abs(v) / 2.0)
        driven = load - 1.5 * v
        stuck = (np.abs(v) < 1e-9) & (np.abs(driven) <= drag)
        sense = np.where(np.abs(v) < 1e-9, np.sign(driven), np.sign(v))
        new = v + step_s * np.where(stuck, 0.0, driven - sense * drag) / mass_t
        v = np.where(stuck | (new * sense < 0.0), 0.0, new)
        x = x + step_s * v
        if k % every == 0:
            places.append(x)
            loads.append(load)
    return np.array(places), np.array(loads)

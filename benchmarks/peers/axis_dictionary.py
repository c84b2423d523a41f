"""An expert's dictionary for an axis: every effect that could be hidden, at grids of its shapes.

A column is (term, text, values (n,)): the term of the vocabulary it stands for, or `unknown`. In
the texts v is velocity, a acceleration, s direction, x position, u way since a reversal, E the
simulated effort; others as in `Problem.inputs`.
"""

from collections.abc import Iterator

import numpy as np

from benchmarks.peers.problem import SIMULATED, Array, Problem

Column = tuple[str, str, Array]

FADING_MM_S = np.geomspace(1.0, 20.0, 8)
SETTLING_S = np.geomspace(5.0, 200.0, 6)
BUILDING_MM = np.geomspace(0.005, 0.2, 6)
GAPS_MM = np.geomspace(0.03, 0.5, 7)
PLACES = np.linspace(0.0, 1.0, 9)[1:-1]
BUMPS_MM = (60.0, 120.0)
COGGING_MM, RIPPLE_MM = (4.0, 40.0), (20.0, 80.0)
PULSES_HZ = (0.15, 2.2)
MOST_WAVES = 120
LOADED = (0.06, 0.1, 0.17, 0.3)
"""Shares of the recording that a load may last."""
LEVELS = (0.5, 0.65, 0.8, 0.9)
"""Shares of the largest effort that it may be cut at."""


def axis_columns(problem: Problem) -> list[Column]:
    """Return every column of an axis."""
    signals = problem.signals(0)
    found = [*_own(signals), *_friction(signals), *_along(signals), *_reversals(signals)]
    found += [*_loads(signals), *_clock(signals), *_record(signals), *_odd(signals)]
    return [(term, text, column) for term, text, column in found if np.ptp(column) > 0.0] + [
        ("gravity", "1", np.ones_like(signals["t"]))
    ]


def _own(q: dict[str, Array]) -> Iterator[Column]:
    v = q["v"]
    yield "coulomb", "s", q["s"]
    yield "coulomb", "tanh(v/0.3)", np.tanh(v / 0.3)
    yield "viscous", "v", v
    yield "viscous", "asinh(v/50)", np.arcsinh(v / 50.0)
    yield "inertia", "a", q["a"]


def _friction(q: dict[str, Array]) -> Iterator[Column]:
    v, s, t = q["v"], q["s"], q["t"]
    for fading in FADING_MM_S:
        yield "stribeck", f"s exp(-|v|/{fading:.3g})", s * np.exp(-np.abs(v) / fading)
        yield "stribeck", f"s/(1+(v/{fading:.3g})²)", s / (1.0 + (v / fading) ** 2)
    yield "asymmetry", "s²", s**2
    yield "asymmetry", "|v|", np.abs(v)
    yield "asymmetry", "v²", v**2
    for settling in SETTLING_S:
        fading_away = np.exp(-(t - t[0]) / settling)
        yield "warmup", f"s exp(-t/{settling:.3g})", s * fading_away
        yield "warmup", f"v exp(-t/{settling:.3g})", v * fading_away


def _along(q: dict[str, Array]) -> Iterator[Column]:
    x, s = q["x"], q["s"]
    low, travel = float(x.min()), float(np.ptp(x))
    middle = low + 0.5 * travel
    yield "position_friction", "s x", s * (x - middle)
    yield "position_friction", "s x²", s * (x - middle) ** 2
    for place in low + PLACES * travel:
        yield "position_friction", f"s max(x-{place:.4g},0)", s * np.maximum(x - place, 0.0)
        for wide in BUMPS_MM:
            bump = np.exp(-0.5 * ((x - place) / (0.21 * wide)) ** 2)
            yield "position_friction", f"s bump(x, {place:.4g}, {wide:g})", s * bump
    for period, wave in _waves(x, *RIPPLE_MM):
        yield "position_friction", f"s wave(x, {period:.4g})", s * wave
    for period, wave in _waves(x, *COGGING_MM):
        yield "cogging", f"wave(x, {period:.4g})", wave
    yield "spring", "x", x - middle
    yield "spring", "x²", (x - middle) ** 2
    yield "spring", "x³", (x - middle) ** 3


def _waves(along: Array, shortest: float, longest: float) -> Iterator[tuple[float, Array]]:
    """Sine and cosine at periods that are one turn of the whole way apart, at most MOST_WAVES."""
    whole = float(np.ptp(along))
    turns = np.arange(np.ceil(whole / longest), np.floor(whole / shortest) + 1.0)
    if len(turns) > MOST_WAVES:
        turns = np.linspace(turns[0], turns[-1], MOST_WAVES)
    for n in turns[turns > 0]:
        angle = 2.0 * np.pi * n * along / whole
        yield whole / float(n), np.sin(angle)
        yield whole / float(n), np.cos(angle)


def _reversals(q: dict[str, Array]) -> Iterator[Column]:
    last, way = since_reversal(q["s"], q["x"])
    for length in BUILDING_MM:
        yield "presliding", f"last s exp(-u/{length:.3g})", last * np.exp(-way / length)
    yield "presliding", "last s - s", last - q["s"]
    for gap in GAPS_MM:
        inside = way < gap
        yield "backlash", f"s in the gap {gap:.3g}", q["s"] * inside
        yield "backlash", f"v in the gap {gap:.3g}", q["v"] * inside


def since_reversal(direction: Array, position: Array) -> tuple[Array, Array]:
    """Return the last direction that was not standstill, and the way run since it turned, (n,)."""
    moving = np.abs(direction) > 0.5
    rows = np.maximum.accumulate(np.where(moving, np.arange(len(direction)), 0))
    last = np.sign(direction[rows])
    turned = np.concatenate([[True], np.diff(last) != 0.0])
    start = np.maximum.accumulate(np.where(turned, np.arange(len(last)), 0))
    return last, np.abs(position - position[start])


def _loads(q: dict[str, Array]) -> Iterator[Column]:
    t, a = q["t"], q["a"]
    rate_hz = 1.0 / float(np.median(np.diff(t)))
    if "ya" in q:
        yield "cross_coupling", "y.a", q["ya"]
        for rows in (2, 4, 6, 9):
            yield "cross_coupling", f"mean of y.a over {rows}", _mean(q["ya"], rows)
    jerk = np.gradient(a, t)
    yield "compliance", "da/dt", jerk
    yield "compliance", "d²a/dt²", np.gradient(jerk, t)
    for hz in np.geomspace(10.0, 60.0, 7):
        yield "compliance", f"a of a mass on a spring, {hz:.3g} Hz", _swing(a, hz, rate_hz) - a
    whole, begin = float(np.ptp(t)), float(t[0])
    for share in LOADED:
        for start in np.arange(0.0, 1.0 - share + 1e-9, 0.5 * share):
            inside = (t >= begin + start * whole) & (t <= begin + (start + share) * whole)
            text = f"1 from {start * whole:.4g} to {(start + share) * whole:.4g} s"
            yield "external_load", text, inside.astype(np.float64)


def _mean(values: Array, rows: int) -> Array:
    """The mean of so many rows up to each."""
    padded = np.pad(values, (rows - 1, 0), mode="edge")
    return np.convolve(padded, np.full(rows, 1.0 / rows), mode="valid")


def _swing(a: Array, hz: float, rate_hz: float, damping: float = 0.05) -> Array:
    """The acceleration of a mass that hangs on a spring at ``a``."""
    from scipy.signal import bilinear, lfilter

    w = 2.0 * np.pi * hz
    top, bottom = bilinear([2.0 * damping * w, w**2], [1.0, 2.0 * damping * w, w**2], rate_hz)
    return np.asarray(lfilter(top, bottom, a), dtype=np.float64)


def _clock(q: dict[str, Array]) -> Iterator[Column]:
    t, effort = q["t"] - q["t"][0], q[SIMULATED]
    u = t / t[-1]
    yield "sensor_drift", "t", u
    yield "sensor_drift", "√t", np.sqrt(u)
    for settling in (0.1, 0.2, 0.4):
        yield "sensor_drift", f"exp(-t/{settling * t[-1]:.3g})", np.exp(-u / settling)
    for turns in (0.5, 0.9, 1.5):
        for name, wave in (("sin", np.sin), ("cos", np.cos)):
            yield "sensor_drift", f"{name} of {turns:g} turns", wave(2.0 * np.pi * turns * u)
    for power in (0.6, 1.0, 1.6):
        yield "gain", f"E t^{power:g}", effort * u**power
    for at in np.linspace(0.15, 0.85, 15):
        yield "gain", f"E from {at * t[-1]:.4g} s", effort * (u >= at)


def _record(q: dict[str, Array]) -> Iterator[Column]:
    effort, t = q[SIMULATED], q["t"]
    yield "lag", "dE/dt", np.gradient(effort, t)
    yield "lost_sign", "|E|-E", np.abs(effort) - effort
    for side in (1.0, -1.0):
        largest = float(np.max(side * effort))
        for level in (share * largest for share in LEVELS if largest > 0.0):
            over = np.maximum(side * effort - level, 0.0)
            yield "saturation", f"E beyond {side * level:.3g}", over


def _odd(q: dict[str, Array]) -> Iterator[Column]:
    """What no term of the vocabulary stands for."""
    for period, wave in _waves(q["t"], 1.0 / PULSES_HZ[1], 1.0 / PULSES_HZ[0]):
        yield "unknown", f"wave(t, {period:.4g})", wave
    x = q["x"] - 0.5 * (q["x"].min() + q["x"].max())
    yield "unknown", "x v", x * q["v"]
    for speed in (50.0, 100.0, 200.0):
        pace = np.tanh(np.abs(q["v"]) / speed)
        yield "unknown", f"x tanh(|v|/{speed:g})", x * pace
        yield "unknown", f"tanh(|v|/{speed:g})", pace
    if "y" in q:
        across = (q["y"] - q["y"].min()) / np.ptp(q["y"])
        for power in (0.7, 1.0, 2.0):
            yield "unknown", f"y^{power:g}", across**power
            yield "unknown", f"s y^{power:g}", q["s"] * across**power

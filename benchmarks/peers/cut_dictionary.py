"""An expert's dictionary for a force of a table of cuts: every effect, at grids of its shapes.

A column is (term, text, values (n,)). In the texts F is the simulated force of the component, b
depth, h feed, v cutting speed, others as in `Problem.inputs`.
"""

from collections.abc import Iterator

import numpy as np

from benchmarks.peers.axis_dictionary import Column
from benchmarks.peers.problem import SIMULATED, Array, Problem

THIN_MM = np.geomspace(0.03, 0.12, 4)
PLOUGH_MM = (0.01, 0.02, 0.04)
SPEEDS_M_MIN = (110.0, 160.0, 210.0, 260.0)
BANDS = np.linspace(0.3, 0.7, 5)
NOSE_MM = (0.5, 0.9, 1.5)
SPOTS = (0.05, 0.085, 0.15, 0.25)
"""Shares of the table that a hard spot may last."""


def cut_columns(problem: Problem, channel: int) -> list[Column]:
    """Return every column of a component."""
    signals = problem.signals(channel)
    others = problem.simulated[[i for i in range(len(problem.names)) if i != channel]]
    found = [*_law(signals), *_speed(signals), *_tool(signals), *_spots(signals)]
    found += [*_geometry(signals, others), *_clock(signals), *_odd(signals)]
    return [(term, text, column) for term, text, column in found if np.any(column)]


def _law(q: dict[str, Array]) -> Iterator[Column]:
    force, b, h = q[SIMULATED], q["depth"], q["feed"]
    yield "shear", "F", force
    yield "shear", "b h", b * h
    yield "shear", "b h^0.8", b * h**0.8
    yield "edge_force", "b", b
    for plough in PLOUGH_MM:
        yield "edge_force", f"b (1-exp(-h/{plough:g}))", -b * np.expm1(-h / plough)
    for thin in THIN_MM:
        yield "size_effect", f"F exp(-h/{thin:.2g})", force * np.exp(-h / thin)
        yield "size_effect", f"F/(1+h/{thin:.2g})", force / (1.0 + h / thin)


def _speed(q: dict[str, Array]) -> Iterator[Column]:
    force, v = q[SIMULATED], q["speed"]
    for at in SPEEDS_M_MIN:
        yield "speed_softening", f"F v/(v+{at:g})", force * v / (v + at)
        for wide in (0.3, 0.6, 1.0):
            course = np.tanh(np.log(v / at) / wide)
            yield "speed_softening", f"F tanh(log(v/{at:g})/{wide:g})", force * course
    for at in np.quantile(v, BANDS):
        for wide in (0.12, 0.2, 0.3):
            band = np.cosh(np.log(v / at) / wide) ** -2.0
            yield "built_up_edge", f"F band(v, {at:.4g}, {wide:g})", force * band


def _tool(q: dict[str, Array]) -> Iterator[Column]:
    b, u = q["depth"], q["used"] / max(float(q["used"].max()), 1.0)
    edges = q.get("edge", np.zeros_like(b))
    for power in (0.5, 1.0, 2.0, 5.0):
        yield "tool_wear", f"b used^{power:g}", b * u**power
    for edge in np.unique(edges):
        for power in (0.5, 1.0, 2.0):
            text = f"b used^{power:g} of edge {edge:g}"
            yield "tool_wear", text, b * u**power * (edges == edge)


def _spots(q: dict[str, Array]) -> Iterator[Column]:
    force, n = q[SIMULATED], len(q["number"])
    for share in SPOTS:
        length = max(3, round(share * n))
        for first in range(0, n - length + 1, max(1, length // 3)):
            inside = (np.arange(n) >= first) & (np.arange(n) < first + length)
            yield "hard_spot", f"F in cuts {first + 1} to {first + length}", force * inside


def _geometry(q: dict[str, Array], others: Array) -> Iterator[Column]:
    force, b = q[SIMULATED], q["depth"]
    yield "depth_error", "F/b", force / b
    for number, other in enumerate(others):
        for depth in NOSE_MM:
            text = f"exp(-b/{depth:g})"
            yield "nose_radius", f"other force {number + 1} {text}", other * np.exp(-b / depth)
        yield "deflection", f"F times other force {number + 1}", force * other
    yield "deflection", "F²", force**2
    yield "deflection", "F²/(|F|+500)", force**2 / (np.abs(force) + 500.0)


def _clock(q: dict[str, Array]) -> Iterator[Column]:
    u, force = q["t"] / q["t"][-1], q[SIMULATED]
    drifts = {"1": np.ones_like(u), "t": u, "√t": np.sqrt(u)}
    drifts |= {f"exp(-t/{within:g})": np.exp(-u / within) for within in (0.1, 0.25, 0.6)}
    for turns in (0.5, 1.3):
        drifts[f"sin of {turns:g} turns"] = np.sin(2.0 * np.pi * turns * u)
        drifts[f"cos of {turns:g} turns"] = np.cos(2.0 * np.pi * turns * u)
    for text, course in drifts.items():
        yield "sensor_drift", text, course
    for power in (0.6, 1.0, 1.6):
        yield "gain", f"F t^{power:g}", force * u**power
    for at in np.linspace(0.25, 0.75, 9):
        yield "gain", f"F from {at:.3g} of the time", force * (u >= at)


def _odd(q: dict[str, Array]) -> Iterator[Column]:
    """What no term of the vocabulary stands for."""
    force, u = q[SIMULATED], q["t"] / q["t"][-1]
    for power in (1.0, 2.0, 3.0):
        yield "unknown", f"F z^{power:g}", force * (q["z"] / 300.0) ** power
    for turns in np.arange(3.0, 9.5, 0.5):
        for name, wave in (("sin", np.sin), ("cos", np.cos)):
            yield "unknown", f"F {name} of {turns:g} turns", force * wave(2.0 * np.pi * turns * u)
    for every in (2, 3):
        for first in range(every - 1):
            inside = np.arange(len(u)) % every == first
            yield "unknown", f"F of every {every}. cut from {first + 1}", force * inside
    yield "unknown", "F d", force * q["diameter"]

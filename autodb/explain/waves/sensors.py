"""Candidates of what senses a milled waveform: gains, drifts, heat, crosstalk, a tilted table."""

from collections.abc import Callable, Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.candidates import Candidate, spline
from autodb.explain.waves.world import SimulatedWaves, form, keep_shape

Array = NDArray[np.float64]

KNOTS = 5
SHARES = ("share", "share back")
TILTS = ("a.angle", "c.angle")
BENT, LEVELLED = (1.6, 2.4), (0.15, 0.3, 0.6)
"""Powers of time, and times over that of the recording in which it levels off, of a drift."""
LINE = tuple(f"offset {k}" for k in range(1, 7))
"""Names of the coefficients of a drift with a plain law: two in each of three components."""
HEATED = (0.1, 0.2, 0.4, 0.8, 1.6)
"""Times in which a sensor takes up heat, over the time in the work."""


def _gains(world: SimulatedWaves) -> Iterator[Candidate]:
    """One component scales: by one factor, or by one that changes."""
    one = np.ones((len(world.time), 1))
    curve = spline(world.time, KNOTS)[:, 1:]
    for i, name in enumerate(world.waves.names):
        course = world.sensed[i][:, None]
        forms = (
            form(in_one(world, course, i), names=("factor",)),
            form(in_one(world, course * world.time[:, None], i)),
            form(in_one(world, course * curve, i)),
            form(in_one(world, course * np.column_stack([one, curve]), i)),
        )
        detail = keep_shape(in_one(world, course * curve, i))
        yield Candidate(f"gain {name}", "gain", forms, ("t",), detail=detail)


def in_one(world: SimulatedWaves, course: Array, component: int) -> Array:
    """Return a course (n, k) in one component (C, n, k)."""
    made = np.zeros((*world.simulated.shape, course.shape[-1]))
    made[component] = course
    return made


def _in_some(world: SimulatedWaves, course: Array) -> list[Array]:
    """Return columns of a course (n, k) in each component alone, and in all of them."""
    each = [in_one(world, course, i) for i in range(world.components)]
    return [*each, np.concatenate(each, axis=-1)] if len(each) > 1 else each


def _drift(world: SimulatedWaves) -> Iterator[Candidate]:
    """An offset that follows the clock, in air too: straight, bent, to a level, by any curve."""
    one = np.ones(len(world.time))
    bent = [world.time**power for power in BENT]
    levelled = [-np.expm1(-world.time / share) for share in LEVELLED]
    plain = [np.column_stack([one, world.time])]
    plain += [course[:, None] for course in (one, world.time, *bent, *levelled)]
    curve = spline(world.time, KNOTS)
    forms = [
        form(columns, tries=len(plain), names=names[: columns.shape[-1]])
        for course, names in (*((one, LINE) for one in plain), (curve, ()))
        for columns in _in_some(world, course)
    ]
    detail = keep_shape(_in_some(world, curve)[-1])
    yield Candidate("sensor_drift", "sensor_drift", tuple(forms), ("t",), detail=detail)


def _heat(world: SimulatedWaves) -> Iterator[Candidate]:
    """An offset that rises while chips heat the sensor and relaxes when cutting stops."""
    forms = [
        form(columns, tries=len(HEATED), names=("level",))
        for share in HEATED
        for columns in _in_some(
            world, heated_sensor(world.waves.t_s, world.engaged, share)[:, None]
        )
    ]
    yield Candidate("thermal_drift", "thermal_drift", tuple(forms), ("t", "cut"))


def heated_sensor(t_s: Array, engaged: Array, share: float) -> Array:
    """Return a first-order response (n,) to being in the work, in a share of the time there."""
    rows = np.flatnonzero(engaged > 0.0)
    begin, end = t_s[rows[0]], t_s[rows[-1]]
    seconds = share * (end - begin)
    rise = -np.expm1(-np.clip(t_s - begin, 0.0, end - begin) / seconds)
    return np.asarray(rise * np.exp(-np.maximum(t_s - end, 0.0) / seconds))


def _crosstalk(world: SimulatedWaves) -> Iterator[Candidate]:
    """A component takes a share of what another shows: one way, both ways, or all of all."""
    count = world.components
    if count == 1:
        return
    pairs = [(i, j) for i in range(count) for j in range(count) if i != j]
    made = np.concatenate([in_one(world, world.shown[j][:, None], i) for i, j in pairs], axis=-1)
    both = [[k for k, pair in enumerate(pairs) if set(pair) == {i, j}] for i, j in pairs if i < j]
    forms = [
        *(form(made[..., [k]], tries=len(pairs), names=SHARES[:1]) for k in range(len(pairs))),
        *(form(made[..., two], tries=len(both), names=SHARES) for two in both),
        form(made),
    ]
    yield Candidate("crosstalk", "crosstalk", tuple(forms), world.waves.names, sure=True)


def _weight(world: SimulatedWaves) -> Iterator[Candidate]:
    """A mass on the tilted table weighs. Source: P4."""
    if world.tilted is None:
        return
    weight = world.tilted.columns()[world.kept][..., :1]
    if np.ptp(weight) > 0.0:
        shape = form(weight, names=("mass",))
        yield Candidate("table_gravity", "table_gravity", (shape,), TILTS, sure=True)


def _pull(world: SimulatedWaves) -> Iterator[Candidate]:
    """A mass on the table pulls where it is swung. Source: P4."""
    if world.tilted is None:
        return
    swung = world.tilted.columns()[world.kept][..., 1:]
    if np.ptp(swung) > 0.0:
        shape = form(swung, names=("mass_x", "mass_y", "mass_z"))
        yield Candidate("table_inertia", "table_inertia", (shape,), TILTS, sure=True)


SENSING: dict[str, Callable[[SimulatedWaves], Iterable[Candidate]]] = {
    "gain": _gains, "sensor_drift": _drift, "thermal_drift": _heat, "crosstalk": _crosstalk,
    "table_gravity": _weight, "table_inertia": _pull,
}  # fmt: skip
"""What builds the candidates that sit in what senses the force, by the first word of their keys."""

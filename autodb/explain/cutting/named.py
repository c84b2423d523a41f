"""The effects of the vocabulary that cutting forces may hold, each with its ladder of shapes."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cutting.laws import (
    Columns,
    Curve,
    Law,
    Rows,
    added,
    alike,
    each,
    of_chip,
    only,
    per_depth,
    relative,
    tied,
    values_of,
)
from autodb.explain.cutting.table import Stack
from autodb.explain.suspects import Rung, Suspect
from autodb.terms.chip import size_effect, speed_softening
from autodb.terms.nose import nose_axial, nose_length

Array = NDArray[np.float64]
Allowed = Callable[[Array], bool]

EXPONENTS = (0.1, 0.25, 0.5)
EDGE_ROUNDING_MM = (0.004, 0.02)
"""Thickness over which a rounded edge begins to plough."""
WEAR_POWERS = (0.6, 1.7)
SETTLING = (0.08, 0.3)
"""Time constants of settling as a share of the table's time."""
BAND_WIDTHS = (0.08, 0.14, 0.25, 0.45)
BAND_STEP = 0.8
"""Distance of the centres that are tried, in widths."""
NOSE_MM = (0.2, 0.4, 0.8, 1.2, 2.0)
FLANK = 0.6
"""A band of speeds is one only where both its flanks are seen: what is left of it there at most."""
MOST_EDGES = 40
"""Edges with a rate of their own in the search; with more, only one rate for all."""
CURVE = 5
TURN_BACK = 0.25
"""Share of its rise that a monotone curve may fall back, by scatter. Chosen."""


def named(stack: Stack, own: frozenset[str]) -> list[Suspect]:
    """Return the named effects that a table can tell of; ``own``: terms that are re-tuned."""
    found = [
        *_edge_force(stack, own), *_size_effect(stack), *_speed(stack), *_band(stack),
        *_wear(stack, own), *_depth(stack), *_nose(stack), *_deflection(stack),
        *_drifts(stack), *_gains(stack),
    ]  # fmt: skip
    return [suspect for suspect in found if suspect.rungs]


# Signs


def mostly_positive(columns: Columns) -> Allowed:
    """Return whether the coefficient that does most is positive."""

    def allowed(coefficients: Array) -> bool:
        return bool(coefficients[np.argmax(np.abs(coefficients) * columns.strength)] > 0)

    return allowed


def mostly_negative(columns: Columns) -> Allowed:
    """Return whether the coefficient that does most is negative."""
    positive = mostly_positive(columns)
    return lambda coefficients: not positive(coefficients)


def monotone(curve: Curve, columns: Columns, *, direction: float = 0.0) -> Allowed:
    """Return whether a curve goes one way but for scatter: the components' mean by their weight."""

    def allowed(coefficients: Array) -> bool:
        weight = columns.strength.reshape(-1, curve.width).mean(axis=1)
        mean = weight @ coefficients.reshape(-1, curve.width)
        steps = np.diff(curve.along @ mean)
        net, way = float(steps.sum()), float(np.abs(steps).sum())
        right_way = direction == 0.0 or np.sign(net) == direction
        return bool(right_way and way - abs(net) <= 2.0 * TURN_BACK * abs(net))

    return allowed


# Chip and edge


def _edge_force(stack: Stack, own: frozenset[str]) -> list[Suspect]:
    thickness = stack.known.thickness_mm
    if "edge_force" in own or thickness is None or np.ptp(thickness) == 0:
        return []
    shapes: list[tuple[Array, dict[str, float]]] = [(np.ones_like(thickness), {})]
    shapes += [(-np.expm1(-thickness / h), {"rounding": h}) for h in EDGE_ROUNDING_MM]
    rungs = []
    for values, shape in shapes:
        columns = each(stack, per_depth(stack, values_of(values)))
        rungs.append(Rung(columns, shape, allowed=mostly_positive(columns)))
    return [_suspect("edge_force", rungs, ("cutting.feed", "cutting.depth"))]


def _size_effect(stack: Stack) -> list[Suspect]:
    thickness = stack.known.thickness_mm
    if thickness is None or np.ptp(thickness) == 0:
        return []
    laws = [of_chip(stack, values_of(size_effect(thickness, exponent=m) - 1.0)) for m in EXPONENTS]
    rungs = [
        _grows(spread(stack, law), {"exponent": m})
        for m, law in zip(EXPONENTS, laws, strict=True)
        for spread in (alike, each)
    ]
    curve = Curve(np.log(thickness), CURVE)
    columns = alike(stack, of_chip(stack, curve, curve.width))
    falls = monotone(curve, columns, direction=-1.0)
    rungs.append(Rung(columns, allowed=falls))
    detail = each(stack, of_chip(stack, curve, curve.width))
    return [_suspect("size_effect", rungs, ("cutting.feed",), detail)]


def _speed(stack: Stack) -> list[Suspect]:
    speed = stack.known.speed_m_min
    if speed is None or np.ptp(speed) == 0:
        return []
    rungs = []
    for e in (-0.4, 0.05, 0.5):
        law = of_chip(stack, values_of(speed_softening(speed, exponent=e) - 1.0))
        rungs += [Rung(spread(stack, law), {"exponent": e}) for spread in (alike, each)]
    curve = Curve(np.log(speed), CURVE)
    law = of_chip(stack, curve, curve.width)
    if curve.width > 2:
        for columns in (alike(stack, law), each(stack, law)):
            rungs.append(Rung(columns, allowed=monotone(curve, columns)))
    return [_suspect("speed_softening", rungs, ("cutting.speed",), each(stack, law))]


def bell(speed_m_min: Array, centre_m_min: float, width: float) -> Array:
    """Return the band of speeds of a built-up edge, 1 in its middle, (n,)."""
    off = np.log(speed_m_min / centre_m_min) / width
    return np.asarray(np.exp(-0.5 * off**2), dtype=np.float64)


def _band(stack: Stack) -> list[Suspect]:
    speed = stack.known.speed_m_min
    if speed is None or len(np.unique(speed)) < 4:
        return []
    low, high = np.log(speed.min()), np.log(speed.max())
    rungs = []
    for width in BAND_WIDTHS:
        for centre in np.exp(np.arange(low + 0.5 * width, high, BAND_STEP * width)):
            flanks = bell(np.exp([low, high]), centre, width)
            inside = bell(speed, centre, width)
            if flanks.max() > FLANK or inside.max() < 0.5:
                continue
            law = of_chip(stack, values_of(inside))
            shape = {"centre": float(centre), "width": width}
            rungs += [Rung(s(stack, law), shape, tries=6) for s in (alike, each)]
    curve = Curve(np.log(speed), 2 * CURVE)
    detail = each(stack, of_chip(stack, curve, curve.width))
    return [_suspect("built_up_edge", rungs, ("cutting.speed",), detail)]


# Wear


def _wear(stack: Stack, own: frozenset[str]) -> list[Suspect]:
    time = stack.known.cutting_time_s
    if "tool_wear" in own or time is None or np.ptp(time) == 0:
        return []
    spent = time / float(time.max())
    rungs = []
    for power in (1.0, *WEAR_POWERS):
        shape = {} if power == 1.0 else {"power": power}
        law = per_depth(stack, values_of(spent**power))
        rungs.append(_grows(each(stack, law), shape))
        rungs.append(_grows(each(stack, relative(stack, values_of(spent**power))), shape))
    curve = Curve(time, CURVE)
    if curve.levels is None:
        fresh = curve.at(np.zeros(1)) if time.min() <= 0 else np.zeros((1, curve.width))
        law = per_depth(stack, lambda rows: curve(rows) - fresh, curve.width)
        columns = each(stack, law)
        rungs.append(Rung(columns, allowed=monotone(curve, columns, direction=1.0)))
        rungs += _edge_rungs(stack, spent, curve)
    bow = np.column_stack([spent, spent**2, spent**3])
    detail = each(stack, per_depth(stack, values_of(bow), 3))
    return [_suspect("tool_wear", rungs, ("tool.cutting_time", "tool.edge"), detail)]


def _grows(columns: Columns, shape: dict[str, float]) -> Rung:
    return Rung(columns, shape, allowed=mostly_positive(columns))


def _edge_rungs(stack: Stack, spent: Array, curve: Curve) -> list[Rung]:
    """Return shapes with a rate for each edge, the components in the ratio of the common rate."""
    known = stack.known
    assert known.edge is not None
    if not 2 <= len(known.edges) <= min(MOST_EDGES, len(known) // 4):
        return []
    ratio = wear_ratio(stack, spent)
    member = known.edge[:, None] == known.edges[None, :]
    rungs = []
    for power in (1.0, *WEAR_POWERS):
        law = per_depth(stack, values_of(member * spent[:, None] ** power), len(known.edges))
        rungs.append(_grows(tied(stack, law, ratio), {"power": power}))
    if len(known) > 30 * len(known.edges):
        fresh = curve.at(np.zeros(1)) if spent.min() <= 0 else np.zeros((1, curve.width))

        def shape(rows: Rows) -> Array:
            grown = curve(rows) - fresh
            return np.asarray(member[rows][:, :, None] * grown[:, None, :])

        law = per_depth(
            stack, lambda rows: shape(rows).reshape(-1, len(known.edges) * curve.width),
            len(known.edges) * curve.width,
        )  # fmt: skip
        rungs.append(_grows(tied(stack, law, ratio), {"curved": 1.0}))
    return rungs


def wear_ratio(stack: Stack, spent: Array) -> Array:
    """Return how strongly each component feels wear, (C,), the strongest 1."""
    found = []
    for i in range(len(stack.names)):
        sd = stack.sd[i]
        grown = stack.sign[i] * stack.known.depth_mm * spent
        design = np.column_stack([grown, stack.simulation[i], stack.known.depth_mm]) / sd[:, None]
        difference = (stack.recording[i] - stack.simulation[i]) / sd
        found.append(np.linalg.lstsq(design, difference, rcond=1e-8)[0][0])
    ratio = np.maximum(np.array(found), 0.0)
    most = float(ratio.max())
    return np.asarray(ratio / most if most > 0 else np.ones_like(ratio))


# Engagement


def _depth(stack: Stack) -> list[Suspect]:
    depth = stack.known.depth_mm
    if np.ptp(depth) == 0:
        return []
    laws = [(values_of(depth**-p), {"power": p}) for p in (1.0, 0.8, 1.25)]
    rungs = [Rung(alike(stack, relative(stack, shape)), at) for shape, at in laws]
    curve = Curve(np.log(depth), CURVE)
    detail = each(stack, relative(stack, curve, curve.width))
    return [_suspect("depth_error", rungs, ("cutting.depth",), detail)]


def _nose(stack: Stack) -> list[Suspect]:
    """A nose takes from the axial chip force and gives to the radial; the tangential stays."""
    depth = stack.known.depth_mm
    if np.ptp(depth) == 0 or "force.z" not in stack.names:
        return []
    rungs = [
        Rung(columns, {"radius": radius}, allowed=_turns_away(columns))
        for radius in NOSE_MM
        for columns in (
            nose_columns(stack, radius, longer=False),
            nose_columns(stack, radius, longer=True),
            turned_columns(stack, np.exp(-depth / radius)),
            turned_columns(stack, 1.0 / (1.0 + (depth / radius) ** 2)),
        )
    ]
    curve = Curve(np.log(depth), CURVE)
    detail = each(stack, relative(stack, curve, curve.width))
    return [_suspect("nose_radius", rungs, ("cutting.depth",), detail)]


def nose_columns(stack: Stack, radius_mm: float, *, longer: bool) -> Columns:
    """Return what a nose does to the axial and the radial force, each with a factor of its own.

    ``longer``: also to the tangential one, by the rubbing of a longer edge.
    """
    depth, place = stack.known.depth_mm, stack.names.index
    axial = stack.chip[place("force.z")]
    raw = np.zeros((*stack.simulation.shape, 1))
    raw[place("force.z"), :, 0] = axial * (nose_axial(depth, radius_mm=radius_mm) - 1.0)
    if "force.x" in stack.names:
        x = place("force.x")
        raw[x, :, 0] = stack.sign[x] * np.abs(axial) * _radial(depth, radius_mm)
    if longer and "force.y" in stack.names:
        y, length = place("force.y"), nose_length(depth, radius_mm=radius_mm)
        raw[y, :, 0] = stack.sign[y] * depth * (length - 1.0)
    return _present(stack, raw)


def turned_columns(stack: Stack, angle: Array) -> Columns:
    """Return thrust turned from the axial into the radial force by an angle of each cut (n,)."""
    z = stack.names.index("force.z")
    raw = np.zeros((*stack.simulation.shape, 1))
    raw[z, :, 0] = -stack.simulation[z] * angle
    if "force.x" in stack.names:
        x = stack.names.index("force.x")
        raw[x, :, 0] = stack.sign[x] * np.abs(stack.simulation[z]) * angle
        raw[z, :, 0] = -stack.sign[z] * np.abs(stack.simulation[x]) * angle
    return _present(stack, raw)


def _present(stack: Stack, raw: Array) -> Columns:
    """Return columns (C, n, 1), free for each component that has any."""
    law = Law(lambda rows: raw[:, rows], 1)
    columns = each(stack, law)
    kept = [i for i in range(len(raw)) if np.any(raw[i])]
    return Columns(stack, law, columns.mix[:, :, kept])


def _turns_away(columns: Columns) -> Allowed:
    """Return whether thrust goes from the axial into the radial force, but for scatter."""

    def allowed(coefficients: Array) -> bool:
        felt = coefficients * columns.strength
        return bool(felt.min() > -0.25 * felt.max())

    return allowed


def _radial(depth_mm: Array, radius_mm: float) -> Array:
    angle = np.arccos(1.0 - np.minimum(depth_mm / radius_mm, 1.0))
    return np.asarray(radius_mm * np.sin(angle) ** 2 / (2.0 * depth_mm))


def normal_force(stack: Stack) -> Array:
    """Return the simulated force that bends the tool off the surface [N], (n,).

    The radial one; of all that are there where it is not.
    """
    if "force.x" in stack.names:
        return np.asarray(np.abs(stack.simulation[stack.names.index("force.x")]))
    return np.asarray(np.sqrt(np.sum(stack.simulation**2, axis=0)))


def _deflection(stack: Stack) -> list[Suspect]:
    depth, force = stack.known.depth_mm, normal_force(stack)
    whole = np.sqrt(np.sum(stack.simulation**2, axis=0))
    pressed = force / depth
    if np.ptp(force) <= 0.02 * force.max():
        return []
    shapes: list[tuple[Array, dict[str, float]]] = []
    for name, values in (("pressed", pressed), ("normal", force), ("whole", whole)):
        most = float(values.max())
        shapes += [
            (values / most, {name: 0.0}),
            (values / (1.0 * most + values), {name: 1.0}),
            (values / (0.25 * most + values), {name: 4.0}),
        ]
    rungs = []
    for values, shape in shapes:
        for spread in (alike, each):
            columns = spread(stack, relative(stack, values_of(values)))
            rungs.append(Rung(columns, shape, allowed=mostly_negative(columns)))
    curve = Curve(whole, CURVE)
    detail = each(stack, relative(stack, curve, curve.width))
    return [_suspect("deflection", rungs, tuple(n for n in stack.names if n == "force.x"), detail)]


# Sensors: one component, the others untouched


def clock(stack: Stack) -> Array:
    """Return the time of the cuts over 0 to 1, (n,)."""
    since = stack.known.t_s - stack.known.t_s[0]
    return np.asarray(since / max(float(since[-1]), 1e-300), dtype=np.float64)


def _over_time(stack: Stack) -> list[tuple[Callable[[Rows], Array], int]]:
    t = clock(stack)
    shapes: list[tuple[Callable[[Rows], Array], int]] = [(values_of(t), 1)]
    shapes += [(values_of(-np.expm1(-t / tau)), 1) for tau in SETTLING]
    if len(t) >= 4 * CURVE:
        curve = Curve(t, CURVE)
        shapes.append((curve, curve.width))
    return shapes


def _drifts(stack: Stack) -> list[Suspect]:
    found = []
    for i, name in enumerate(stack.names):
        laws = [added(stack, shape, width) for shape, width in _over_time(stack)]
        rungs = [Rung(only(stack, law, i)) for law in laws]
        free = Curve(clock(stack), 2 * CURVE)
        detail = only(stack, added(stack, free, free.width), i)
        key = f"sensor_drift {name}"
        found.append(_suspect("sensor_drift", rungs, ("t",), detail, key=key))
    return found


def _gains(stack: Stack) -> list[Suspect]:
    if len(stack.names) < 2:
        return []
    found = []
    for i, name in enumerate(stack.names):
        rungs = [Rung(only(stack, relative(stack, s, w), i)) for s, w in _over_time(stack)]
        free = Curve(clock(stack), 2 * CURVE)
        detail = only(stack, relative(stack, free, free.width), i)
        found.append(_suspect("gain", rungs, ("t",), detail, key=f"gain {name}"))
    return found


def _suspect(
    term: str, rungs: list[Rung], variables: tuple[str, ...], detail: Columns | None = None,
    *, key: str = "",
) -> Suspect:  # fmt: skip
    return Suspect(key or term, term, tuple(rungs), variables, detail=detail)

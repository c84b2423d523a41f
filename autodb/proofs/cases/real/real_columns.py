"""What each name would add to an effort: columns with free coefficients, at a few shapes each.

One dictionary serves fair names, peers and the check of answers to nulls. Moves are those that a
recording has, or that are derived from its position.
"""

from collections.abc import Callable

import numpy as np

from autodb.proofs.cases.real.friction_states import gone_at_reversals, rising_after_reversals
from autodb.proofs.cases.real.real_axis import Array, RealAxis

Alternatives = list[Array]
"""Columns (k, n) of each shape that a name is tried at."""
STRIBECK_SPEEDS = (0.05, 0.1, 0.2, 0.4)
"""Shares of the top speed."""
TIMES = (0.1, 0.3, 1.0)
"""Time constants, shares of the duration."""
DISTANCES = (0.001, 0.003, 0.01, 0.03, 0.1)
"""Distances after a reversal, shares of the span."""
MOST_PERIODS = 400.0
"""Within the span, of the finest ripple."""
ROWS_A_PERIOD = 4.0
"""At top speed."""
BINS, PADDED = 4096, 4
"""Places at which a residual is summed up for its spectrum over position, and by how much finer
than a line of that is the grid of periods."""
TRIED_PERIODS = 3
"""How many periods, the strongest ones, are held against others."""
NOT_NEGATIVE = ("coulomb", "viscous", "inertia", "stribeck")
"""Friction and mass."""
EDGES = 8
"""Intervals of a load: from each to each later of nine instants."""
CLIPPED = (0.4, 0.6, 0.8, 0.95)
"""Limits of a clipped effort, shares of the model's peak."""
ELASTIC_SHARES = (1 / 60, 1 / 20, 1 / 8)
"""Natural frequencies, shares of the rate."""
DAMPING = 0.1
"""Of critical, of a drive train. Chosen."""


def columns_of(term: str, axis: RealAxis, model: Array, residual: Array) -> Alternatives:
    """Return the columns of a name at each of its shapes; none where the axis lacks what it needs.

    ``model`` (n,) is what the simulation says, ``residual`` (n,) what it leaves: modifiers act on
    the one, periods are looked for in the other.
    """
    return TRIED[term](axis, model, residual)


def _plain(values: Callable[[RealAxis], Array]) -> Callable[[RealAxis, Array, Array], Alternatives]:
    def columns(axis: RealAxis, _model: Array, _residual: Array) -> Alternatives:
        return [values(axis)[None]]

    return columns


def _asymmetry(axis: RealAxis, _model: Array, _residual: Array) -> Alternatives:
    by_direction, by_speed = np.abs(axis.direction), np.abs(axis.v)
    return [by_direction[None], by_speed[None], np.array([by_direction, by_speed])]


def _stribeck(axis: RealAxis, _model: Array, _residual: Array) -> Alternatives:
    return [stribeck_shape(axis, share)[None] for share in STRIBECK_SPEEDS]


def stribeck_shape(axis: RealAxis, share: float) -> Array:
    """Return what is more at low speed (n,): 1 at a crawl, gone at ``share`` of the top speed."""
    fallen = np.exp(-((axis.v / (share * axis.top_speed)) ** 2))
    return np.asarray(axis.direction * fallen, dtype=np.float64)


def _position_friction(axis: RealAxis, _model: Array, residual: Array) -> Alternatives:
    place = centred(axis)
    linear, squared = axis.direction * place, axis.direction * place**2
    periodic = [axis.direction * wave for wave in _waves(axis, residual * np.sign(axis.direction))]
    return [linear[None], np.array([linear, squared]), *periodic]


def _cogging(axis: RealAxis, _model: Array, residual: Array) -> Alternatives:
    return _waves(axis, residual)


def _waves(axis: RealAxis, residual: Array) -> Alternatives:
    """Return cosine and sine over position (2, n) at the periods that a residual shows most."""
    span = float(np.ptp(axis.position))
    most = min(MOST_PERIODS, span * axis.rate_hz / (ROWS_A_PERIOD * axis.top_speed))
    place = (axis.position - axis.position.min()) / max(span, 1e-12)
    bins = np.round(place * (BINS - 1)).astype(int)
    sums = np.bincount(bins, residual - residual.mean(), minlength=BINS)
    strength = np.abs(np.fft.rfft(sums, PADDED * BINS))
    cycles = np.arange(len(strength)) * (BINS - 1) / (PADDED * BINS)
    inner = np.arange(1, len(strength) - 1)
    peaks = inner[
        (strength[inner] >= strength[inner - 1]) & (strength[inner] > strength[inner + 1])
    ]
    peaks = peaks[(cycles[peaks] >= 2.0) & (cycles[peaks] <= most)]
    best = peaks[np.argsort(strength[peaks])[::-1][:TRIED_PERIODS]]
    turns = 2.0 * np.pi * cycles[best, None] * place
    return [np.array([np.cos(turn), np.sin(turn)]) for turn in turns]


def _cross(axis: RealAxis, _model: Array, _residual: Array) -> Alternatives:
    return [] if axis.other_a is None else [axis.other_a[None]]


def _warmup(axis: RealAxis, _model: Array, _residual: Array) -> Alternatives:
    friction = np.array([axis.direction, axis.v])
    return [friction * fading(axis, share) for share in TIMES]


def fading(axis: RealAxis, share: float) -> Array:
    """Return 1 − e^(−t/T) (n,) from the first row on, T being a share of the duration."""
    passed = axis.t - axis.t[0]
    return np.asarray(1.0 - np.exp(-passed / (share * passed[-1])), dtype=np.float64)


def _presliding(axis: RealAxis, _model: Array, _residual: Array) -> Alternatives:
    span = float(np.ptp(axis.position))
    states = (rising_after_reversals(axis, share * span) for share in DISTANCES)
    return [(state - axis.direction)[None] for state in states]


def _backlash(axis: RealAxis, _model: Array, _residual: Array) -> Alternatives:
    span = float(np.ptp(axis.position))
    return [gone_at_reversals(axis, share * span)[None] for share in DISTANCES]


def _compliance(axis: RealAxis, _model: Array, _residual: Array) -> Alternatives:
    return [elastic_shape(axis, share * axis.rate_hz)[None] for share in ELASTIC_SHARES]


def elastic_shape(axis: RealAxis, natural_hz: float) -> Array:
    """Return by how much a load on a spring accelerates otherwise than its motor (n,), mm/s²."""
    from scipy.signal import bilinear, lfilter

    turn = 2.0 * np.pi * natural_hz
    over, under = [2.0 * DAMPING * turn, turn**2], [1.0, 2.0 * DAMPING * turn, turn**2]
    return np.asarray(lfilter(*bilinear(over, under, axis.rate_hz), axis.a) - axis.a)


def _external_load(axis: RealAxis, _model: Array, _residual: Array) -> Alternatives:
    known = [] if axis.load is None else [axis.load[None]]
    edges = np.linspace(0, len(axis), EDGES + 1).astype(int)
    spans = [(i, j) for i in range(EDGES) for j in range(i + 1, EDGES + 1) if j - i < EDGES]
    return known + [_between(len(axis), edges[i], edges[j])[None] for i, j in spans]


def _between(rows: int, first: int, last: int) -> Array:
    inside = np.zeros(rows)
    inside[first:last] = 1.0
    return inside


def _gain(axis: RealAxis, model: Array, _residual: Array) -> Alternatives:
    passed = (axis.t - axis.t[0]) / np.ptp(axis.t)
    ramps = (passed, np.clip(3.0 * passed - 1.0, 0.0, 1.0), (passed > 0.5).astype(float))
    return [(model * ramp)[None] for ramp in ramps]


def _lag(axis: RealAxis, model: Array, _residual: Array) -> Alternatives:
    return [np.gradient(model, axis.t)[None]]


def _saturation(_axis: RealAxis, model: Array, _residual: Array) -> Alternatives:
    peak = float(np.max(np.abs(model), initial=0.0))
    clipped = (np.clip(model, -share * peak, share * peak) - model for share in CLIPPED)
    return [column[None] for column in clipped if np.any(column)]


def _lost_sign(_axis: RealAxis, model: Array, _residual: Array) -> Alternatives:
    return [(np.abs(model) - model)[None]] if np.any(model < 0.0) else []


def centred(axis: RealAxis) -> Array:
    """Return the position (n,) from the middle of what was visited, −1 to 1."""
    low, high = float(axis.position.min()), float(axis.position.max())
    return np.asarray((2.0 * axis.position - low - high) / max(high - low, 1e-12))


TRIED: dict[str, Callable[[RealAxis, Array, Array], Alternatives]] = {
    "coulomb": _plain(lambda axis: axis.direction),
    "viscous": _plain(lambda axis: axis.v),
    "stribeck": _stribeck,
    "asymmetry": _asymmetry,
    "position_friction": _position_friction,
    "gravity": _plain(lambda axis: np.ones(len(axis))),
    "spring": _plain(centred),
    "cogging": _cogging,
    "inertia": _plain(lambda axis: axis.a),
    "cross_coupling": _cross,
    "warmup": _warmup,
    "presliding": _presliding,
    "backlash": _backlash,
    "compliance": _compliance,
    "external_load": _external_load,
    "gain": _gain,
    "sensor_drift": _plain(lambda axis: (axis.t - axis.t[0]) / np.ptp(axis.t)),
    "lag": _lag,
    "saturation": _saturation,
    "lost_sign": _lost_sign,
}
"""How each name of an axis is tried."""
REAL_TERMS = tuple(TRIED)
"""Names of what an axis' simulation can leave out."""

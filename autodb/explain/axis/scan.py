"""Effects that must be looked for: a period, a stretch of time or travel, a corner of two signals.

With W the whitening filter and r what is left of the difference, any column c has the product
c·(WᵀW r) with the white residual. So the products of thousands of columns come from sums of
WᵀW r over bins and their Fourier transform; their white lengths are read from the filter's response
at the frequency at which the axis passes them.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.explain.axis.loads import load_candidate, told_by_phases
from autodb.explain.axis.signals import AxisSignals
from autodb.explain.axis.unknown import BAR, over_place_and_speed
from autodb.explain.engine.candidates import UNKNOWN, Candidate, CandidateForm
from autodb.explain.engine.locate import strongest_interval
from autodb.explain.engine.noise import Whitener
from autodb.explain.engine.search import MARGIN
from autodb.signals.waves import WhiteSines, strongest_wave, waves_beside

Array = NDArray[np.float64]

FEWEST_WAVES = 2.5
FEWEST_RIPPLES = 5.0
"""Waves over the travel of a further ripple: a few slow ones give any shape. Chosen."""
RIPPLES = (2, 4, 8, 12)
"""Ripples that one cogging is made of; `MOST_RIPPLES` are looked for."""
MOST_RIPPLES = RIPPLES[-1]
SPEED_BINS = 40
BOTH_WAYS = 0.02
"""Share of the rows in each direction, from which on what flips with it is told from what does not.
Chosen."""
SHORTEST_LOAD_S, SHORTEST_LOAD = 0.2, 0.1
"""A load lasts so long, or this share of the recording, where that is less. Chosen."""
INSIDE = 0.02
"""A load begins and ends this share of the recording from its ends; else it is a change."""
FOUND_WITHIN = 0.2
"""Waves over the recording within which a ripple's number of them is found. Chosen."""
CORNER = (12, 6)
PLACES = 60
"""Parts of the travel that a rough stretch is made of."""


@dataclass(frozen=True)
class Left:
    """What is left of the difference at the working rate, (n,), the columns that were fitted to it,
    (n, k), and the filter that whitens it.
    """

    t_s: Array
    position: Array
    velocity: Array
    sense: Array
    left: Array
    beside: Array
    whitener: Whitener
    factor: int
    step_s: float

    @property
    def adjoint(self) -> Array:
        """WᵀW r, (n,)."""
        return self.whitener.adjoint(self.whitener(self.left), len(self.left))

    def power(self, frequency_hz: Array) -> Array:
        """Return |W|² at frequencies, with the averaging over the rows of one working row."""
        full_s = self.step_s / self.factor
        phase = np.pi * frequency_hz * full_s
        with np.errstate(invalid="ignore", divide="ignore"):
            blur = np.sin(self.factor * phase) / (self.factor * np.sin(phase))
        blur = np.where(np.abs(np.sin(phase)) < 1e-9, 1.0, blur)
        return np.asarray(self.whitener.power(frequency_hz * self.step_s) * blur**2)


def proposals_of_axis(signals: AxisSignals, left: Left, number: int) -> list[Candidate]:
    """Return the candidates that what is left points to; ``number`` makes their keys unique."""
    length = _lengths_over_travel(left, float(np.ptp(signals.position)))
    made = [
        _periodic_travel(signals, left, number, length, along=False),
        _periodic_travel(signals, left, number, length, along=True),
        _periodic_time(signals, left, number),
        _load(signals, left, number),
        _rough_place(signals, left, number),
        _corner(signals, left, number, turned=True),
        _corner(signals, left, number, turned=False),
    ]
    return [replace(candidate, scanned=True) for candidate in made if candidate is not None]


def _lengths_over_travel(left: Left, travel: float) -> Callable[[Array], Array]:
    """Return what gives the squared length of a white sine by its number of waves over a travel.

    The axis passes a wave at as many frequencies as it has speeds. Lengths are kept: every search
    asks for those of the same waves.
    """
    share, edges = np.histogram(np.abs(left.velocity), bins=SPEED_BINS)
    middle = 0.5 * (edges[1:] + edges[:-1])
    kept: dict[bytes, Array] = {}

    def length(waves: Array) -> Array:
        asked = waves.tobytes()
        if asked not in kept:
            power = left.power(waves[:, None] * middle / max(travel, 1e-9))
            kept[asked] = np.asarray(0.5 * power @ share)
        return kept[asked]

    return length


def _periodic_travel(
    s: AxisSignals, left: Left, number: int, length: Callable[[Array], Array], *, along: bool
) -> Candidate | None:
    """A ripple over position: cogging, or friction's ripple where it flips with the direction.

    A simulation with cogging of its own is offered no further orders: a lag of these would be some.
    In one direction both are the same, and it is offered as cogging.
    """
    if along and not _turns_back(left):
        return None
    carrier = left.sense if along else np.ones_like(left.sense)
    found = strongest_wave(left.position, carrier * left.adjoint, length, fewest=FEWEST_WAVES)
    if found is None:
        return None
    waves, tries = found
    simulated = "cogging" in s.own
    every = (waves,) if along or simulated else _all_waves(left, waves, tries, length)
    return travel_ripple(s, number, every, tries, along=along)


def _turns_back(left: Left) -> bool:
    """Whether the axis moves in both directions."""
    back, forth = np.mean(left.sense < 0.0), np.mean(left.sense > 0.0)
    return bool(min(back, forth) > BOTH_WAYS)


def _all_waves(
    left: Left, first: float, tries: int, length: Callable[[Array], Array]
) -> tuple[float, ...]:
    """Return the waves over the travel that stand out, a first one and those beside it.

    A motor's cogging has one for each multiple of its slots and of its poles that its magnets are
    not skewed for.
    """
    return waves_beside(
        left.position,
        left.left,
        first,
        WhiteSines(left.whitener, lambda rest: replace(left, left=rest).adjoint, length),
        asked=MARGIN + 2.0 * float(np.log(tries)),
        fewest=FEWEST_RIPPLES,
        most=MOST_RIPPLES,
    )


def travel_ripple(
    s: AxisSignals, number: int, waves: tuple[float, ...], tries: int, *, along: bool
) -> Candidate:
    """Return the candidate of ripples with so many waves over the travel of the recording: of the
    first alone, with its multiples, and of the first with so many more of the others.

    Each was found by itself, so that the period may give by no more than the finest of them allows:
    one that lost its place would fit as well at every wave further on.
    """
    start, travel = float(s.frame.position.min()), float(np.ptp(s.frame.position))
    first = waves[0]
    period = travel / first

    def ripple(orders: tuple[float, ...], period: float) -> Array:
        angle = 2 * np.pi * (s.position - start) / period
        columns = np.column_stack([f(k * angle) for k in orders for f in (np.cos, np.sin)])
        return s.sense[:, None] * columns if along else columns

    def detail() -> Array:
        slow = (s.position - start) / travel - 0.5
        return np.column_stack([ripple((1, 2, 3, 4), period), ripple((1,), period) * slow[:, None]])

    name = "position_friction" if along else "cogging"
    shape = {"period": period}

    def within(most: float) -> dict[str, tuple[float, float]]:
        give = FOUND_WITHIN / most
        return {"period": (period * (1.0 - give), period * (1.0 + give))}

    alone = tuple(
        CandidateForm(
            partial(ripple, o), shape, within(first), names=("cosine", "sine") if o == (1,) else (),
            tries=tries,
        )
        for o in ((1,), (1, 2), (1, 2, 3))
    )  # fmt: skip
    orders = tuple(one / first for one in waves)
    together = tuple(
        CandidateForm(
            partial(ripple, orders[:count]), shape, within(max(waves[:count])),
            names=_names(orders[:count]), tries=float(tries) ** count,
        )
        for count in RIPPLES if count <= len(waves)
    )  # fmt: skip
    return Candidate(
        f"{name} periodic {number}",
        name,
        alone + together,
        (s.channel("position"), s.channel("direction")) if along else (s.channel("position"),),
        detail=detail,
        anew=lambda other: travel_ripple(other, number, waves, tries, along=along),
    )


def _names(orders: tuple[float, ...]) -> tuple[str, ...]:
    """Return what the coefficients of ripples are called: those beside the first by their order."""
    further = (f"{part} {one:.6g}" for one in orders[1:] for part in ("cosine", "sine"))
    return ("cosine", "sine", *further)


def _periodic_time(s: AxisSignals, left: Left, number: int) -> Candidate | None:
    """A load periodic in time, whatever the axis does."""
    span = float(np.ptp(left.t_s))

    def length(waves: Array) -> Array:
        return 0.5 * len(left.t_s) * left.power(waves / span)

    found = strongest_wave(left.t_s, left.adjoint, length, fewest=FEWEST_WAVES)
    if found is None:
        return None
    waves, tries = found

    def ripple(orders: tuple[int, ...], period: float) -> Array:
        angle = 2 * np.pi * (s.t_s - s.t_s[0]) / period
        return np.column_stack([f(k * angle) for k in orders for f in (np.cos, np.sin)])

    period = span / waves
    forms = tuple(
        CandidateForm(
            partial(ripple, orders),
            shape={"period": period},
            within={
                "period": (period * (1 - FOUND_WITHIN / waves), period * (1 + FOUND_WITHIN / waves))
            },
            tries=tries,
        )
        for orders in ((1,), (1, 2), (1, 2, 3))
    )
    return Candidate(f"periodic in time {number}", UNKNOWN, forms, ("t",), bar=BAR)


def _load(s: AxisSignals, left: Left, number: int) -> Candidate | None:
    """The stretch of time in which a constant explains most, beside what was fitted."""
    white, beside = left.whitener(left.left), left.whitener(left.beside)
    start, end, _ = strongest_interval(white, beside, inside=INSIDE)
    t = left.t_s[left.whitener.places(len(left.t_s))]
    low, high = float(t[start]), float(t[min(end, len(t) - 1)])
    if high - low < min(SHORTEST_LOAD_S, SHORTEST_LOAD * float(np.ptp(t))):
        return None
    if told_by_phases(s, low, high):
        return None
    return load_candidate(s, low, high, key=f"external_load {number}")


def _rough_place(s: AxisSignals, left: Left, number: int) -> Candidate | None:
    """A stretch of the travel with other friction: the interval where sgn(v) explains most."""
    span = float(np.ptp(left.position))
    if span <= 0:
        return None
    bins = PLACES
    at = np.minimum((left.position - left.position.min()) / span * bins, bins - 1).astype(np.intp)
    total = np.bincount(at, weights=left.sense * left.adjoint, minlength=bins)
    count = np.bincount(at, weights=np.abs(left.sense), minlength=bins)
    start, end = _best_run(total, count)
    first = float(s.position.min())
    return rough_place(s, number, first + start / bins * span, first + end / bins * span)


def rough_place(s: AxisSignals, number: int, low: float, high: float) -> Candidate:
    """Return the candidate of other friction between two places [mm]."""
    span = float(np.ptp(s.frame.position))
    half = 0.5 * (high - low) + span / PLACES

    def bump() -> Array:
        off = np.clip((s.position - 0.5 * (low + high)) / half, -1, 1)
        return np.asarray(s.sense * 0.5 * (1 + np.cos(np.pi * off)))

    def box() -> Array:
        return np.asarray(s.sense * ((s.position >= low) & (s.position <= high)))

    def beyond() -> Array:
        return s.sense * np.maximum(s.position - low, 0.0) / span

    def before() -> Array:
        return s.sense * np.maximum(high - s.position, 0.0) / span

    tries = PLACES * 6
    return Candidate(
        f"position_friction at {number}",
        "position_friction",
        tuple(CandidateForm(law, tries=tries) for law in (bump, box, beyond, before)),
        (s.channel("position"), s.channel("direction")),
        detail=lambda: np.column_stack([bump(), box(), beyond(), before()]),
        anew=lambda other: rough_place(other, number, low, high),
    )


def _best_run(total: NDArray[Any], count: NDArray[Any]) -> tuple[int, int]:
    """Return the run of bins whose mean differs most from that of the others."""
    left = total - count * total.sum() / max(float(count.sum()), 1e-300)
    sums = np.concatenate([[0.0], np.cumsum(left)])
    weight = np.concatenate([[0.0], np.cumsum(count)])
    inside = weight[None, :] - weight[:, None]
    room = inside * (1 - inside / weight[-1])
    with np.errstate(divide="ignore", invalid="ignore"):
        gain = np.where(room > 1e-6 * weight[-1], (sums[None, :] - sums[:, None]) ** 2 / room, 0.0)
    gain = np.triu(gain, 1)
    start, end = np.unravel_index(int(np.argmax(gain)), gain.shape)
    return int(start), int(end)


def _corner(s: AxisSignals, left: Left, number: int, *, turned: bool) -> Candidate | None:
    """A rectangle of position and speed in which a constant, or sgn(v), explains most."""
    carrier = left.sense if turned else np.ones_like(left.sense)
    speed = np.abs(left.velocity)
    moving = speed > 0.01 * max(float(speed.max()), 1e-9)
    if moving.sum() < 200 or np.ptp(left.position) <= 0:
        return None
    edges_x = np.unique(np.quantile(left.position[moving], np.linspace(0, 1, CORNER[0] + 1)))
    edges_v = np.unique(np.quantile(speed[moving], np.linspace(0, 1, CORNER[1] + 1)))
    if len(edges_x) < 4 or len(edges_v) < 3:
        return None
    weights = np.where(moving, carrier * left.adjoint, 0.0)
    sums = np.histogram2d(left.position, speed, bins=(edges_x, edges_v), weights=weights)[0]
    count = np.histogram2d(
        left.position, speed, bins=(edges_x, edges_v), weights=moving * np.abs(carrier)
    )[0]
    i, j, k, m = _best_rectangle(sums, count)
    (x0, x1), (v0, v1) = (edges_x[i], edges_x[j]), (edges_v[k], edges_v[m])

    def box() -> Array:
        size = np.abs(s.velocity)
        inside = (s.position >= x0) & (s.position <= x1) & (size >= v0) & (size <= v1)
        return np.asarray(inside * (s.sense if turned else 1.0))

    def bump() -> Array:
        size = np.abs(s.velocity)
        at_x = np.clip((s.position - 0.5 * (x0 + x1)) / (x1 - x0), -1, 1)
        at_v = np.clip((size - 0.5 * (v0 + v1)) / (v1 - v0), -1, 1)
        shape = 0.25 * (1 + np.cos(np.pi * at_x)) * (1 + np.cos(np.pi * at_v))
        return np.asarray(shape * (s.sense if turned else np.abs(s.sense)))

    names = (s.channel("position"), s.channel("velocity"))
    return Candidate(
        f"{'direction in a ' if turned else ''}corner of position × speed {number}",
        UNKNOWN,
        tuple(CandidateForm(law, tries=sums.size * 12) for law in (box, bump)),
        (s.channel("direction"), *names) if turned else names,
        detail=lambda: over_place_and_speed(s, turned=turned),
        bar=BAR,
    )


def _best_rectangle(sums: Array, count: Array) -> tuple[int, int, int, int]:
    """Return (i, j, k, m): bins i to j by k to m whose mean differs most from the others'."""
    left = sums - count * sums.sum() / max(float(count.sum()), 1e-300)
    table = np.zeros((left.shape[0] + 1, left.shape[1] + 1))
    weight = np.zeros_like(table)
    table[1:, 1:], weight[1:, 1:] = left.cumsum(0).cumsum(1), count.cumsum(0).cumsum(1)
    best = (0.0, (0, 1, 0, 1))
    for i in range(left.shape[0]):
        for j in range(i + 1, left.shape[0] + 1):
            row, held = table[j] - table[i], weight[j] - weight[i]
            inside = held[None, :] - held[:, None]
            room = inside * (1 - inside / weight[-1, -1])
            with np.errstate(divide="ignore", invalid="ignore"):
                gain = np.where(
                    room > 1e-3 * weight[-1, -1], (row[None, :] - row[:, None]) ** 2 / room, 0.0
                )
            gain = np.triu(gain, 1)
            k, m = np.unravel_index(int(np.argmax(gain)), gain.shape)
            if gain[k, m] > best[0]:
                best = (float(gain[k, m]), (i, j, int(k), int(m)))
    return best[1]

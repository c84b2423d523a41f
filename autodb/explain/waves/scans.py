"""Candidates that must be looked for in what a fit leaves: other material, tones, bands."""

from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.candidates import Candidate, CandidateForm, spline
from autodb.explain.waves.fit import WhitenedNoise
from autodb.explain.waves.world import SimulatedWaves, form, keep_shape, on_each

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

BINS = 200
SHORTEST, LONGEST = 0.02, 0.6
"""Shares of the time in the work that a stretch of other material lasts at least and at most."""
SOFT = (0.02, 0.15, 0.4)
ALONG = 0.1
"""A tone this near a multiple of the spindle's frequency, shares of it, is the spindle's."""
FOLDED = 1.0
"""Multiples of the spindle's turn up to this many sampling rates are looked for where they fold to.
Higher ones are weak; with those up to two rates an eighth of all frequencies was closed. Chosen."""
LOWEST_HZ = 20.0
TONES = 3
"""Tones that are looked for in what a fit leaves, the strongest first; and one that is wide."""
LINE, WIDE = (1,), (3, 7, 15, 31)
"""Frequencies side by side that a tone spreads over: one that is steady, one that wanders."""
ENVELOPES = (1, 4, 8, 16)
"""Coefficients of a tone's slow course of size and phase."""
BANDS = (2.5, 40.0)
"""How often bands come round in the work."""
BAND_BINS = 2000
"""Parts of the time in the work that these are looked for by: 50 of the shortest band."""
NEAR = 512
"""Stretches of a recording in which a frequency half a step off turns by nothing."""


def proposals_of_waves(
    world: SimulatedWaves, left: Array, quiet: WhitenedNoise, number: int
) -> list[Candidate]:
    """Return what a residual (C, n) points to."""
    white = quiet(left[:, :, None]).reshape(world.components, -1)
    forced = quiet(world.simulated[:, :, None]).reshape(white.shape)
    places = quiet.places(left.shape[1])
    inside = world.waves.teeth.engaged[places] > 0.0
    at_work = forced[:, inside], white[:, inside], places[inside]
    found = [_stretch(world, *at_work, number), *_tones(world, white, places, number)]
    return [*found, _bands(world, *at_work, number)]


def _stretch(
    world: SimulatedWaves, force: Array, rest: Array, rows: Rows, number: int
) -> Candidate:
    """Return the stretch in which a factor on all forces, white rows (C, m), explains most."""
    product = np.concatenate([[0.0], np.cumsum(np.sum(force * rest, axis=0))])
    power = np.concatenate([[0.0], np.cumsum(np.sum(force**2, axis=0))])
    edges = np.unique(np.linspace(0, len(rows), BINS + 1).astype(np.intp))
    start, end = _strongest(product, power, edges, len(rows))
    t = world.waves.t_s[rows]
    return hard_spot_of_waves(world, float(t[start]), float(t[end - 1]), f"hard_spot {number}")


def _strongest(product: Array, power: Array, edges: NDArray[np.intp], n: int) -> tuple[int, int]:
    a, b = edges[:, None], edges[None, :]
    span = b - a
    inside = power[b] - power[a]
    rest = np.maximum(inside * (1.0 - inside / power[-1]), 1e-9 * power[-1])
    mean = product[-1] * inside / power[-1]
    gain = (product[b] - product[a] - mean) ** 2 / rest
    gain = np.where((span < SHORTEST * n) | (span > LONGEST * n), -np.inf, gain)
    i, j = np.unravel_index(int(np.argmax(gain)), gain.shape)
    return int(edges[i]), int(edges[j])


def hard_spot_of_waves(world: SimulatedWaves, start_s: float, end_s: float, key: str) -> Candidate:
    """Return the candidate of harder or softer material from one time to another."""
    u = _along(world, start_s, end_s)
    shape = {"start": start_s, "end": end_s}
    forms = tuple(
        form(
            harder_stretch(world, start_s, end_s, number), shape, names=("factor",), tries=BINS * 4
        )
        for number in range(len(SOFT) + 1)
    )
    knots = spline(np.clip(u, -0.2, 1.2), 9) * ((u > -0.2) & (u < 1.2))[:, None]
    return Candidate(
        key,
        "hard_spot",
        forms,
        ("t",),
        detail=keep_shape(world.made[:, :, None] * knots),
        interval=(start_s, end_s),
        scanned=True,
        anew=partial(hard_spot_of_waves, start_s=start_s, end_s=end_s, key=key),
    )


def _along(world: SimulatedWaves, start_s: float, end_s: float) -> Array:
    """Return the way through a stretch at every row, 0 at its start, 1 at its end (n,)."""
    return np.asarray((world.waves.t_s - start_s) / max(end_s - start_s, 1e-9))


def harder_stretch(world: SimulatedWaves, start_s: float, end_s: float, number: int) -> Array:
    """Return what material once as hard again adds over a stretch (C, n, 1).

    ``number``: how its ends rise, by shares SOFT of the stretch, or all of it as an arch.
    """
    u = _along(world, start_s, end_s)
    if number == len(SOFT):
        course = np.where((u > 0) & (u < 1), np.sin(np.pi * np.clip(u, 0.0, 1.0)), 0.0)
    else:
        soft = SOFT[number]
        rise = np.clip(np.minimum(u + 0.5 * soft, 1.0 + 0.5 * soft - u) / soft, 0.0, 1.0)
        course = rise**2 * (3.0 - 2.0 * rise)
    return np.asarray((world.made * course)[:, :, None])


def _tones(world: SimulatedWaves, white: Array, places: Rows, number: int) -> list[Candidate]:
    """Return the strongest tones of white rows (C, m) that are no multiple of the spindle's turn.

    Rows that are missing between them count as nothing.
    """
    pieces = world.timing.pieces
    rate = sum(piece.stop - piece.start - 1 for piece in pieces) / world.measured_s
    turns = world.turns_a_s
    after = _steps_after(world, places, rate)
    n = int(after[-1]) + 1
    window = np.hanning(n)
    whole = np.zeros((len(white), n))
    whole[:, after] = white
    power = np.sum(np.abs(np.fft.rfft(whole * window, axis=1)) ** 2, axis=0)
    frequency = np.fft.rfftfreq(n, 1.0 / rate)
    multiples = np.arange(1, 1 + int(FOLDED * rate / turns)) * turns
    folded = np.abs(multiples - rate * np.round(multiples / rate))
    near = np.min(np.abs(frequency[:, None] - np.unique(folded)[None, :]), axis=1)
    first = np.abs(frequency - turns * np.round(frequency / turns))
    power = np.where(
        (first < ALONG * turns) | (near < 1.5 / (n / rate)) | (frequency < LOWEST_HZ), 0.0, power
    )
    found: list[Candidate] = []
    for k, widths in enumerate((*TONES * (LINE,), WIDE)):
        at, width, worth = standing_out(power, len(white), widths)
        if power[at] <= 0.0:
            break
        exact = float(frequency[at])
        if width == 1:
            exact = _sharpened(white * window[after], after, rate, exact)
            worth = _worth_of_line(white, after, rate, exact)
        tries = n // 2
        if worth > 2.0 * np.log(tries):
            found += tone(world, exact, f"{number}.{k}", tries=tries)
        power[np.abs(frequency - frequency[at]) < (8.0 + width // 2) / (n / rate)] = 0.0
    return found


def standing_out(power: Array, components: int, widths: Sequence[int]) -> tuple[int, int, float]:
    """Return where power (f,) of white rows stands out most, over how many frequencies, and its
    evidence there.

    Twice the log-likelihood ratio of a sum P of k exponentially distributed powers of mean 1 is
    2 (P - k - k ln(P/k)); frequencies with no power are left out.
    """
    open_ = power > 0.0
    some = power / max(float(np.mean(power[open_])) / components, 1e-300) if open_.any() else power
    best, at, wide = -np.inf, 0, widths[0]
    for width in widths:
        window = np.ones(width)
        total = np.convolve(some, window, mode="same")
        count = components * np.maximum(np.convolve(open_, window, mode="same"), 1.0)
        ratio = np.where(open_, _twice_log_ratio(total, count), -np.inf)
        strongest = int(np.argmax(ratio))
        if ratio[strongest] > best:
            best, at, wide = float(ratio[strongest]), strongest, width
    return at, wide, best


def _twice_log_ratio(total: Array, count: Array | int) -> Array:
    more = np.maximum(total / count, 1.0)
    return np.asarray(2.0 * count * (more - 1.0 - np.log(more)))


def _worth_of_line(white: Array, after: Rows, rate_Hz: float, frequency_Hz: float) -> float:
    """Return the evidence of a steady line in white rows (C, m) so many steps after the first."""
    wave = np.exp(-2j * np.pi * frequency_Hz / rate_Hz * after)
    total = np.sum(np.abs(white @ wave) ** 2) / white.shape[1]
    return float(_twice_log_ratio(total, len(white)))


def _steps_after(world: SimulatedWaves, places: Rows, rate_Hz: float) -> Rows:
    """Return how many steps after the first one each of the white rows (m,) is."""
    if len(world.timing.pieces) == 1:
        return np.asarray(places - places[0], dtype=np.intp)
    t = world.waves.t_s[places]
    return np.asarray(np.round((t - t[0]) * rate_Hz), dtype=np.intp)


def _sharpened(windowed: Array, after: Rows, rate_Hz: float, near_Hz: float) -> float:
    """Return the frequency, between those of the transform, at which white rows (C, m), windowed,
    so many steps after the first (m,), have most.

    A line half a step off would look as if it swelled and faded.
    """
    n = int(after[-1]) + 1
    tried = np.linspace(-1.0, 1.0, 41)
    slow = windowed * np.exp(-2j * np.pi * near_Hz / rate_Hz * after)
    stretches = np.linspace(0, len(after), min(NEAR, len(after)), endpoint=False).astype(np.intp)
    sums = np.add.reduceat(slow, stretches, axis=1)
    middle = np.add.reduceat(after, stretches) / np.diff(stretches, append=len(after))
    power = np.sum(np.abs(sums @ np.exp(-2j * np.pi * middle[:, None] / n * tried)) ** 2, axis=0)
    return near_Hz + rate_Hz / n * float(tried[int(np.argmax(power))])


def tone(world: SimulatedWaves, frequency_Hz: float, number: str, *, tries: int) -> list[Candidate]:
    """Return the candidates of a tone: chatter, in the work only, or a hum that air holds too."""
    return [one(world, frequency_Hz, number, tries) for one in (_chatter, _hum)]


def _chatter(world: SimulatedWaves, frequency_Hz: float, number: str, tries: int) -> Candidate:
    """Return a tone in the work, with slow courses of its size and phase."""
    forms = tuple(
        _swelling(world, frequency_Hz, knots, world.engaged, tries=tries) for knots in ENVELOPES
    )
    anew = partial(_chatter, frequency_Hz=frequency_Hz, number=number, tries=tries)
    return Candidate(f"chatter {number}", "chatter", forms, ("t",), scanned=True, anew=anew)


def _hum(world: SimulatedWaves, frequency_Hz: float, number: str, tries: int) -> Candidate:
    """Return a steady tone, in air too."""
    everywhere = np.ones_like(world.engaged)
    forms = (_swelling(world, frequency_Hz, 1, everywhere, tries=tries),)
    anew = partial(_hum, frequency_Hz=frequency_Hz, number=number, tries=tries)
    return Candidate(
        f"unknown tone {number}", "unknown", forms, ("t",), bar=6.0, scanned=True, anew=anew
    )


def _swelling(
    world: SimulatedWaves, frequency_Hz: float, knots: int, inside: Array, *, tries: int
) -> CandidateForm:
    """Return a tone whose size and phase follow so many smooth functions of the time in the work,
    times ``inside`` (n,).
    """
    t = world.waves.t_s
    angle = 2.0 * np.pi * frequency_Hz * t
    waves = np.column_stack([np.cos(angle), np.sin(angle)])
    slow = spline(world.worn, knots) if knots > 3 else np.ones((len(t), 1))
    course = (waves[:, :, None] * (slow * inside[:, None])[:, None, :]).reshape(len(t), -1)
    return form(on_each(world, course), {"frequency": frequency_Hz}, tries=tries)


def _bands(world: SimulatedWaves, force: Array, rest: Array, rows: Rows, number: int) -> Candidate:
    """Return the factor on all forces, white rows (C, m), that comes round and explains most."""
    at = np.minimum((world.worn[rows] * BAND_BINS).astype(np.intp), BAND_BINS - 1)
    product = np.bincount(at, np.sum(force * rest, axis=0), BAND_BINS)
    power = np.bincount(at, np.sum(force**2, axis=0), BAND_BINS)
    u = (np.arange(BAND_BINS) + 0.5) / BAND_BINS
    best, found = 0.0, BANDS[0]
    for count in np.arange(*BANDS, 0.125):
        wave = np.exp(2j * np.pi * count * u)
        waves = np.stack([wave.real, wave.imag])
        inner = (waves * power) @ waves.T
        right = waves @ product
        gain = float(right @ np.linalg.solve(inner, right))
        if gain > best:
            best, found = gain, float(count)
    return _bands_of(world, found, number)


def _bands_of(world: SimulatedWaves, turns: float, number: int) -> Candidate:
    """Return the candidate of a factor on all forces that comes round so often in the work."""
    course = np.zeros((len(world.worn), 4))
    for k in (1, 2):
        wave = np.exp(2j * np.pi * k * turns * world.worn)
        course[:, 2 * k - 2], course[:, 2 * k - 1] = wave.real, wave.imag
    shape = {"turns": turns}
    forms = tuple(
        form(
            world.simulated[:, :, None] * course[:, :width],
            shape,
            tries=int((BANDS[1] - BANDS[0]) / 0.125),
        )
        for width in (2, 4)
    )
    return Candidate(
        f"unknown bands {number}", "unknown", forms, ("x.position",), bar=6.0, scanned=True,
        anew=partial(_bands_of, turns=turns, number=number),
    )  # fmt: skip

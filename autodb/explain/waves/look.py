"""Look for the effects that a milled waveform holds.

How far the depth of a milled cut is off, fitted to a waveform slice by slice.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.candidates import Candidate, Choice
from autodb.explain.engine.search import FAINT, CandidateSearch, FoundSet, settled_set
from autodb.explain.waves.bench import WhitenedNoise, WhiteWaves
from autodb.explain.waves.candidates import candidates_of_waves, deeper
from autodb.explain.waves.fit import BesideWaves
from autodb.explain.waves.runout import fitted_out
from autodb.explain.waves.scans import proposals_of_waves
from autodb.explain.waves.stretches import sharpened
from autodb.explain.waves.teeth import tilted_table
from autodb.explain.waves.waves import Waves, waves_of
from autodb.explain.waves.world import SimulatedWaves, Tilted, own_columns_of_waves
from autodb.records import Recording

Array = NDArray[np.float64]

ROUNDS = 4
EDGED = 0.02
"""Share of a simulation's squares from which on what no chip changes counts as its edge's."""
BAR = 3.0
STILL = 0.02
"""Share by which teeth stand out otherwise, from which on their columns are built anew."""
SMALLEST_MM = 2e-4
SMOOTH_S = 0.02
FAINTEST = 0.002
"""`search.FAINT` of waves whose law is known exactly: shapes are then made of the very chips.
Chosen."""


@dataclass(frozen=True)
class FoundInWaves:
    """What was found, with the world and the bench that it was found on."""

    world: SimulatedWaves
    bench: WhiteWaves
    search: CandidateSearch
    found: FoundSet
    quiet: WhitenedNoise


def look_in_waves(
    recording: Recording, simulation: dict[str, Array], includes: list[str] | None
) -> FoundInWaves:
    """Return the effects that force components of a recording hold beside a simulation (n,)."""
    edged = includes is None or "edge_force" in includes
    waves = waves_of(recording, simulation, edged=edged)
    measured = np.array([recording[name] for name in waves.names])
    world = SimulatedWaves(
        waves=waves,
        has_edge=_has_edge(waves, includes),
        tilted=_tilted(recording),
    )
    return _looked(world, measured)


def _has_edge(waves: Waves, includes: list[str] | None) -> bool:
    if includes is not None:
        return "edge_force" in includes
    edge = waves.seen(waves.teeth.forces(waves.law.of_edge))
    return bool(np.sum(edge**2) > EDGED * np.sum(waves.simulation**2))


def _tilted(recording: Recording) -> Tilted | None:
    """Return how a table is tilted, and its rates, smoothed over SMOOTH_S; None: still."""
    zero = np.zeros(len(recording))
    a, c = (recording.get(f"{name}.angle") for name in "ac")
    tilt, turn = np.radians(zero if a is None else a), np.radians(zero if c is None else c)
    if np.ptp(tilt) == 0.0 and np.ptp(turn) == 0.0:
        return None
    step = 1.0 / recording.rate_hz
    window = max(3, round(SMOOTH_S / step))
    smooth = np.hanning(window + 2)[1:-1]
    smooth /= smooth.sum()

    def rate(values: Array) -> Array:
        padded = np.pad(values, window, mode="edge")
        return np.gradient(np.convolve(padded, smooth, mode="same")[window:-window], step)

    about_x = np.array([np.cos(turn), np.sin(turn), zero])
    omega = rate(tilt) * about_x + rate(turn) * np.array([[0.0], [0.0], [1.0]])
    faster = np.array([rate(one) for one in omega])
    return Tilted(tilted_table(tilt, turn), omega, faster)


def _looked(world: SimulatedWaves, measured: Array) -> FoundInWaves:
    """Return what is found in rounds, each with what scans find in what the last one left.

    Noise comes from everything at first, then from what the found set leaves. Where teeth stand
    out, or the depth is off, otherwise than the columns were made for, these are made anew and the
    round counts for no more.
    """
    bench, standing = _laid_out(world, measured)
    quiet = bench.quiet(bench.everything(standing))
    scanned = proposals_of_waves(world, bench.left(bench.chosen(()), quiet), quiet, 0)
    quiet = bench.quiet(bench.everything([*standing, *scanned]))
    found: tuple[str, ...] | None = None
    for number in range(1, ROUNDS + 1):
        looked = _searched(world, bench, quiet, (*standing, *scanned))
        sharper = sharpened(world, bench, looked.found, quiet)
        scanned = [sharper.get(one.key, one) for one in scanned]
        bench.forget(sharper)
        choices = _anew(looked.found.choices, scanned)
        world, moved = _seen_anew(world, bench, looked.found, quiet)
        if number == ROUNDS or (not moved and looked.found.keys in ((), found)):
            break
        found = looked.found.keys
        if moved:
            bench, standing = _laid_out(world, measured)
            choices = _anew(choices, standing)
        quiet = bench.quiet(
            bench.everything(standing) if moved else bench.chosen(choices, detail=True)
        )
        scanned = [one for one in scanned if one.key in looked.found.keys]
        scanned += _scanned(world, bench, choices, quiet, number)
    return looked


def _scanned(
    world: SimulatedWaves,
    bench: WhiteWaves,
    choices: Sequence[Choice],
    quiet: WhitenedNoise,
    number: int,
) -> list[Candidate]:
    """Return what scans find in what choices leave, and in what those with a name alone leave.

    Families follow a stretch that was not seen beside other effects, and nothing is left of it.
    """
    found = proposals_of_waves(world, bench.left(bench.chosen(choices), quiet), quiet, number)
    known = [choice for choice in choices if choice.candidate.named]
    if len(known) < len(choices):
        left = bench.left(bench.chosen(known), quiet)
        found += proposals_of_waves(world, left, quiet, ROUNDS + number)
    return found


def _searched(
    world: SimulatedWaves, bench: WhiteWaves, quiet: WhitenedNoise, every: Sequence[Candidate]
) -> FoundInWaves:
    """Return the best set of candidates on a bench."""
    asked = [replace(one, bar=one.bar + BAR) for one in every]
    faint = float(np.clip(1.0 - world.waves.fits, FAINTEST, FAINT))
    search = CandidateSearch(bench.products(asked, quiet), asked, faint=faint)
    return FoundInWaves(world, bench, search, _predicting(bench, search, quiet), quiet)


def _anew(choices: Sequence[Choice], standing: Sequence[Candidate]) -> tuple[Choice, ...]:
    """Return choices of candidates that were made anew, in the shapes that they have now."""
    known = {one.key: one for one in standing}
    now = [Choice(known.get(c.candidate.key, c.candidate), c.form) for c in choices]
    return tuple(one for one in now if one.form < len(one.candidate.forms))


def _laid_out(world: SimulatedWaves, measured: Array) -> tuple[WhiteWaves, list[Candidate]]:
    difference = measured - world.waves.simulation
    return WhiteWaves(difference, own_columns_of_waves(world)), candidates_of_waves(world)


def _predicting(bench: WhiteWaves, search: CandidateSearch, quiet: WhitenedNoise) -> FoundSet:
    """Return the best set of which every effect helps to predict stretches of time left out."""
    found = search.cleared(settled_set(search, search.best()))
    while found.choices:
        whole = _squares(bench, found.choices, quiet)
        without = [_squares(bench, found.without(c.candidate.key), quiet) for c in found.choices]
        weakest = int(np.argmin(without))
        if without[weakest] > whole:
            return found
        search.bar(found.choices[weakest])
        found = search.cleared(settled_set(search, search.best()))
    return found


def _squares(bench: WhiteWaves, choices: tuple[Choice, ...], quiet: WhitenedNoise) -> float:
    return float(np.sum(bench.held_out(choices, quiet)[1] ** 2))


def _seen_anew(
    world: SimulatedWaves, bench: WhiteWaves, found: FoundSet, quiet: WhitenedNoise
) -> tuple[SimulatedWaves, bool]:
    """Return the world as what was found has it, and whether its columns are others by now."""
    world, moved = _stood_out(world, bench, found)
    if DEPTH not in found.keys:
        return replace(world, deeper_mm=None), moved or world.deeper_mm is not None
    error_mm = fitted_error(world, bench, found, quiet)
    before = world.deeper_mm or 0.0
    moved |= abs(error_mm - before) > STILL * abs(error_mm)
    return replace(world, deeper_mm=error_mm), moved


def _stood_out(
    world: SimulatedWaves, bench: WhiteWaves, found: FoundSet
) -> tuple[SimulatedWaves, bool]:
    """Return the world with teeth standing out as found, and whether they do otherwise by now."""
    if "runout" not in found.keys:
        return replace(world, out=None), world.out is not None
    known = () if world.out is None else found.without("runout")
    columns = bench.chosen(known)
    out = fitted_out(world, bench.difference, columns)
    before = np.zeros(len(out.mm)) if world.out is None else np.array(world.out.mm)
    now = np.array(out.mm)
    moved = np.max(np.abs(now - before)) > STILL * max(float(np.max(np.abs(now))), SMALLEST_MM)
    return (replace(world, out=out), True) if moved else (world, False)


DEPTH = "depth_error"
REACH = 0.4
"""Share of the error that the search found by which it is looked for to either side."""
STEPS = 20


def fitted_error(
    world: SimulatedWaves, bench: WhiteWaves, found: FoundSet, quiet: WhitenedNoise
) -> float:
    """Return the error of depth, mm, that fits best beside own terms and other effects.

    A simulation's slices come into the work one by one, so that what fits is rough over the error:
    it is tried step by step, then by finer steps about the best.
    """
    beside = BesideWaves(bench, found.without(DEPTH), quiet)
    choice = next(c for c in found.choices if c.candidate.key == DEPTH)
    about = float(beside.fitted(bench.columns(choice.key, choice.shape))[0][0])
    if "error" in choice.shape.shape:
        about = choice.shape.shape["error"]
    reach = REACH * about
    for _ in range(2):
        tried = about + reach * np.linspace(-1.0, 1.0, STEPS + 1)
        gains = [beside.gain(deeper(world, float(e))[:, :, None]) for e in tried]
        about, reach = float(tried[int(np.argmax(gains))]), 2.0 * reach / STEPS
    return about

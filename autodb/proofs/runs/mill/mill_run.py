"""One reference mill: the forces in its cuts, estimated in several ways."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.proofs.machines.mill.reference_mill import (
    TRUTH_HZ,
    MillAxis,
    RecordedMilledCut,
    draw_mill,
    milled_cuts,
    swept_axis,
)
from autodb.proofs.machines.mill.reference_mill_moves import RATE_HZ
from autodb.proofs.runs.mill.mill_ours import identified_mill_axis, loads_A
from autodb.proofs.runs.mill.published_mill import published_four_steps
from autodb.sensing.drives.fit.axis_model import Identified
from autodb.sensing.drives.reconstruct import DriveModel

Array = NDArray[np.float64]
Loads = Mapping[tuple[str, str], Array]
"""Force (n,) by cut and axis, N."""

PUBLISHED, OURS = "as published", "autodb"
TERMS_ALONE, KNOWN = "autodb, its terms alone", "truth of the sweep"
"""Every way; the last one is given all that there was when the sweep was run."""
SCORED = ("x", "y")
"""P0 evaluates these axes."""
SLOW_HZ = 10.0
"""`reconstruct` gives loads up to here unless asked otherwise."""


@dataclass(frozen=True)
class ForceErrors:
    """RMSE of one way in one cut, N: of the force that P0 compares with, up to 120 Hz, and of both
    up to SLOW_HZ.
    """

    way: str
    cut: str
    axis: str
    rmse_N: float
    slow_N: float


@dataclass(frozen=True)
class KeptOfAxis:
    """What autodb keeps of an axis: the form of its cogging and its pole, mm; the mass that it
    moves and the true one, kg.
    """

    axis: str
    form: str
    pole_mm: float
    moved_kg: float
    true_kg: float


def run_mill_gate(seed: int) -> list[ForceErrors]:
    """Tell the cuts of a seed's mill the published way."""
    mill = draw_mill(seed)
    cuts = milled_cuts(seed, mill)
    return force_errors(PUBLISHED, published_forces(seed, mill, cuts), cuts)


def run_mill_forces(seed: int) -> list[ForceErrors | KeptOfAxis]:
    """Tell them in every way, and what autodb keeps of the axes."""
    mill = draw_mill(seed)
    cuts = milled_cuts(seed, mill)
    models = {name: identified_mill_axis(seed, mill[name]) for name in SCORED}
    whole = {name: DriveModel.of(model) for name, model in models.items()}
    kept_terms = {name: replace(model, off_law=None) for name, model in whole.items()}
    ways = {
        PUBLISHED: published_forces(seed, mill, cuts),
        OURS: _newtons(mill, loads_A(whole, cuts, bandwidth_hz=TRUTH_HZ)),
        TERMS_ALONE: _newtons(mill, loads_A(kept_terms, cuts, bandwidth_hz=TRUTH_HZ)),
        KNOWN: known(mill, cuts),
    }
    errors = [one for way, loads in ways.items() for one in force_errors(way, loads, cuts)]
    return [*errors, *(kept_of_axis(models[name], mill[name]) for name in SCORED)]


def kept_of_axis(found: Identified, axis: MillAxis) -> KeptOfAxis:
    """Return what is kept of an axis beside what is true of it."""
    form = next(one for one in found.cogging if one.kept)
    moved_kg = 1000.0 * found.value("inertia") * axis.newtons_per_ampere
    return KeptOfAxis(axis.name, form.called, form.period, moved_kg, axis.moved_kg)


def known(mill: Mapping[str, MillAxis], cuts: list[RecordedMilledCut]) -> Loads:
    """Return what the true laws of the sweep give of the cuts: another day's friction is left."""
    return {
        (one.cut.name, name): one.axes[name].current_A * mill[name].newtons_per_ampere
        - one.air_N[name]
        for one in cuts
        for name in SCORED
    }


def _newtons(mill: Mapping[str, MillAxis], loads: Loads) -> Loads:
    return {(cut, name): mill[name].newtons_per_ampere * one for (cut, name), one in loads.items()}


def published_forces(
    seed: int, mill: Mapping[str, MillAxis], cuts: list[RecordedMilledCut]
) -> Loads:
    """Return the force of each cut and axis by P0's four steps; nothing is filtered."""
    loads = {}
    for name in SCORED:
        scale = mill[name].newtons_per_ampere
        model = published_four_steps(swept_axis(seed, mill[name]), scale)
        for one in cuts:
            seen = one.axes[name]
            air_N = model.air_N(seen.motion.x, seen.motion.v, seen.motion.a)
            loads[one.cut.name, name] = seen.current_A * scale - air_N
    return loads


def force_errors(way: str, loads: Loads, cuts: list[RecordedMilledCut]) -> list[ForceErrors]:
    """Return the errors of a way, from where the feed begins to where it leaves the work."""
    return [
        _errors_of(way, loads[one.cut.name, name], one, name) for one in cuts for name in SCORED
    ]


def _errors_of(way: str, load_N: Array, one: RecordedMilledCut, name: str) -> ForceErrors:
    off_N = load_N - one.load_N[name]
    slow_N = signals.lowpass(off_N, rate_hz=RATE_HZ, cutoff_hz=SLOW_HZ)
    rows = (one.t >= one.begins_s) & (one.t <= one.ends_s)
    return ForceErrors(way, one.cut.name, name, _rms(off_N[rows]), _rms(slow_N[rows]))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))

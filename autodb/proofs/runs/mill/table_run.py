"""A reference table: what P4's model, autodb and an oracle estimate of its cuts."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from autodb.fitting.gaussian import NORMAL_95
from autodb.proofs.machines.mill.reference_table import (
    AXIS_HZ,
    FIXED_KG,
    FORCE_HZ,
    REPEATS,
    TILTS_FIXED_DEG,
    WORK_KG,
    Log,
    RecordedTable,
    TrueTable,
    draw_table,
    mill_on_table,
    record_tilted,
    turned_in_air,
)
from autodb.proofs.runs.mill.published_table import (
    AIR_HZ,
    CUT_HZ,
    RANGES_N,
    Model,
    between,
    envelope_errors,
    filtered,
    model,
    published_envelopes,
    turned_back,
)
from autodb.proofs.runs.mill.table_summary import (
    KNOWN,
    OURS,
    PUBLISHED,
    Judged,
    TableAir,
    TableGate,
    TableHeld,
    TableIdentified,
    TableOff,
)
from autodb.records.tables import Recording
from autodb.sensing.table.engaged import engaged
from autodb.sensing.table.forces import table_forces
from autodb.sensing.table.identify import identify_table
from autodb.sensing.table.kinematics import Kinematics
from autodb.sensing.table.model import TableModel, table_motion

Array = NDArray[np.float64]

TILTED = (1, 2)
"""Set-ups that are not upright."""


def run_table(seed: int) -> list[Judged]:
    """Tell the forces on a seed's table in every way."""
    table = draw_table(seed)
    alone = record_tilted(seed, table, added_kg=0.0)
    fixed = record_tilted(seed, table, added_kg=FIXED_KG, stops_deg=TILTS_FIXED_DEG)
    published = model(alone, fixed, FIXED_KG, table)
    ours = identify_table(
        [table_recording(record_tilted(seed, table, added_kg=WORK_KG))],
        Kinematics(),
        cutoff_hz=AIR_HZ,
    )
    cuts = [mill_on_table(seed, table, setup) for setup in TILTED]
    upright = [mill_on_table(seed, table, 0, repeat) for repeat in range(REPEATS)]
    return [
        *_gates(published, upright, cuts),
        *_cut(published, ours, table, cuts),
        *_airs(published, ours, table, turned_in_air(seed, table)),
        *_identified(ours, table),
    ]


def table_recording(seen: RecordedTable) -> Recording:
    """Return what was recorded as a recording has it."""
    log = seen.log
    channels = {"t": log.t}
    for k, axis in enumerate("ac"):
        channels[f"{axis}.angle"] = log.angle[k]
        channels[f"{axis}.velocity"] = log.rate[k]
        channels[f"{axis}.acceleration"] = log.acceleration[k]
    channels |= {f"force.{axis}": seen.reading_N[k] for k, axis in enumerate("xyz")}
    return Recording(path=Path("table.csv"), channels=channels)


def _gates(
    published: Model, upright: Sequence[RecordedTable], cuts: Sequence[RecordedTable]
) -> Iterator[TableGate]:
    whole = upright[0].whole
    mean, repeats_N, _ = between([published.process_N(one) for one in upright], whole)
    errors = [repeats_N, *(envelope_errors(published.process_N(one), mean, whole) for one in cuts)]
    for setup, error in enumerate(errors):
        for envelope in range(2):
            for k in range(3):
                share = float(error[envelope, k]) / RANGES_N[k]
                yield TableGate(setup, envelope, k, share)


def _cut(
    published: Model, ours: TableModel, table: TrueTable, cuts: Sequence[RecordedTable]
) -> Iterator[TableOff | TableHeld]:
    for setup, seen in zip(TILTED, cuts, strict=True):
        true_N = filtered(seen.true_N, CUT_HZ, FORCE_HZ)
        seen_by_us = table_recording(seen)
        sensed = table_forces(ours, seen_by_us, engaged(seen_by_us), cutoff_hz=CUT_HZ)
        ways = {
            PUBLISHED: published.process_N(seen),
            OURS: sensed.force_N,
            KNOWN: _known(table, seen),
        }
        for way, force_N in ways.items():
            errors = envelope_errors(force_N, published_envelopes(true_N), seen.whole)
            for envelope in range(2):
                for k in range(3):
                    yield TableOff(way, setup, envelope, k, float(errors[envelope, k]))
        half_N = NORMAL_95 * sensed.sd_N[:, seen.engaged]
        within = np.abs(sensed.force_N - true_N)[:, seen.engaged] <= half_N
        yield TableHeld(setup, float(within.mean()), float(np.median(half_N)))


def _airs(
    published: Model, ours: TableModel, table: TrueTable, seen: RecordedTable
) -> Iterator[TableAir]:
    read = filtered(seen.reading_N, AIR_HZ, AXIS_HZ)
    motion = table_motion(table_recording(seen), ours.kinematics, cutoff_hz=AIR_HZ)
    mine = ours.matrix @ ours.added_N(motion.columns()) + ours.zero_N[:, None]
    known = Model(*table.loaded(WORK_KG))
    ways = {
        PUBLISHED: published.added_N(seen.log),
        OURS: mine,
        KNOWN: table.matrix @ known.added_N(_moved(table, seen.log)),
    }
    for way, expected in ways.items():
        errors = np.abs(read - filtered(expected, AIR_HZ, AXIS_HZ)).mean(axis=1)
        for k in range(3):
            yield TableAir(way, k, float(errors[k] / np.ptp(read[k])))


def _identified(ours: TableModel, table: TrueTable) -> Iterator[TableIdentified]:
    mass_kg, lever_m = table.loaded(WORK_KG)
    yield TableIdentified("mass", mass_kg, ours.mass_kg, ours.mass_sd_kg)
    for k, axis in enumerate("xyz"):
        name = f"lever arm {axis}"
        yield TableIdentified(
            name, float(lever_m[k]), float(ours.lever_m[k]), float(ours.lever_sd_m[k])
        )


def _moved(table: TrueTable, log: Log) -> Log:
    """Return the log with the true zeros of its axes."""
    return Log(log.t, log.angle + np.array(table.offsets_deg)[:, None], log.rate, log.acceleration)


def _known(table: TrueTable, seen: RecordedTable) -> Array:
    """Return the force (3, n) estimated by who knows the table, its chips and how it heats.

    How hot it became in this recording, in each component by both time constants, and where its
    zero was, is estimated from the rows in air.
    """
    log = _moved(table, seen.log)
    exact = Model(*table.loaded(WORK_KG))
    warm = [_warmed(seen.chips, one) for one in table.heats_s]
    columns = np.column_stack([*warm, np.ones(len(seen.chips))])
    left = np.linalg.solve(table.matrix, filtered(seen.reading_N, CUT_HZ, FORCE_HZ))
    rest = left - exact.added_N(log)
    air = ~seen.engaged
    sizes, *_ = np.linalg.lstsq(columns[air], rest[:, air].T, rcond=None)
    return turned_back(rest - (columns @ sizes).T, log)


def _warmed(chips: Array, time_s: float) -> Array:
    keep = float(np.exp(-1.0 / (FORCE_HZ * time_s)))
    return np.asarray(signal.lfilter([0.0, 1.0 - keep], [1.0, -keep], chips))

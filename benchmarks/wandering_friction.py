"""How often intervals of an identified axis hold where its friction differs from run to run.

    python -m benchmarks.wandering_friction FIRST_SEED LAST_SEED

Axes of the proof of axis intervals, whose friction wanders besides by 1 to 8 % (one standard
deviation): a share for each stroke, shares of the friction at creep and at speed apart for each
stroke, along the way gone (5 to 40 mm), in time (2 to 10 s); or not at all. True is the friction
that every run has in the mean. The wander is drawn here and shares nothing with the estimator.
Beside it the errors (rms of the axes, in standard deviations of ours) of plain least squares.
"""

import sys
from collections import defaultdict
from multiprocessing import Pool
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.axis.axes import AxisRun, draw_run, parts_A
from autodb.proofs.machines.axis.motion import TrueMotion, coloured
from autodb.proofs.machines.axis.quantities import FRICTION_MM_S, friction_name, quantities
from autodb.proofs.runs.axis.axis_intervals import identified_axis, quantity_intervals
from autodb.records.tables import Recording
from autodb.sensing.drives.fit.axis_model import PlainFit

Array = NDArray[np.float64]

KINDS = ("none", "stroke", "stroke, creep and speed apart", "way", "time")
SIZE = (0.01, 0.08)
WAY_MM, TIME_S = (5.0, 40.0), (2.0, 10.0)
RUBS = ("coulomb", "viscous", "stribeck", "asymmetry", "position_friction")
CREEP = ("coulomb", "stribeck")


def wandering(run: AxisRun, seed: int, kind: str) -> Array:
    """Return what the wander of a kind adds to the current (n,), A."""
    rng = np.random.default_rng([seed, 77, KINDS.index(kind)])
    motion, parts = run.motion, parts_A(run.axis, run.motion)
    creep = sum((parts.get(name, 0.0) for name in CREEP), start=np.zeros_like(motion.t))
    all_A = sum((parts.get(name, 0.0) for name in RUBS), start=np.zeros_like(motion.t))
    size = float(np.exp(rng.uniform(*np.log(SIZE))))
    if kind == "none":
        return np.zeros_like(motion.t)
    if kind == "stroke":
        return size * _by_stroke(rng, motion) * all_A
    if kind == "way":
        gone = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(motion.x)))])
        return size * _along(rng, gone, float(rng.uniform(*WAY_MM))) * all_A
    if kind == "time":
        return size * _along(rng, motion.t, float(rng.uniform(*TIME_S))) * all_A
    apart = size * _by_stroke(rng, motion) * creep
    return apart + 2.0 * size * _by_stroke(rng, motion) * (all_A - creep)


def _by_stroke(rng: np.random.Generator, motion: TrueMotion) -> Array:
    """Return a draw of unit sd for each move from rest to rest, (n,)."""
    moves = np.abs(motion.v) > 0.0
    stroke = np.cumsum(np.diff(moves.astype(int), prepend=0) == 1)
    return np.asarray(rng.standard_normal(stroke[-1] + 1)[stroke])


def _along(rng: np.random.Generator, along: Array, length: float) -> Array:
    """Return a wander of unit sd (n,) correlated over ``length`` of a rising coordinate."""
    step = 0.05 * length
    count = int((along[-1] - along[0]) / step) + 2
    return np.interp(
        along,
        along[0] + step * np.arange(count),
        coloured(rng, count, 1.0, float(np.exp(-step / length))),
    )


def plain_value(plain: PlainFit, name: str) -> float | None:
    """Return a quantity of plain least squares; None of those that it does not have."""
    values = {(t.term, t.parameter): t.value for t in plain.terms}
    own = {"inertia": ("inertia", "coefficient"), "weight": ("gravity", "level")}
    if name in own:
        return values.get(own[name])
    for v in FRICTION_MM_S:
        if name == friction_name(v):
            symmetric = plain.value("coulomb") + plain.value("viscous") * abs(v)
            apart = [t.value for t in plain.terms if t.term == "asymmetry"]
            apart = [*apart, 0.0, 0.0]
            return float(np.sign(v) * symmetric + apart[0] + apart[1] * abs(v))
    return None


Row = tuple[str, str, bool, float, float, float, float | None]


def run(seed: int) -> list[Row]:
    """Return kind, quantity, held, error, sd, truth and error of plain least squares of a seed."""
    drawn, rows = draw_run(seed), list[Row]()
    for kind in KINDS:
        channels = dict(drawn.channels)
        channels["x.current"] = channels["x.current"] + wandering(drawn, seed, kind)
        found = identified_axis(Recording(path=Path(f"axis-{seed}.csv"), channels=channels))
        given = quantity_intervals(found)
        for asked in quantities(drawn.axis, drawn.motion):
            if asked.name not in given:
                continue
            value, low, high = given[asked.name]
            peer = plain_value(found.plain, asked.name)
            rows.append(
                (
                    kind, asked.name, low <= asked.truth <= high, value - asked.truth,
                    (high - low) / 3.92, asked.truth, None if peer is None else peer - asked.truth,
                )
            )  # fmt: skip
    return rows


def main() -> None:
    """Run the seeds and print the table."""
    first, last = (int(word) for word in sys.argv[1:3])
    found: dict[tuple[str, str], list[Row]] = defaultdict(list)
    with Pool(2) as pool:
        for rows in pool.imap(run, range(first, last + 1)):
            for row in rows:
                found[row[0], row[1]].append(row)
                found[row[0], "all"].append(row)
    print("kind | quantity | n | held | rms error/sd | median sd | median |error|, ours | plain's")
    for (kind, name), rows in found.items():
        held = np.mean([r[2] for r in rows])
        ratio = float(np.sqrt(np.mean([(r[3] / r[4]) ** 2 for r in rows])))
        both = [(abs(r[3]), abs(r[6])) for r in rows if r[6] is not None]
        ours, peer = np.median(both, axis=0) if both and name != "all" else (np.nan, np.nan)
        sd = np.median([r[4] for r in rows]) if name != "all" else np.nan
        print(
            f"{kind} | {name} | {len(rows)} | {held:.1%} | {ratio:.2f} | {sd:.3g} | {ours:.3g} | "
            f"{peer:.3g}"
        )


if __name__ == "__main__":
    main()

"""How well raw currents of lathes that share no code with the package are turned into forces.

    python -m tests.by_hand.raw_lathes FIRST_SEED LAST_SEED

Beside ours: ``plain``, a line of force over the rise of the range, whose parts it is told, and an
``oracle``, the lathe's own law fitted to ranges without noise of their own. Printed by operation
and axis: root mean square error, N, and how many of the true forces the 95 % intervals held.
"""

import sys
from collections import defaultdict
from dataclasses import dataclass, field
from multiprocessing import Pool
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.optimize import least_squares

from autodb.agent.ingest.gathering import cuts_of_files
from autodb.agent.sense.calibrating import calibrate_table
from autodb.errors import SetAside, UnusableInput
from autodb.proofs.machines.sample import write_parquet
from autodb.records.tables import CutTable
from autodb.sensing.ranges.calibration import Calibration
from autodb.sensing.ranges.chosen import SensedCut, sense_each
from tests.helpers.raw_lathe import CUTS, STANDARD, Array, Logged, recordings

COMPONENT = {"x": 0, "spindle": 1, "z": 2}
MOVES = {
    "turn": ("spindle", "z"), "face": ("spindle", "x"), "taper": ("spindle", "x", "z"),
}  # fmt: skip


@dataclass
class Score:
    """Errors in N of ours, of those held or not, and of plain and oracle on the same cuts."""

    ours: list[float] = field(default_factory=list)
    held: list[bool] = field(default_factory=list)
    width: list[float] = field(default_factory=list)
    plain: list[float] = field(default_factory=list)
    oracle: list[float] = field(default_factory=list)
    cuts: int = 0

    def add(
        self, sensed: SensedCut, own: list[Calibration], others: dict[str, float], true_N: float
    ) -> None:
        """Add a cut that was sensed, with what the others say of its force."""
        if sensed.by is None or sensed.force_N is None or sensed.sd_N is None:
            return
        common = np.array(sensed.common)
        sd_N = float(np.sqrt(sensed.sd_N**2 + common @ own[sensed.by].shared_covariance @ common))
        self.ours.append(sensed.force_N - true_N)
        self.held.append(abs(self.ours[-1]) <= 1.96 * sd_N)
        self.width.append(1.96 * sd_N)
        for name, force_N in others.items():
            getattr(self, name).append(force_N - true_N)


def write(folder: Path, number: int, one: Logged) -> Path:
    """Write a recording and its side file."""
    cut = one.cut
    path = folder / f"{number:03}.parquet"
    write_parquet(path, one.channels)
    lines = [
        '[recording]\nwork = "C45"\n[tool]\nname = "insert"\n[cut]',
        f'operation = "{cut.operation}"\ndepth_mm = {cut.depth_mm}\nfeed_mm_rev = {cut.feed_mm}',
        f"speed_rpm = {cut.rpm}\nwork_diameter_mm = {cut.diameter_mm}",
    ]
    if cut.operation == "taper":
        lines.append(f"feed_direction_deg = {cut.inward_deg}")
    path.with_suffix(".toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def means(one: Logged, axis: str, *, noisy: bool) -> tuple[float, float, float, float]:
    """Return range in cut and in air, arm and speed, over the outer half of the cut."""
    engaged = np.flatnonzero(one.course.engaged >= 1.0)
    rows = engaged[len(engaged) // 20 : len(engaged) // 2]
    air = slice(0, round((one.cut.air_s - 0.1) * 1000.0))
    range_A = one.ranges[axis]
    if noisy:
        u, v, w = (one.channels[f"{axis}.current.{p}"] for p in "uvw")
        whole = (2.0 * u - v - w) / 3.0 + 1j * (v - w) / np.sqrt(3.0)
        range_A = 2.0 * np.abs(whole)
    return (
        float(np.mean(range_A[rows])), float(np.mean(range_A[air])),
        float(np.mean(one.course.arm_mm[rows])), float(np.mean(one.course.rpm[rows])),
    )  # fmt: skip


def table_of(made: list[Logged], axis: str, *, noisy: bool) -> Array:
    """Return (n, 5): range in cut, in air, arm, speed, true force, of cuts that move the axis."""
    moved = [one for one in made if axis in MOVES[one.cut.operation]]
    true = [float(one.cut.true_N[COMPONENT[axis]]) for one in moved]
    return np.column_stack([np.array([means(one, axis, noisy=noisy) for one in moved]), true])


def plain(known: Array, asked: Array, axis: str) -> Array:
    """Return forces by a line over the rise."""
    arm = known[:, 2] / 1000.0 if axis == "spindle" else np.ones(len(known))
    line = np.polyfit(known[:, 0] - known[:, 1], known[:, 4] * arm, 1)
    to = asked[:, 2] / 1000.0 if axis == "spindle" else np.ones(len(asked))
    return np.asarray(np.polyval(line, asked[:, 0] - asked[:, 1]) / to)


def oracle(known: Array, asked: Array, axis: str) -> Array:
    """Return forces by the lathe's own law, fitted."""
    if axis == "spindle":
        return _spindle_oracle(known, asked)

    def left(p: Array) -> Array:
        return np.asarray(np.hypot(p[0], (known[:, 4] - p[1]) / p[2]) - known[:, 0])

    found = [
        least_squares(left, (0.3, start, 200.0), loss="soft_l1", f_scale=0.3)
        for start in (-400.0, 0.0, 400.0)
    ]
    at = min(found, key=lambda one: one.cost).x
    load = at[2] * np.sqrt(np.maximum(asked[:, 0] ** 2 - at[0] ** 2, 0.0))
    both = np.array([at[1] + load, at[1] - load])
    nearest = np.argmin(np.abs(both - asked[:, 4]), axis=0)  # it knows on which side of the fold
    return np.asarray(np.take_along_axis(both, nearest[None, :], axis=0)[0])


def _spindle_oracle(known: Array, asked: Array) -> Array:
    def torque(p: Array, at: Array) -> Array:
        weak = np.minimum(1.0, p[1] / at[:, 3])
        idle = p[2] + p[3] * at[:, 3] / 1000.0
        squares = np.maximum(at[:, 0] ** 2 - (p[4] * weak) ** 2, 0.0)
        return np.asarray(p[0] * weak * np.sqrt(squares) - idle)

    def left(p: Array) -> Array:
        return torque(p, known) - known[:, 4] * known[:, 2] / 1000.0

    found = [
        least_squares(
            left, (1.2, 1500.0, 4.0, 1.0, field_A), x_scale=(1.0, 1e3, 1.0, 1.0, 10.0),
        )
        for field_A in (0.0, 10.0)
    ]  # fmt: skip
    return torque(min(found, key=lambda one: one.cost).x, asked) / asked[:, 2] * 1000.0


Tables = dict[int, CutTable]
Scores = dict[tuple[str, str], Score]


def imported(seed: int, made: list[Logged]) -> tuple[list[Calibration], Tables]:
    """Return what the first recordings calibrate, and each of the others as a table of one cut.

    What is left out is printed.
    """
    with TemporaryDirectory() as folder:
        files = [write(Path(folder), i, one) for i, one in enumerate(made)]
        known = cuts_of_files(files[:STANDARD], columns=None, tell=_silent)
        done, left_out = calibrate_table(known, axes=tuple(COMPONENT))
        tables = {}
        for i, file in enumerate(files[STANDARD:], start=STANDARD):
            try:
                tables[i] = cuts_of_files([file], columns=None, tell=_silent)
            except (SetAside, UnusableInput) as error:
                left_out.append(f"{file}: {made[i].cut.operation}: {error}")
    for sentence in left_out:
        print(f"lathe {seed}: {sentence.rsplit('/', 1)[-1]}")
    return done, tables


def _silent(_: str) -> None:
    """Tell nothing."""


def run(seed: int, *, cuts: int = CUTS) -> Scores:
    """Return the scores of one lathe by operation and axis."""
    _, made = recordings(seed, cuts)
    done, tables = imported(seed, made)
    scores: Scores = defaultdict(Score)
    for axis in COMPONENT:
        own = [one for one in done if one.axis == axis]
        moves = [i for i, one in enumerate(made) if axis in MOVES[one.cut.operation]]
        asked = [i for i in moves if i >= STANDARD]
        peers = {}
        for rival, noisy in ((plain, True), (oracle, False)):
            known, new = (
                table_of([made[i] for i in rows], axis, noisy=noisy)
                for rows in ([i for i in moves if i < STANDARD], asked)
            )
            peers[rival.__name__] = rival(known, new, axis)
        for row, i in enumerate(asked):
            score = scores[made[i].cut.operation, axis]
            score.cuts += 1
            if i not in tables or not own:
                continue
            (sensed,) = sense_each(tables[i], own)
            others = {name: values[row] for name, values in peers.items()}
            score.add(sensed, own, others, float(made[i].cut.true_N[COMPONENT[axis]]))
    return dict(scores)


def main() -> None:
    """Run the seeds and print the table."""
    seeds = range(int(sys.argv[1]), int(sys.argv[2]) + 1)
    whole: Scores = defaultdict(Score)
    with Pool(min(2, len(seeds))) as pool:
        for found in pool.imap(run, seeds):
            for key, one in found.items():
                for name, values in vars(one).items():
                    setattr(whole[key], name, getattr(whole[key], name) + values)
    print("operation axis    cuts sensed   ours  plain oracle /oracle  held  half width")
    for (operation, axis), one in sorted(whole.items()):
        ours, line, own = (rms(values) for values in (one.ours, one.plain, one.oracle))
        print(
            f"{operation:9} {axis:7} {one.cuts:5} {len(one.ours) / one.cuts:6.1%} {ours:6.1f} "
            f"{line:6.1f} {own:6.1f} {ours / own:7.2f} {np.mean(one.held):6.1%} "
            f"{np.median(one.width):6.1f}"
        )


def rms(values: list[float]) -> float:
    """Return the root mean square of errors."""
    return float(np.sqrt(np.mean(np.square(values)))) if values else float("nan")


if __name__ == "__main__":
    main()

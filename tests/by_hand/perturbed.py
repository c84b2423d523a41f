"""Perturb inputs by next to nothing, and see how far answers move.

`python -m tests.by_hand.perturbed [TIMES [WORD]]` does so many times, for every sample job and for
thirty fixed cases with concealed effects, or those with a word in their name: each measured number
by a relative ROUNDING, and by SLIGHT of its noise. It prints how far numbers moved, in widths of
their intervals, and which names changed.
"""

import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from autodb.assets import kit
from autodb.explain import explain
from autodb.explain.answer import Explanation
from autodb.proofs.cases.plan import FIXED, draw_concealed, planned_case
from autodb.proofs.runs.explain.left_out import tables
from autodb.records.tables import CutTable, Recording
from tests.helpers.expected import LEARNT_FROM, answer

Array = NDArray[np.float64]

ROUNDING, SLIGHT = 1e-9, 1e-3
NOISE = 0.01
"""Scatter of a cut's ranges, as a share of them: what the sample lathe's readings repeat to."""
CASES = 30
TIMES = 50
QUANTITIES = ("force_x_N", "force_y_N", "force_z_N", "torque_N_m", "power_W")
STATED = ("work.", "tool.", "cutting.", "spindle.speed", "reference.")
"""Columns of what is not measured by the machine."""


@dataclass(frozen=True)
class Said:
    """An answer: its names in order, and its numbers, each with the width of its interval."""

    names: tuple[str, ...]
    numbers: dict[str, tuple[float, float]]

    def moved(self, other: "Said") -> float:
        """Return the largest change of a number both have, in widths of its interval."""
        shared = self.numbers.keys() & other.numbers.keys()
        return max(
            (abs(other.numbers[k][0] - self.numbers[k][0]) / self.numbers[k][1] for k in shared),
            default=0.0,
        )


Perturb = Callable[[Array, float], Array]
"""From values and their noise, to values as they would read another time."""


def rounded(seed: int) -> Perturb:
    """Return what a last digit of nine does to each value."""
    rng = np.random.default_rng([seed, 1])
    return lambda values, _: values * (1.0 + ROUNDING * rng.standard_normal(values.shape))


def slightly(seed: int) -> Perturb:
    """Return what a thousandth of the noise does to each value."""
    rng = np.random.default_rng([seed, 2])
    return lambda values, noise: values + SLIGHT * noise * rng.standard_normal(values.shape)


def as_it_is(values: Array, noise: float) -> Array:  # noqa: ARG001
    """Return values as they are."""
    return values


def job(name: str, perturb: Perturb) -> Said:
    """Return what a sample job is predicted to take, learnt from perturbed recordings."""
    with TemporaryDirectory() as folder:
        at = Path(folder)
        for number, recording in enumerate(LEARNT_FROM[name]):
            _perturbed(
                kit("sample_jobs") / recording, at / f"{number}-{Path(recording).name}", perturb
            )
        files = sorted(at.iterdir())
        found = answer(name, at, files)
    numbers = {
        f"{n} {cut['name']} {quantity} {edge}": (
            cut[quantity][edge], cut[quantity]["high"] - cut[quantity]["low"],
        )
        for n, cut in enumerate(found["cuts"]) for quantity in QUANTITIES
        for edge in ("value", "low", "high")
    }  # fmt: skip
    return Said(tuple(cut["name"] for cut in found["cuts"]), numbers)


def _perturbed(path: Path, to: Path, perturb: Perturb) -> None:
    over_time = path.suffix == ".parquet"
    held = pd.read_parquet(path) if over_time else pd.read_csv(path)
    for name in held.columns:
        values = held[name]
        if name in ("cut", "t") or name.startswith(STATED) or values.dtype.kind != "f":
            continue
        level = values.to_numpy(copy=True)
        noise = _noise(level) if over_time else NOISE * float(np.nanmedian(np.abs(level)))
        held[name] = perturb(level, noise)
    if over_time:
        held.to_parquet(to)
    else:
        held.to_csv(to, index=False, float_format="%.17g")


def _noise(values: Array) -> float:
    """Return the scatter of rows that follow each other."""
    return float(np.median(np.abs(np.diff(values))) / (0.6745 * np.sqrt(2.0)))


def case(seed: int, perturb: Perturb) -> Said:
    """Return what is said of a fixed case whose measured channel is perturbed."""
    recording, simulation, includes = _drawn(seed)
    first = _as_drawn(seed)
    if perturb is as_it_is:
        return said(first)
    channels = dict(recording.channels)
    for name, found in first.channels.items():
        channels[name] = perturb(channels[name], found.fit.noise_floor)
    return said(_explained(replace(recording, channels=channels), simulation, includes))


def _explained(recording: Any, simulation: Any, includes: list[str]) -> Explanation:
    return explain(recording, simulation, includes=includes).explanation


@cache
def _as_drawn(seed: int) -> Explanation:
    return _explained(*_drawn(seed))


@cache
def _drawn(seed: int) -> tuple[Recording | CutTable, Recording | CutTable, list[str]]:
    plan = replace(planned_case(seed), wanted=20.0 if seed % 2 else 8.0)
    drawn = draw_concealed(seed, family=FIXED, asked=plan)
    return *tables(drawn), list(drawn.includes)


def said(explained: Explanation) -> Said:
    """Return names and numbers of an explanation; a confidence is a share, 1 wide."""
    names, numbers = list[str](), dict[str, tuple[float, float]]()
    for channel, found in explained.channels.items():
        for cause in found.missing:
            name = f"{channel} {cause.kind} {cause.term}"
            names.append(name)
            numbers[f"{name} confidence"] = (cause.confidence, 1.0)
            for what, value in cause.parameters.items():
                width = value.high - value.low
                for edge in ("value", "low", "high") if width > 0.0 else ():
                    numbers[f"{name} {what} {edge}"] = (getattr(value, edge), width)
    return Said(tuple(names), numbers)


@dataclass(frozen=True)
class Moved:
    """How far an answer moved: by a last digit, and by a thousandth of the noise."""

    name: str
    times: int
    by_rounding: float
    renamed: int
    by_noise: float
    renamed_by_noise: int

    def __str__(self) -> str:
        return (
            f"{self.name}, {self.times} times: by {ROUNDING:g} {self.by_rounding:.1e} of an "
            f"interval, {self.renamed} with other names; by {SLIGHT:g} of the noise "
            f"{self.by_noise:.1e}, {self.renamed_by_noise} with other names"
        )


def moved(name: str, asked: Callable[[Perturb], Said], times: int) -> Moved:
    """Perturb one input ``times`` in either way; return how far its answer moved."""
    first = asked(as_it_is)
    rounding = [asked(rounded(seed)) for seed in range(times)]
    noise = [asked(slightly(seed)) for seed in range(times)]
    return Moved(
        name, times,
        max(first.moved(one) for one in rounding),
        sum(one.names != first.names for one in rounding),
        max(first.moved(one) for one in noise),
        sum(one.names != first.names for one in noise),
    )  # fmt: skip


def inputs() -> Iterator[tuple[str, Callable[[Perturb], Said]]]:
    """Every sample job and the first fixed cases, by name."""
    yield from ((f"sample job {name}", partial(job, name)) for name in LEARNT_FROM)
    yield from ((f"case {seed}", partial(case, seed)) for seed in range(1, CASES + 1))


def _moved(asked: tuple[str, Callable[[Perturb], Said]], times: int) -> Moved:
    return moved(*asked, times)


def main() -> None:
    """Perturb everything, two at a time, and print how far answers moved."""
    times = int(sys.argv[1]) if len(sys.argv) > 1 else TIMES
    word = sys.argv[2] if len(sys.argv) > 2 else ""
    chosen = [one for one in inputs() if word in one[0]]
    with ProcessPoolExecutor(2) as pool:
        found = []
        for one in pool.map(partial(_moved, times=times), chosen):
            print(one, flush=True)
            found.append(one)
    print(
        f"at most {max(one.by_rounding for one in found):.1e} and "
        f"{max(one.by_noise for one in found):.1e} of an interval"
    )


if __name__ == "__main__":
    main()

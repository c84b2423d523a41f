"""A case as a method sees it, without its truth; what a method answers; and the split of the rows.

Arrays end in rows (n,): samples of an axis, or cuts. C is the number of explained channels.
"""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rows = NDArray[np.bool_]

BLOCKS = 10
HELD_OUT_EVERY = 5
GAP_S = 0.25
SIMULATED = "sim"


@dataclass(frozen=True)
class Problem:
    """``names`` of the C explained channels; ``measured`` and ``simulated`` (C, n).

    ``inputs``: signals (n,) by the names that formulas use; ``rate_hz`` is 0 for a table of cuts.
    ``recording`` and ``simulation``: channels (n,) as they would be read from files.
    """

    names: tuple[str, ...]
    measured: Array
    simulated: Array
    inputs: dict[str, Array]
    rate_hz: float
    recording: dict[str, Array]
    simulation: dict[str, Array]

    @property
    def table(self) -> bool:
        """Say whether it is a table of cuts."""
        return self.rate_hz == 0.0

    @property
    def difference(self) -> Array:
        """What is to be explained, (C, n)."""
        return self.measured - self.simulated

    def signals(self, channel: int) -> dict[str, Array]:
        """Return the inputs of a channel: all signals, and its simulation."""
        return {**self.inputs, SIMULATED: self.simulated[channel]}

    def save(self, path: Path) -> None:
        """Write it as .npz."""
        parts = {"input": self.inputs, "recording": self.recording, "simulation": self.simulation}
        arrays = {f"{part}/{name}": v for part, held in parts.items() for name, v in held.items()}
        held: dict[str, Any] = {
            "names": np.array(self.names),
            "measured": self.measured,
            "simulated": self.simulated,
            "rate_hz": np.array(self.rate_hz),
            **arrays,
        }
        np.savez(path, **held)


def load(path: Path) -> Problem:
    """Return a problem that was saved."""
    with np.load(path) as held:
        arrays = {name: held[name] for name in held.files}

    def part(prefix: str) -> dict[str, Array]:
        return {n.removeprefix(prefix): v for n, v in arrays.items() if n.startswith(prefix)}

    return Problem(
        names=tuple(str(name) for name in arrays["names"]),
        measured=arrays["measured"],
        simulated=arrays["simulated"],
        inputs=part("input/"),
        rate_hz=float(arrays["rate_hz"]),
        recording=part("recording/"),
        simulation=part("simulation/"),
    )


@dataclass(frozen=True)
class Part:
    """A piece of an answer as a reader sees it: its term, its text, its share of the correction.

    ``share``: rms of all that the channel has of this term over the rms of its correction.
    """

    channel: str
    term: str
    text: str
    share: float


@dataclass(frozen=True)
class Answer:
    """What a method says: ``correction`` (C, n) is added to the simulation, ``parts`` are read."""

    correction: Array
    parts: tuple[Part, ...] = ()

    def save(self, path: Path, *, seconds: float, version: str) -> None:
        """Write it as .npz with what it took, s, and the version of what made it."""
        parts = json.dumps([asdict(part) for part in self.parts])
        np.savez(
            path,
            correction=self.correction,
            parts=np.array(parts),
            seconds=np.array(seconds),
            version=np.array(version),
        )


def read_answer(path: Path) -> tuple[Answer, float, str]:
    """Return an answer that was saved, what it took, s, and the version of what made it."""
    with np.load(path) as held:
        parts = tuple(Part(**part) for part in json.loads(str(held["parts"])))
        return (
            Answer(held["correction"], parts),
            float(held["seconds"]),
            str(held["version"]),
        )


@dataclass(frozen=True)
class Split:
    """Rows to fit on and rows to choose by, (n,)."""

    fitted: Rows
    held_out: Rows


def split(rows: int, *, gap: int) -> Split:
    """Hold out every fifth of ten contiguous blocks; rows within ``gap`` of it are in neither."""
    block = np.minimum(np.arange(rows) * BLOCKS // rows, BLOCKS - 1)
    held_out = block % HELD_OUT_EVERY == HELD_OUT_EVERY - 1
    near = np.convolve(held_out, np.ones(2 * gap + 1), mode="full")[gap : gap + rows] > 0
    return Split(~near, held_out)


@dataclass(frozen=True)
class Thinned:
    """Fewer rows of a problem: ``of`` reduces (..., n) to (..., m), ``split`` is that of m rows."""

    of: Callable[[Array], Array]
    split: Split


def thinned(problem: Problem, most: int) -> Thinned:
    """Return at most ``most`` rows: averages of neighbours over time, of cuts every k-th."""
    n = problem.measured.shape[1]
    factor = -(-n // most)
    if problem.table:
        return Thinned(lambda values: values[..., ::factor], split(-(-n // factor), gap=0))
    rows = n // factor

    def averaged(values: Array) -> Array:
        whole = values[..., : rows * factor]
        means = whole.reshape(*values.shape[:-1], rows, factor).mean(axis=-1)
        return np.asarray(means, dtype=np.float64)

    gap = int(np.ceil(GAP_S * problem.rate_hz / factor))
    return Thinned(averaged, split(rows, gap=gap))


def squared(values: Array) -> float:
    """Return the mean square."""
    return float(np.mean(values**2))


def rms(values: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))

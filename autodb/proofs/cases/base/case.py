"""What a case is: a recording, a simulation that lacks something, and all that is true of both.

Arrays end in samples or cuts (n,); those of a case with several channels are (channels, n).
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
UNKNOWN = "unknown"


@dataclass(frozen=True)
class Hidden:
    """An effect that the simulation lacks: its size, how clearly it shows, what it adds (..., n).

    ``clarity`` is d: the root of the sum of squares of its whitened part, alone on the machine,
    after projection on what the simulation's own terms cannot follow.
    """

    term: str
    size: float
    clarity: float
    part: Array


@dataclass(frozen=True)
class Rival:
    """One effect at one shape: columns (k, ..., n) with free coefficients."""

    term: str
    columns: Array


@dataclass(frozen=True)
class Case:
    """One recording and its simulation, in tables of channels, and their truth.

    ``wanted``: the clarity asked of each hidden effect; where ``reached`` is false a size that is
    still physical shows less, or beside the others nothing. ``tuning``: the simulation is `true`,
    `mistuned` in one term or `refitted` to this recording. ``interval``: stretch (s, or cut
    numbers) of a hidden effect that has one. ``own``: columns (p, ..., n) of the terms that the
    simulation includes. ``whitened`` makes the true noise white; ``rivals`` are all effects that
    could be hidden, at all shapes.
    """

    seed: int
    kind: str
    wanted: float
    reached: bool
    tuning: str
    channels: dict[str, Array]
    simulation: dict[str, Array]
    includes: tuple[str, ...]
    explained: tuple[str, ...]
    hidden: tuple[Hidden, ...]
    interval: tuple[float, float] | None
    measured: Array
    simulated: Array
    truth: Array
    own: Array
    whitened: Callable[[Array], Array]
    rivals: Callable[[], Iterable[Rival]]

    @property
    def table(self) -> bool:
        """Say whether it is a table of cuts."""
        return "cut" in self.channels

    @property
    def terms(self) -> frozenset[str]:
        """Identifiers of what is hidden; `unknown` for what no identifier stands for."""
        return frozenset(one.term for one in self.hidden)


@dataclass(frozen=True)
class Yardstick:
    """How clearly a part (..., n) shows beside own columns (p, ..., n), under a whitening."""

    basis: Array
    whitened: Callable[[Array], Array]

    @classmethod
    def beside(cls, own: Array, whitened: Callable[[Array], Array]) -> "Yardstick":
        """Own columns are whitened, scaled and made orthonormal; dependent ones are left out."""
        flat = whitened(own).reshape(len(own), -1)
        scale = np.linalg.norm(flat, axis=1)
        q, r = np.linalg.qr((flat / scale[:, None]).T)
        return cls(q[:, np.abs(np.diag(r)) > 1e-9], whitened)

    def left(self, values: Array) -> Array:
        """Whitened values (k, m) of parts (k, ..., n), less what own columns follow."""
        flat = self.whitened(values).reshape(len(values), -1)
        return np.asarray(flat - (flat @ self.basis) @ self.basis.T, dtype=np.float64)

    def clarity(self, part: Array) -> float:
        """Root of the sum of squares of what is left of a part (..., n)."""
        return float(np.linalg.norm(self.left(part[None])))


def size_for(clarity_of: Callable[[float], float], wanted: float, *, most: float) -> float:
    """Size in (0, most] whose clarity, rising with size, is ``wanted``; ``most`` if less shows."""
    from scipy.optimize import brentq

    if clarity_of(most) <= wanted:
        return most
    return float(brentq(lambda size: clarity_of(size) - wanted, 0.0, most, rtol=1e-6, xtol=1e-12))

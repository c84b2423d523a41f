"""`python -m benchmarks.chances [DRAWS [FILE]]`: chances to exceed a limit, beside how often it is.

Truths are drawn from what is believed of a pair: numbers from what any metal may have, errors of
the law in the operation, and what its cuts scatter by. A law is near before a cut is made, and as
likely far or farther off where cuts tell. They are cut by the whole law, and known as a shop knows
them: not at all, from a card that is off, from cuts sensed with gains that are off, or from both.
Of the next cut the chance that its force is above a limit is compared with how often it is. A
column is a limit that is said to be exceeded with that chance, a number how much more often it is,
in points; rows are also told apart by force, of turned and of milled cuts. Learning takes seconds a
draw: what was drawn and learnt is kept in FILE (a pickle of ours), and taken from there.
"""

import pickle
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import shear
from autodb.fitting.gaussian import Gaussian
from autodb.forward.prediction import chance_above, intervals
from autodb.pairs.averaging import learn_averaging
from autodb.pairs.engaged import BY_NAME, Conditions
from autodb.pairs.forecast import expected_means, forecast
from autodb.pairs.observed import Observed, PairCuts
from autodb.pairs.posterior import (
    FAR,
    FARTHER,
    FEWEST,
    NEAR,
    OWN,
    PairPosterior,
    Scatter,
    Shared,
)
from autodb.pairs.prior import CardForces, any_metal, of_card

Array = NDArray[np.float64]

DRAWS, SEED = 2000, 40
INSERT = {
    "nose_radius_mm": 0.8, "kappa_deg": 93.0, "rake_deg": -6.0, "inclination_deg": -6.0,
    "included_deg": 55.0,
}  # fmt: skip
MILL = {"diameter_mm": 10.0, "teeth": 4.0, "helix_deg": 30.0, "rake_deg": 8.0}
OPERATIONS = ("turn", "face", "slot", "side-up", "side-down")
KNOWN = {"nothing": (False, 0), "card": (True, 0), "card, 2 cuts": (True, 2), "6 cuts": (False, 6)}
"""What is known of a pair: whether a card, and how many cuts."""
MORE = 4
"""Draws more for each where no cuts are learnt: these cost little, and a draw's four forces go
together, so that 2000 know a chance of 10 % within 1.3 points only (twice the standard error)."""
SENSED = {"turn": (1, 2), "face": (0, 1)}
CHIPS_MM = np.array([0.03, 0.06, 0.12, 0.25, 0.4])
LEVEL, SHAPE, GAIN, NOISE = 0.12, 0.05, 0.03, 0.02
CHANCES = (0.025, 0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 0.95, 0.975)


FORCES = "force x", "force y", "force z", "torque"


@dataclass(frozen=True)
class Drawn:
    """A pair as it is known, its next cut, and the forces, torque and power (5,) that it took."""

    known: str
    operation: str
    posterior: PairPosterior
    row: Conditions
    forces: Array


def main(draws: int, kept: Path | None = None) -> None:
    """Print the table of what is said and what was."""
    said: dict[str, list[float]] = {}
    unlearnt = {name: known for name, known in KNOWN.items() if not known[1]}
    more = _draws(np.random.default_rng([SEED, 1]), MORE * draws, unlearnt)
    for drawn in chain(_all(draws, kept), more):
        chances = _chances(drawn)
        cut = "turned" if drawn.operation in SENSED else "milled"
        for name in (drawn.known, "all"):
            said.setdefault(name, []).extend(chances)
        for force, one in zip(FORCES, chances, strict=True):
            said.setdefault(f"{drawn.known}: {cut}, {force}", []).append(one)
    print(f"{'known':32}{'n':>7}" + "".join(f"{100 * one:7g} %" for one in CHANCES))
    for name, some in sorted(said.items()):
        off = (100.0 * (np.mean(np.array(some) < one) - one) for one in CHANCES)
        print(f"{name:32}{len(some):7}" + "".join(f"{one:+9.1f}" for one in off))


def _all(draws: int, kept: Path | None) -> list[Drawn]:
    """Return what is drawn, and what is known of it; from the file where it is there."""
    if kept is not None and kept.exists():
        found: list[Drawn] = pickle.loads(kept.read_bytes())
        return found[: draws * len(KNOWN)]
    found = list(_draws(np.random.default_rng(SEED), draws, KNOWN))
    if kept is not None:
        kept.write_bytes(pickle.dumps(found))
    return found


def _draws(
    rng: np.random.Generator, draws: int, known: Mapping[str, tuple[bool, int]]
) -> Iterator[Drawn]:
    for draw in range(draws):
        for name, (card, cuts) in known.items():
            operation = OPERATIONS[draw % len(OPERATIONS)]
            yield _drawn(rng, operation, name, card=card, count=cuts)


def _chances(drawn: Drawn) -> list[float]:
    """Return the chances that were said of more than what forces and torque then were."""
    (said,) = intervals(forecast(drawn.posterior, _cuts(drawn.operation, [drawn.row])))
    above = [
        (one.value > 0.0, chance_above(one, was))
        for one, was in zip(said, drawn.forces.tolist(), strict=True)
    ]
    return [one if upwards else 1.0 - one for upwards, one in above][: len(FORCES)]


def _drawn(rng: np.random.Generator, operation: str, name: str, *, card: bool, count: int) -> Drawn:
    turns = operation in SENSED
    rows = [(_turned if turns else _milled)(rng) for _ in range(count + 1)]
    truth, forces = _truth(rng, _cuts(operation, rows), near=not count)
    posterior = any_metal()
    if card:
        posterior = of_card(_card(rng, truth))
    if count:
        made = _cuts(operation, rows[:count])
        posterior = learn_averaging(posterior, _read(rng, made, forces[:count])).past()
    return Drawn(name, operation, posterior, rows[count], forces[count])


def _cuts(operation: str, rows: list[Conditions]) -> PairCuts:
    tool = INSERT if operation in SENSED else MILL
    return BY_NAME[operation].cuts(tool, rows, called="tool")


def _turned(rng: np.random.Generator) -> Conditions:
    diameter, speed = rng.uniform(30.0, 80.0), rng.uniform(100.0, 250.0)
    return {
        "cutting.feed": rng.uniform(0.1, 0.4), "cutting.depth": rng.uniform(1.0, 3.0),
        "cutting.speed": speed, "work.diameter": diameter,
        "spindle.speed": 1000.0 * speed / (np.pi * diameter),
    }  # fmt: skip


def _milled(rng: np.random.Generator) -> Conditions:
    return {
        "cutting.feed": rng.uniform(0.03, 0.12), "cutting.depth": rng.uniform(1.0, 6.0),
        "cutting.width": rng.uniform(1.0, 8.0), "spindle.speed": rng.uniform(2000.0, 6000.0),
    }  # fmt: skip


def _truth(rng: np.random.Generator, cuts: PairCuts, *, near: bool) -> tuple[Array, Array]:
    """Return the numbers of a drawn pair, and what its cuts take (n, 5).

    ``near``: its law is; else it is as likely far off, or farther off.
    """
    law = NEAR if near else (NEAR, FAR, FARTHER)[rng.choice(3)]
    known: PairPosterior = replace(any_metal(), off_law=law)
    known = known.also((*known.law_errors(cuts.operation), *cuts.assumed))
    drawn = rng.multivariate_normal(known.state.mean, known.state.covariance)
    share = known.scatter.share * np.sqrt(FEWEST / rng.chisquare(FEWEST, 2))
    scatter = Scatter(share, np.full(2, np.inf))  # its own, which it knows
    its = PairPosterior(Gaussian(drawn, known.state.covariance), known.shared, scatter, 0, law)
    score = rng.standard_normal((cuts.elements.count, 5))
    score[:, 3:] = score[:, 1:2]
    own = np.sqrt(forecast(its, cuts).own)
    return drawn[:OWN], expected_means(its, cuts) + own * score


def _card(rng: np.random.Generator, truth: Array) -> CardForces:
    ones, none = np.ones(len(CHIPS_MM)), np.zeros(len(CHIPS_MM))
    forces = shear.per_width(truth, shear.Edge(CHIPS_MM, 100.0 * ones, none, none))[:2]
    off = (1.0 + LEVEL * rng.standard_normal(2))[:, None]
    along, across = forces * off * (1.0 + SHAPE * rng.standard_normal((2, len(CHIPS_MM))))
    return CardForces(CHIPS_MM, along, across, level=LEVEL, shape=SHAPE)


def _read(rng: np.random.Generator, cuts: PairCuts, forces: Array) -> Observed:
    """Return what two sensors with gains that are off read of cuts."""
    sensed, count = SENSED.get(cuts.operation, (0, 1)), len(forces)
    sd = np.tile(NOISE * np.linalg.norm(forces[:, :3], axis=1), 2)
    gains = 1.0 + GAIN * rng.standard_normal((2, 1))
    return Observed(
        cuts=(cuts,),
        cut=np.tile(np.arange(count), 2),
        quantity=np.repeat(sensed, count),
        value=(gains * forces[:, sensed].T).ravel() + sd * rng.standard_normal(2 * count),
        sd=sd,
        common=np.repeat(np.eye(2), count, axis=0),
        shared=tuple(Shared(f"gain {one}", np.array([[GAIN**2]])) for one in sensed),
    )


if __name__ == "__main__":
    main(
        int(sys.argv[1]) if len(sys.argv) > 1 else DRAWS,
        Path(sys.argv[2]) if len(sys.argv) > 2 else None,
    )
